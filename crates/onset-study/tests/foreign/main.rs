//! Blocks of other programs, compared with the energies in their manuals, which are implemented here independently.

mod calculix;
mod febio;
mod felupe;
mod lsdyna;
mod radioss;
mod written;

use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset_study::settings::{MaterialSettings, Program, Settings, law_from, law_of, law_written};
use std::sync::Arc;

/// Builds the material of a block with additional assignments.
fn read(program: Program, block: &str, beside: &[&str]) -> Arc<dyn Hyperelastic> {
    let beside: Vec<String> = beside.iter().map(|text| (*text).to_owned()).collect();
    let reading = law_from(program, "a block", block, &beside).expect("a law");
    let all: Vec<String> = reading.assignments.into_iter().chain(beside).collect();
    let settings = MaterialSettings::of_file("", "", &all).expect("settings");
    settings.build().expect("a material")
}

/// States without symmetry, with a change of volume.
const STATES: [[[f64; 3]; 3]; 3] = [
    [[1.2, 0.1, 0.0], [-0.2, 0.9, 0.3], [0.05, 0.0, 1.05]],
    [[0.8, 0.0, 0.2], [0.1, 1.3, 0.0], [0.0, -0.1, 0.95]],
    [[1.5, 0.4, -0.2], [0.0, 0.8, 0.1], [0.2, 0.0, 0.85]],
];

/// Invariants of a state: `I1bar`, `I2bar`, `J` and principal stretches.
fn invariants(f: &DeformationGradient) -> (f64, f64, f64, [f64; 3]) {
    let i = f.invariants();
    let j = i.jacobian;
    (
        i.first * j.powf(-2.0 / 3.0),
        i.second * j.powf(-4.0 / 3.0),
        j,
        f.principal_stretches(),
    )
}

/// Notes on a block, or the error, as one text.
fn told(program: Program, block: &str, material: Option<&str>) -> String {
    match law_of(program, "a deck", block, material, &[]) {
        Ok(reading) => reading.notes.join("\n"),
        Err(error) => error.to_string(),
    }
}

/// Ogden's sum `sum factor (sum lbar^alpha - 3)` of the isochoric stretches.
fn ogden(f: &DeformationGradient, terms: &[(f64, f64)]) -> f64 {
    let (_, _, j, stretches) = invariants(f);
    let term = |(factor, alpha): &(f64, f64)| {
        let sum: f64 = stretches.iter().map(|l| (l / j.cbrt()).powf(*alpha)).sum();
        factor * (sum - 3.0)
    };
    terms.iter().map(term).sum()
}

/// Five terms of the series of Arruda and Boyce without the modulus, for the square of the locking stretch.
fn chains(f: &DeformationGradient, links: f64) -> f64 {
    let i1 = invariants(f).0;
    let series = [
        0.5,
        1.0 / 20.0,
        11.0 / 1050.0,
        19.0 / 7000.0,
        519.0 / 673_750.0,
    ];
    let terms = (1..=5).zip(series);
    terms
        .map(|(i, a)| a * links.powi(1 - i) * (i1.powi(i) - 3.0_f64.powi(i)))
        .sum()
}

/// Bulk modulus for a shear modulus and Poisson's ratio.
fn bulk(shear: f64, poisson: f64) -> f64 {
    2.0 * shear * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson))
}

fn agrees(law: &dyn Hyperelastic, energy: impl Fn(&DeformationGradient) -> f64) {
    let rest = energy(&DeformationGradient::identity());
    let own_rest = law.undeformed().expect("a reference").energy;
    for state in STATES {
        let f = DeformationGradient::new(state).expect("a state");
        let found = law.response(&f).expect("finite").energy - own_rest;
        let expected = energy(&f) - rest;
        assert!(
            (found - expected).abs() < 1e-10 * expected.abs().max(1e-3),
            "{found} is not {expected}"
        );
    }
}

/// Abaqus Theory Guide, "Hyperelastic material behavior": `sum C_ij (I1bar - 3)^i (I2bar - 3)^j + sum (J - 1)^(2i)/D_i`.
#[test]
fn abaqus_polynomials_have_the_energies_of_the_abaqus_manual() {
    let law = read(
        Program::Abaqus,
        "*HYPERELASTIC, POLYNOMIAL, N=2\n0.2, 0.05, 0.01, -0.003, 0.002, 0.1, 0.4\n",
        &[],
    );
    agrees(&*law, |f| {
        let (i1, i2, j, _) = invariants(f);
        let (x, y) = (i1 - 3.0, i2 - 3.0);
        0.2 * x + 0.05 * y + 0.01 * x * x - 0.003 * x * y
            + 0.002 * y * y
            + (j - 1.0).powi(2) / 0.1
            + (j - 1.0).powi(4) / 0.4
    });
    let law = read(
        Program::Abaqus,
        "*HYPERELASTIC, REDUCED POLYNOMIAL, N=4\n0.5, -0.01, 1e-3, 2D-4, 0.1\n",
        &[],
    );
    agrees(&*law, |f| {
        let (i1, _, j, _) = invariants(f);
        let x = i1 - 3.0;
        0.5 * x - 0.01 * x.powi(2) + 1e-3 * x.powi(3) + 2e-4 * x.powi(4) + (j - 1.0).powi(2) / 0.1
    });
    let law = read(
        Program::Abaqus,
        "*HYPERELASTIC, POLYNOMIAL, N=3\n0.2, 0.05, 0.01, -0.003, 0.002, 1e-3, 2e-3, 3e-3\n4e-3, 0.1, 0.0, 0.0\n",
        &[],
    );
    agrees(&*law, |f| {
        let (i1, i2, j, _) = invariants(f);
        let (x, y) = (i1 - 3.0, i2 - 3.0);
        0.2 * x + 0.05 * y + 0.01 * x * x - 0.003 * x * y
            + 0.002 * y * y
            + 1e-3 * x.powi(3)
            + 2e-3 * x * x * y
            + 3e-3 * x * y * y
            + 4e-3 * y.powi(3)
            + (j - 1.0).powi(2) / 0.1
    });
    for (block, c01) in [
        ("*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.02", 0.1),
        (
            "*HYPERELASTIC, NEO HOOKE,\nMODULI=LONG TERM\n0.4, 0.02",
            0.0,
        ),
        ("*HYPERELASTIC, YEOH\n0.4, 0, 0, 0.02, 0, 0", 0.0),
    ] {
        let law = read(Program::Abaqus, block, &[]);
        agrees(&*law, |f| {
            let (i1, i2, j, _) = invariants(f);
            0.4 * (i1 - 3.0) + c01 * (i2 - 3.0) + (j - 1.0).powi(2) / 0.02
        });
    }
}

/// Ogden's law: `sum 2 mu_i/alpha_i^2 (sum lbar^alpha_i - 3)` in Abaqus, `sum mu_i/alpha_i (...)` in ANSYS.
#[test]
fn ogden_blocks_of_abaqus_and_ansys_have_the_energies_of_their_manuals() {
    let law = read(
        Program::Abaqus,
        "*HYPERELASTIC, OGDEN, N=2\n0.4, 1.3, 0.01, 5.0, 0.02, 0.3",
        &[],
    );
    agrees(&*law, |f| {
        let j = f.jacobian() - 1.0;
        ogden(f, &[(0.8 / 1.69, 1.3), (0.02 / 25.0, 5.0)]) + j.powi(2) / 0.02 + j.powi(4) / 0.3
    });
    let law = read(
        Program::Ansys,
        "TB,HYPER,1,,2,OGDEN  ! two terms\nTBDATA,1,0.4,1.3\nTBDATA,3,0.01,5.0\nTBDATA,5,0.02\n",
        &[],
    );
    agrees(&*law, |f| {
        ogden(f, &[(0.4 / 1.3, 1.3), (0.01 / 5.0, 5.0)]) + (f.jacobian() - 1.0).powi(2) / 0.02
    });
}

/// Foams: `2 mu/alpha^2 (sum l^alpha - 3 + (J^(-alpha beta) - 1)/beta)` in Abaqus with Poisson's ratios, `mu/alpha (...)` in ANSYS with `beta`.
#[test]
fn foam_blocks_of_abaqus_and_ansys_have_the_energies_of_their_manuals() {
    let foam = |f: &DeformationGradient, factor: f64, alpha: f64, beta: f64| {
        let (_, _, j, stretches) = invariants(f);
        let sum: f64 = stretches.iter().map(|l| l.powf(alpha)).sum();
        factor * (sum - 3.0 + (j.powf(-alpha * beta) - 1.0) / beta)
    };
    let law = read(
        Program::Abaqus,
        "*HYPERFOAM, N=2\n1.85, 4.5, 0.2, -2.0, 0.1, 0.3",
        &[],
    );
    agrees(&*law, |f| {
        foam(f, 2.0 * 1.85 / 20.25, 4.5, 0.125) + foam(f, 2.0 * 0.2 / 4.0, -2.0, 0.75)
    });
    let law = read(
        Program::Ansys,
        "TB,HYPER,1,,2,FOAM\nTBDATA,1,1.85\nTBDATA,2,4.5\nTBDATA,3,-9.20\nTBDATA,4,-4.5\nTBDATA,5,0.92\nTBDATA,6,0.92\n",
        &[],
    );
    agrees(&*law, |f| {
        foam(f, 1.85 / 4.5, 4.5, 0.92) + foam(f, 9.20 / 4.5, -4.5, 0.92)
    });
}

/// Kilian's energy as in Abaqus, `mu (-(lm^2 - 3)(ln(1 - h) + h) - 2/3 a ((I - 3)/2)^(3/2)) + ((J^2 - 1)/2 - ln J)/D`. The shear modulus in the
/// reference configuration is `mu`.
#[test]
fn abaqus_van_der_waals_has_the_energy_of_the_abaqus_manual() {
    let law = read(
        Program::Abaqus,
        "*HYPERELASTIC, VAN DER WAALS\n0.434, 10.24, 0.32, 0.958, 0.002",
        &[],
    );
    agrees(&*law, |f| {
        let (i1, i2, j, _) = invariants(f);
        let i = (1.0 - 0.958) * i1 + 0.958 * i2 - 3.0;
        let m: f64 = 10.24 * 10.24 - 3.0;
        let h = (i / m).sqrt();
        0.434 * (-m * ((1.0 - h).ln() + h) - 2.0 / 3.0 * 0.32 * (i / 2.0).powf(1.5))
            + ((j * j - 1.0) / 2.0 - j.ln()) / 0.002
    });
    let shear = law.undeformed().expect("a reference").tangent[(0, 1, 0, 1)];
    assert!((shear / 0.434 - 1.0).abs() < 1e-6, "{shear}");
}

/// Gasser, Ogden and Holzapfel, J. R. Soc. Interface 3 (2006) 15: `E = k (I1bar - 3) + (1 - 3 k)(I4bar - 1)`, if it is positive.
#[test]
fn abaqus_dispersed_fibers_have_the_energy_of_gasser_ogden_and_holzapfel() {
    let block = "*ANISOTROPIC HYPERELASTIC, HOLZAPFEL, LOCAL DIRECTIONS=2\n7.64, 0.02, 996.6, 0.5246, 0.226\n";
    let beside = [
        "material.fiber1-angle=49.98",
        "material.fiber2-angle=-49.98",
    ];
    let law = read(Program::Abaqus, block, &beside);
    agrees(&*law, |f| {
        let (i1, _, j, _) = invariants(f);
        let mut energy = 7.64 * (i1 - 3.0) + ((j * j - 1.0) / 2.0 - j.ln()) / 0.02;
        for sign in [1.0_f64, -1.0] {
            let (sine, cosine) = (sign * 49.98_f64.to_radians()).sin_cos();
            let fiber = f.matrix() * nalgebra::Vector3::new(cosine, sine, 0.0);
            let i4 = fiber.norm_squared() * j.powf(-2.0 / 3.0);
            let e = (0.226 * (i1 - 3.0) + (1.0 - 3.0 * 0.226) * (i4 - 1.0)).max(0.0);
            energy += 996.6 / (2.0 * 0.5246) * ((0.5246 * e * e).exp() - 1.0);
        }
        energy
    });
}

/// The other forms of ANSYS, Mechanical APDL Theory Reference, "Hyperelasticity".
#[test]
fn ansys_tables_have_the_energies_of_the_ansys_manual() {
    let powers = |f: &DeformationGradient, d: f64| (f.jacobian() - 1.0).powi(2) / d;
    let logarithm = |f: &DeformationGradient, d: f64| {
        let j = f.jacobian();
        ((j * j - 1.0) / 2.0 - j.ln()) / d
    };
    let x = |f: &DeformationGradient| invariants(f).0 - 3.0;
    let y = |f: &DeformationGradient| invariants(f).1 - 3.0;
    let ansys = |text: &str| read(Program::Ansys, text, &[]);
    agrees(
        &*ansys("TB,HYPER,1,,,NEO\nTBDATA,1,0.577148\nTBDATA,2,0.07"),
        |f| 0.5 * 0.577148 * x(f) + powers(f, 0.07),
    );
    agrees(
        &*ansys("tb,hyper,1,,3,mooney\ntbdata,1,0.163498,0.125076,0.014719,0.0693"),
        |f| 0.163498 * x(f) + 0.125076 * y(f) + 0.014719 * x(f) * y(f) + powers(f, 0.0693),
    );
    agrees(
        &*ansys("TB,HYPER,1,,2,YEOH\nTBDATA,1,0.4,0.01,0.05,0.3"),
        |f| 0.4 * x(f) + 0.01 * x(f).powi(2) + powers(f, 0.05) + (f.jacobian() - 1.0).powi(4) / 0.3,
    );
    agrees(&*ansys("TB,HYPER,1,,,GENT\nTBDATA,1,0.3,50,0.05"), |f| {
        -0.5 * 0.3 * 50.0 * (1.0 - x(f) / 50.0).ln() + logarithm(f, 0.05)
    });
    agrees(&*ansys("TB,HYPER,1,,,BLATZ\nTBDATA,1,5.0"), |f| {
        let i = f.invariants();
        2.5 * (i.second / i.third + 2.0 * i.jacobian - 5.0)
    });
    agrees(
        &*ansys("TB,HYPER,1,,1,ETUBE\nTBDATA,1,0.25,0.1,0.2,0.4,0.05"),
        |f| {
            let (_, _, j, stretches) = invariants(f);
            let tube: f64 = stretches.iter().map(|l| (l / j.cbrt()).powf(-0.4)).sum();
            let rest = 1.0 - 0.01 * x(f);
            0.125 * (0.99 * x(f) / rest + rest.ln()) + 0.4 / 0.16 * (tube - 3.0) + powers(f, 0.05)
        },
    );
}

/// A block determines the law for any defaults of the library; additional settings of the user take precedence.
#[test]
fn a_block_overrides_all_defaults_and_user_settings_override_the_block() {
    let one = law_from(
        Program::Abaqus,
        "a block",
        "*HYPERELASTIC, OGDEN, N=1\n0.4, 1.3, 0.0",
        &[],
    )
    .expect("a law");
    assert!(one.assignments.contains(&"material.mu2=0".to_owned()));
    assert!(
        one.notes
            .iter()
            .any(|note| note.contains("--incompressible")),
        "{:?}",
        one.notes
    );
    let beside = ["material.kappa=5".to_owned()];
    let own = law_from(
        Program::Abaqus,
        "a block",
        "*HYPERELASTIC, OGDEN, N=1\n0.4, 1.3, 0.02",
        &beside,
    )
    .expect("a law");
    assert!(
        !own.assignments
            .iter()
            .any(|text| text.starts_with("material.kappa"))
    );
    let other = ["material.model=gent".to_owned()];
    assert!(
        law_from(
            Program::Abaqus,
            "a block",
            "*HYPERELASTIC, OGDEN, N=1\n0.4, 1.3, 0.02",
            &other
        )
        .is_err()
    );
}

/// Values of `P11`, `P21`, `P33` at the first state as computed by felupe 11.3.0 and hyperelastic 0.10.2, with `bulk = 50`. These packages perturb
/// eigenvalues; where they use eigenvalues, the numbers come from the documented energies with 30 digits, which felupe reproduces to 6e-7.
#[test]
fn models_of_python_packages_have_the_stresses_of_the_packages() {
    let volume = "fem.Volumetric(bulk=50.0)";
    let felupe = |model: &str| {
        (
            Program::Felupe,
            format!(
                "import felupe as fem\n# a fit\numat = fem.Hyperelastic(fem.{model}) & {volume}\n"
            ),
        )
    };
    let hyperelastic = |model: &str, framework: &str| {
        let text = format!(
            "model = hyperelastic.models.{model}\nframework = hyperelastic.{framework}(model)\numat = hyperelastic.DistortionalSpace(framework) & {volume}"
        );
        (Program::Hyperelastic, text)
    };
    let cases = [
        (
            felupe("ogden, mu=[1.0, 0.2], alpha=[1.7, -1.5]"),
            [7.66872778795476, -0.924805865087621, 8.54858041019004],
        ),
        (
            felupe("ogden, mu=np.array([1.0, 0.2]), alpha=(1.7, -1.5), parallel=True"),
            [7.66872778795476, -0.924805865087621, 8.54858041019004],
        ),
        (
            felupe("yeoh, C10=0.5, C20=-0.05, C30=0.02"),
            [7.61281368575363, -0.904508179189547, 8.55640867114423],
        ),
        (
            felupe("third_order_deformation,\n  C10=0.5, C01=0.1, C11=0.05, C20=-0.05, C30=2e-2"),
            [7.67185132669028, -0.926101861740193, 8.54723748295618],
        ),
        (
            felupe("arruda_boyce, C1=1.0, limit=3.2"),
            [7.63523150356284, -0.913024019523347, 8.55115928757531],
        ),
        (
            felupe("extended_tube, Gc=0.1867, Ge=0.2169, beta=0.2, delta=0.09693"),
            [7.48638537088863, -0.856037678833718, 8.58849524359671],
        ),
        (
            felupe("storakers, mu=[4.1625, 20.7], alpha=[4.5, -4.5], beta=[0.92, 0.92]"),
            [13.1360364696482, -3.03743045064814, 7.12055390869547],
        ),
        (
            (
                Program::Felupe,
                "fem.NeoHooke(mu=1.0, bulk=50.0)".to_owned(),
            ),
            [7.61976360685433, -0.907148240721396, 8.55478126914009],
        ),
        (
            hyperelastic(
                "invariants.ThirdOrderDeformation(C10=0.5, C20=-0.05, C30=0.02)",
                "InvariantsFramework",
            ),
            [7.61281368575363, -0.904508179189547, 8.55640867114423],
        ),
        (
            hyperelastic(
                "stretches.Ogden(mu=[1.0, 0.2], alpha=[1.7, -1.5])",
                "StretchesFramework",
            ),
            [7.66872778795476, -0.924805865087621, 8.54858041019004],
        ),
    ];
    let f = DeformationGradient::new(STATES[0]).expect("a state");
    for ((program, text), expected) in cases {
        let stress = read(program, &text, &[])
            .response(&f)
            .expect("finite")
            .first_piola;
        let found = [stress[(0, 0)], stress[(1, 0)], stress[(2, 2)]];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-10,
                "{found} is not {expected}: {text}"
            );
        }
    }
}

/// The documentation of felupe says of Ogden's law: "The sum of the moduli mu_i is equal to the initial shear modulus"; Abaqus uses the same
/// convention.
#[test]
fn moduli_of_ogden_in_felupe_add_up_to_the_shear_modulus() {
    let text = "fem.Hyperelastic(fem.ogden, mu=[1.0, 0.2], alpha=[1.7, -1.5])";
    let law = read(Program::Felupe, text, &["material.kappa=10"]);
    let shear = law.undeformed().expect("a reference").tangent[(0, 1, 0, 1)];
    assert!((shear - 1.2).abs() < 1e-12, "{shear}");
    let block = "*HYPERELASTIC, OGDEN, N=2\n1.0, 1.7, 0.2, -1.5, 0.2, 0.0";
    let of_abaqus = read(Program::Abaqus, block, &[]);
    let f = DeformationGradient::new(STATES[2]).expect("a state");
    let [one, other] = [law, of_abaqus].map(|law| law.response(&f).expect("finite").first_piola);
    assert!((one - other).amax() < 1e-12);
}

#[test]
fn incomplete_python_models_are_refused_with_their_position() {
    for (program, text, fact) in [
        (
            Program::Felupe,
            "fem.Hyperelastic(gent, mu=1.0, Jm=50)",
            "no model of Gent's law",
        ),
        (Program::Felupe, "x = 1\n", "there is no model of felupe"),
        (
            Program::Felupe,
            "fem.Hyperelastic(fem.ogden, mu=mu, alpha=[2])",
            "mu is `mu`",
        ),
        (
            Program::Felupe,
            "fem.Hyperelastic(fem.ogden, mu=[1.0, 2.0], alpha=[2])",
            "differ in length",
        ),
        (
            Program::Felupe,
            "fem.Hyperelastic(fem.ogden, mu=[1.0], alpha=[0.0])",
            "alpha is 0",
        ),
        (
            Program::Felupe,
            "fem.Hyperelastic(fem.yeoh, C10=0.5, C01=1)",
            "no argument `C01`",
        ),
        (Program::Felupe, "fem.NeoHooke(1.0, 2.0)", "has no name"),
        (
            Program::Hyperelastic,
            "\nm = Ogden(mu=[1], alpha=[2])\numat = DeformationSpace(StretchesFramework(m))",
            "stress at F = 1",
        ),
        (Program::Hyperelastic, "Ogden(mu=[1])", "has no `alpha`"),
        (
            Program::Felupe,
            "x = fem.NeoHooke(mu=((((((1",
            "the brackets after NeoHooke are not closed",
        ),
        (
            Program::Felupe,
            "x = fem.NeoHooke(mu=7.5, bulk=",
            "bulk has no value",
        ),
        (
            Program::Felupe,
            "x = fem.Hyperelastic(fem.ogden, mu=[1.0], alpha=[2.0]",
            "are not closed",
        ),
    ] {
        let error = law_from(program, "a script", text, &[])
            .expect_err(text)
            .to_string();
        assert!(error.contains(fact), "{error}");
    }
}

/// felupe adds the energies of `a & b`.
#[test]
fn materials_of_a_script_are_chosen_by_name_and_sums_are_refused() {
    let read = |text: &str, material: Option<&str>| {
        law_of(Program::Felupe, "a script", text, material, &[])
    };
    for (text, fact) in [
        (
            "umat = fem.Hyperelastic(fem.neo_hooke, mu=1.0) & fem.Hyperelastic(fem.ogden, mu=[0.5], alpha=[-2.0])",
            "a sum, of neo_hooke and ogden",
        ),
        (
            "umat = fem.NeoHooke(mu=1.0, bulk=50.0) & fem.Volumetric(bulk=5000.0)",
            "several bulk moduli",
        ),
        (
            "umat = fem.Hyperelastic(fem.finite_strain_viscoelastic, mu=1.0, eta=2.0) & \\\n fem.Hyperelastic(fem.neo_hooke, mu=1.0)",
            "depends on the history",
        ),
    ] {
        let error = read(text, None).expect_err(text).to_string();
        assert!(error.contains(fact), "{error}");
    }
    let two = "from felupe import yeoh\n'''umat = fem.Hyperelastic(fem.neo_hooke, mu=9.0)'''\n\
               a = fem.Hyperelastic(fem.mooney_rivlin, C10=0.4, C01=0.1) & fem.Volumetric(bulk=50.0)\n\
               b = fem.Hyperelastic(fem.neo_hooke, mu=7.) & fem.Volumetric(bulk=5000.0)\n";
    let notes = |material| {
        let read = law_of(Program::Felupe, "a script", two, material, &[]).expect("a law");
        read.notes.join("\n")
    };
    let first = notes(None);
    assert!(first.contains("material a (1 of 2; --material "), "{first}");
    let second = notes(Some("b"));
    assert!(second.contains("material b (2 of 2"), "{second}");
    let unknown = law_of(Program::Felupe, "a script", two, Some("c"), &[]).expect_err("no c");
    assert!(
        unknown.to_string().contains("materials with a law: a, b"),
        "{unknown}"
    );
    let softened = "fem.OgdenRoxburgh(fem.NeoHooke(mu=1, bulk=2), r=3, m=1, beta=0)";
    let softened = law_of(Program::Felupe, "a script", softened, None, &[]).expect("a law");
    assert!(
        softened
            .notes
            .join("\n")
            .contains("OgdenRoxburgh, softening by unloading (line 1)")
    );
}

#[test]
fn constants_of_ansys_for_a_second_temperature_are_refused() {
    let of = |text: &str| law_of(Program::Ansys, "a deck", text, None, &[]);
    let one = "TB,HYPER,1,1,2,NEO\nTBTEMP,20\nTBDATA,1,0.8,0.02\n";
    let notes = of(one).expect("a law").notes.join("\n");
    assert!(notes.contains("TBTEMP,20 (line 2)"), "{notes}");
    let two = format!("{one}TBTEMP,80\nTBDATA,1,0.7,0.02\n");
    let error = of(&two).expect_err("two temperatures").to_string();
    assert!(error.contains("several temperatures"), "{error}");
    // Temperatures of another material are not part of this one.
    let other = format!("{one}TB,HYPER,2,1,2,NEO\nTBTEMP,80\nTBDATA,1,0.7,0.02\n");
    let notes = of(&other).expect("a law").notes.join("\n");
    assert!(!notes.contains("TBTEMP,80"), "{notes}");
}

/// Nominal stress of a test with a traction-free second direction, `P_11 - P_33 F_33/F_11`, at constant volume.
fn nominal(law: &dyn Hyperelastic, stretches: [f64; 3]) -> f64 {
    let f = DeformationGradient::from_stretches(stretches).expect("stretches");
    let p = law.response(&f).expect("finite").first_piola;
    p[(0, 0)] - p[(2, 2)] * stretches[2] / stretches[0]
}

#[test]
fn lateral_strains_of_a_table_are_refused_and_parameters_of_a_table_are_listed() {
    let block =
        "*HYPERELASTIC, MARLOW, POISSON=0.45\n*UNIAXIAL TEST DATA, SMOOTH=3\n0.1, 0.1\n0.2, 0.2, ";
    let read = told(Program::Abaqus, block, None);
    assert!(
        read.contains("SMOOTH=3 of *UNIAXIAL TEST DATA (line 2)"),
        "{read}"
    );
    let refused = told(Program::Abaqus, &format!("{block}-0.05"), None);
    assert!(
        refused.contains(":4") && refused.contains("lateral strain"),
        "{refused}"
    );
}

/// Marlow's energy reproduces its table. Between the points of a neo-Hookean table it is neo-Hookean, and its tangent is continuous.
#[test]
fn marlows_energy_reproduces_an_abaqus_table() {
    let (c10, c20, c30) = (0.2, -2e-3, 5e-5);
    let slope = |i1: f64| c10 + 2.0 * c20 * (i1 - 3.0) + 3.0 * c30 * (i1 - 3.0).powi(2);
    type Course = fn(f64) -> [f64; 3];
    let tests: [(&str, Course, f64); 3] = [
        ("UNIAXIAL", |l| [l, l.powf(-0.5), l.powf(-0.5)], 2.0),
        ("BIAXIAL", |l| [l, l, l.powi(-2)], 5.0),
        ("PLANAR", |l| [l, 1.0, 1.0 / l], 3.0),
    ];
    for (name, course, power) in tests {
        let stress = |l: f64| {
            let i1: f64 = course(l).iter().map(|x| x * x).sum();
            2.0 * slope(i1) * (l - l.powf(-power))
        };
        let stretches: Vec<f64> = (1..=40).map(|n| 1.0 + 0.1 * f64::from(n)).collect();
        let rows: String = stretches
            .iter()
            .map(|l| format!("{:e}, {:e}\n", stress(*l), l - 1.0))
            .collect();
        let block =
            format!("*HYPERELASTIC, MARLOW, POISSON=0.49\n*{name} TEST DATA\n0., 0.\n{rows}");
        let law = read(Program::Abaqus, &block, &[]);
        for (n, l) in stretches.iter().enumerate() {
            let found = nominal(&*law, course(*l));
            assert!(
                (found / stress(*l) - 1.0).abs() < 1e-9,
                "{name} {l}: {found}"
            );
            // Between the points the cubic is close to the quadratic polynomial.
            if (3..36).contains(&n) {
                let between = l + 0.05;
                let found = nominal(&*law, course(between));
                assert!(
                    (found / stress(between) - 1.0).abs() < 2e-3,
                    "{name} {between}: {found}"
                );
            }
        }
        // The tangent is the same on both sides of a point.
        let tangent = |l: f64| {
            let f = DeformationGradient::from_stretches(course(l)).expect("stretches");
            law.response(&f).expect("finite").tangent[(0, 0, 0, 0)]
        };
        let (before, behind) = (tangent(2.0 - 1e-9), tangent(2.0 + 1e-9));
        assert!(
            (before / behind - 1.0).abs() < 1e-6,
            "{name}: {before} {behind}"
        );
    }
    let rows: String = (1..6)
        .map(|n| 1.0 + 0.3 * f64::from(n))
        .map(|l: f64| format!("{:e}, {:e}\n", 0.4 * (l - l.powi(-2)), l - 1.0))
        .collect();
    let block = format!("*HYPERELASTIC, MARLOW, POISSON=0.45\n*UNIAXIAL TEST DATA\n{rows}");
    let bulk = 2.0 * 0.4 * 1.45 / (3.0 * 0.1);
    agrees(&*read(Program::Abaqus, &block, &[]), |f| {
        let (i1, _, j, _) = invariants(f);
        0.2 * (i1 - 3.0) + 0.5 * bulk * (j - 1.0).powi(2)
    });
}

/// A table may have any number of recorded points; a neo-Hookean table of 1,000 points has the right shear modulus.
#[test]
fn a_table_of_many_points_is_accepted_with_a_short_note() {
    let rows: String = (1..=1000)
        .map(|n| 1.0 + 3e-3 * f64::from(n))
        .map(|l: f64| format!("{:e}, {:e}\n", 0.6 * (l - l.powi(-2)), l - 1.0))
        .collect();
    let block = format!("*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n{rows}");
    let reading = law_from(Program::Abaqus, "a block", &block, &[]).expect("a law");
    assert!(reading.notes.iter().all(|note| note.len() < 400));
    let law = read(Program::Abaqus, &block, &[]);
    let shear = law
        .response(&DeformationGradient::identity())
        .expect("finite")
        .tangent[(0, 1, 0, 1)];
    assert!((shear / 0.6 - 1.0).abs() < 1e-6, "{shear}");
}

/// Prony series with a sum of 0.3: factor `1/(1 - 0.3)` for long-term moduli, `1 - 0.3` for instantaneous moduli.
#[test]
fn keywords_of_a_deck_are_read_or_listed_with_their_lines() {
    let deck = "*MATERIAL, NAME=A\n*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.02\n*VISCOELASTIC, TIME=PRONY\n0.3, 0., 0.1\n\
                *MULLINS EFFECT\n1.5, 0.1, 0.1\n*MATERIAL, NAME=B\n*HYPERELASTIC, NEO HOOKE\n0.7, 0.02";
    let notes = |program: Program, text: &str, material: Option<&str>| {
        let read = law_of(program, "a deck", text, material, &[]).expect("a law");
        read.notes.join("\n")
    };
    let first = notes(Program::Abaqus, deck, None);
    for fact in [
        "read as mooney-rivlin-isochoric from *HYPERELASTIC, MOONEY-RIVLIN of Abaqus and *VISCOELASTIC, material A (1 of 2; --material ",
        "not read: *MULLINS EFFECT (line 6)",
        "long-term",
        "1.42857",
    ] {
        assert!(first.contains(fact), "{fact} is not in {first}");
    }
    let instantaneous = deck.replace("MOONEY-RIVLIN", "MOONEY-RIVLIN, MODULI=INSTANTANEOUS");
    assert!(notes(Program::Abaqus, &instantaneous, None).contains("0.7 times"));
    let second = notes(Program::Abaqus, deck, Some("b"));
    assert!(second.contains("material B (2 of 2;"), "{second}");
    assert!(law_of(Program::Abaqus, "a deck", deck, Some("C"), &[]).is_err());
    let quoted = deck.replace("NAME=B", "NAME=\"Rubber, 60 Shore\"");
    for name in ["Rubber, 60 Shore", "\"Rubber, 60 Shore\""] {
        let second = notes(Program::Abaqus, &quoted, Some(name));
        assert!(
            second.contains("material \"Rubber, 60 Shore\" (2 of 2;"),
            "{second}"
        );
    }
    let foam = "*MATERIAL, NAME=FOAM\n*HYPERFOAM, N=1, POISSON=0.1\n0.2, 8.0";
    let refused = law_of(Program::Abaqus, "a deck", foam, None, &[]).expect_err("POISSON");
    assert!(
        refused
            .to_string()
            .contains("a deck:2:1: *HYPERFOAM has POISSON=0.1 in addition to constants"),
        "{refused}"
    );
    let ansys = "TB,HYPER,1,1,2,MOONEY\nTBDATA,1,0.4,0.1,0.02\nTB,PRONY,1,1,1,SHEAR\nTBDATA,1,0.3,0.1\nTB,HYPER,2,1,,NEO\nTBDATA,1,2,0.02";
    let first = notes(Program::Ansys, ansys, None);
    for fact in [
        "with a Prony series of 1 term",
        "instantaneous",
        "0.7 times",
        "material 1 (1 of 2; --material ",
    ] {
        assert!(first.contains(fact), "{fact} is not in {first}");
    }
    assert!(notes(Program::Ansys, ansys, Some("2")).contains("material 2 (2 of 2"));
}

#[test]
fn constants_that_a_law_does_not_admit_are_refused_with_the_line_of_their_keyword() {
    let rubber = "*MATERIAL, NAME=A\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n";
    let ansys = "TB,HYPER,1,1,2,MOONEY\nTBDATA,1,0.4,0.1,0.02\n";
    for (program, text, expected) in [
        (
            Program::Abaqus,
            format!("{rubber}*MULLINS EFFECT\n1.5\n"),
            "a deck:4:1: *MULLINS EFFECT: material parameter mullins-m + mullins-beta is 0;",
        ),
        (
            Program::Abaqus,
            format!("{rubber}*VISCOELASTIC, TIME=PRONY\n1.5, 0., 0.1\n"),
            "a deck:4:1: *VISCOELASTIC: a fraction g is 1.5",
        ),
        (
            Program::Abaqus,
            rubber.replace("NEO HOOKE\n0.5, 0.02", "YEOH\n0.5, 0., 0., -0.02, 0., 0."),
            "a deck:2:1: *HYPERELASTIC, YEOH, N=3 of Abaqus: material parameter kappa is -100",
        ),
        (
            Program::Ansys,
            format!("{ansys}TB,PRONY,1,1,1,SHEAR\nTBDATA,1,1.3,0.1\n"),
            "a deck:3:1: TB,PRONY: a fraction g is 1.3",
        ),
    ] {
        let refused = law_of(program, "a deck", &text, None, &[]).expect_err(expected);
        assert!(refused.to_string().starts_with(expected), "{refused}");
        assert!(
            refused.to_string().contains("override them with --set"),
            "{refused}"
        );
    }
    // The user corrects a constant.
    let text = format!("{rubber}*MULLINS EFFECT\n1.5\n");
    let set = ["material.mullins-m=0.1".to_owned()];
    let read = law_of(Program::Abaqus, "a deck", &text, None, &set).expect("a law");
    assert!(
        read.notes[0].starts_with(
            "read as yeoh from *HYPERELASTIC, NEO HOOKE of Abaqus and *MULLINS EFFECT, material A"
        ),
        "{}",
        read.notes[0]
    );
}

/// A table in a file has no units, so that a bulk modulus in MPa would be added to stresses that are read as Pa.
#[test]
fn a_table_of_stresses_admits_no_units_in_other_values() {
    let table = "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1\n0.3, 0.5\n";
    let read = |other: &str| {
        let own = [
            "material.model=marlow".to_owned(),
            format!("material.table={table}"),
            other.to_owned(),
        ];
        Settings::from_assignments(&own)
            .and_then(|settings| settings.check(&[]))
            .map_err(|error| error.to_string())
    };
    assert_eq!(read("material.kappa=3"), Ok(()));
    for other in ["material.kappa=3MPa", "discretization.spacing=1mm"] {
        let error = read(other).expect_err("a unit");
        assert!(error.contains("the numbers of material.table"), "{error}");
        assert!(error.contains("omit all units"), "{error}");
    }
}

/// The temperature and the field variables follow the last constant, on a new line after eight constants.
#[test]
fn temperatures_and_field_variables_of_constants_are_listed_as_not_read() {
    for (block, expected) in [
        (
            "*HYPERELASTIC, NEO HOOKE\n0.5, 0.1, 20.",
            "temperature 20 (line 2)",
        ),
        (
            "*HYPERELASTIC, NEO HOOKE, DEPENDENCIES=2\n0.5, 0.1, , 3, 4",
            "field variable 1 = 3 (line 2), field variable 2 = 4 (line 2)",
        ),
        (
            "*HYPERELASTIC, REDUCED POLYNOMIAL, N=4\n1, 0, 0, 0, 0.1, 0, 0, 0\n-10",
            "temperature -10 (line 3)",
        ),
        (
            "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1, , 20\n0.2, 0.3, , 20.",
            "temperature 20 (line 3)",
        ),
    ] {
        let notes = told(Program::Abaqus, block, None);
        assert!(notes.contains(expected), "{expected} is not in {notes}");
    }
    for block in [
        "*HYPERELASTIC, NEO HOOKE\n0.5, 0.1, 20.\n0.4, 0.1, 80.",
        "*HYPERELASTIC, REDUCED POLYNOMIAL, N=4\n1, 0, 0, 0, 0.1, 0, 0, 0\n20\n1, 0, 0, 0, 0.1, 0, 0, 0\n80",
        "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1, , 20\n0.2, 0.3, , 80",
    ] {
        let error = told(Program::Abaqus, block, None);
        assert!(error.contains("one temperature"), "{error}");
    }
}

/// A deck without a law that is read is recognized as a deck of its program, so that the error names the missing law.
#[test]
fn decks_with_linear_elasticity_alone_name_its_moduli() {
    for (program, text) in [
        (
            Program::Abaqus,
            "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n",
        ),
        (Program::Ansys, "/PREP7\nMP,EX,1,210000\nMP,PRXY,1,0.3\n"),
        (Program::Ansys, "TB,ELAS,1,,2,ISOT\nTBDATA,1,210000,0.3\n"),
        (
            Program::Ansys,
            "ET,1,181 $ MP,EX,1,210000 $ MP,NUXY,1,0.3 ! steel\n",
        ),
        (
            Program::LsDyna,
            "*KEYWORD\n*MAT_ELASTIC\n1, 7.8e-9, 210000., 0.3\n",
        ),
        (
            Program::Radioss,
            "/MAT/ELAST/1\nsteel\n              7.8e-9\n              210000                 0.3\n",
        ),
        (
            Program::Febio,
            "<material id=\"1\" type=\"isotropic elastic\"><E>210000</E><v>0.3</v></material>",
        ),
    ] {
        assert_eq!(Program::of_deck(text), Some(program), "{text}");
        let error = told(program, text, None);
        for fact in [
            "linear elasticity",
            "--set material.model=neo-hooke --set material.young=210000 --set material.poisson=0.3",
        ] {
            assert!(error.contains(fact), "{fact} is not in {error}");
        }
    }
    for (program, text) in [
        (Program::Abaqus, "*HEADING\n*MATERIAL, NAME=A\n*DENSITY\n1"),
        (Program::Ansys, "TB,BISO,1\nTBDATA,1,300,100"),
        (Program::LsDyna, "*KEYWORD\n*NODE\n1, 0., 0., 0."),
        (Program::Radioss, "#RADIOSS STARTER\n/BEGIN\nm"),
        (Program::Febio, "<febio_spec version=\"4.0\"></febio_spec>"),
    ] {
        assert_eq!(Program::of_deck(text), Some(program), "{text}");
        let error = told(program, text, None);
        let fact = format!("there is no hyperelastic law of {}", program.title());
        assert!(error.contains(&fact), "{error}");
    }
}

/// ANSYS compares four letters of a name, and its archives have abbreviated names.
#[test]
fn abbreviated_names_of_ansys_are_read() {
    let read = |text: &str| law_from(Program::Ansys, "a deck", text, &[]);
    let full = read("TB,HYPER,1,1,2,MOONEY\nTBTEMP,20\nTBDATA,1,0.4,0.1,0.02").expect("a law");
    let short = "TB,HYPE,1,1,2,MOON\nTBTEM,20\nTBDAT,1,0.4,0.1,0.02";
    assert_eq!(Program::of_deck(short), Some(Program::Ansys));
    assert_eq!(read(short).expect("a law"), full);
    let empty = read("TB,HYPE,1,1,2,MOON").expect_err("no data").to_string();
    assert!(empty.contains("TB,HYPER has no constants"), "{empty}");
}

/// `$` separates the commands of a line of ANSYS.
#[test]
fn commands_of_ansys_on_one_line_are_read() {
    let read = |text: &str| law_from(Program::Ansys, "a deck", text, &[]).expect("a law");
    let lines = "TB,HYPER,1,,1,OGDEN\nTBDATA,1,0.6,1.3\nTBDATA,3,0.02";
    let one = "/PREP7 $ TB,HYPER,1,,1,OGDEN $TBDATA,1,0.6,1.3$ TBDATA,3,0.02 ! $ TBDATA,1,7";
    assert_eq!(Program::of_deck(one), Some(Program::Ansys));
    assert_eq!(read(one), read(lines));
}

/// Keywords are recognized only at the beginning of a line, so that a path with `/mat/` in a study does not count as a deck.
#[test]
fn programs_are_recognized_by_their_keywords() {
    for (text, program) in [
        ("** a deck\n*HYPERELASTIC, YEOH\n", Some(Program::Abaqus)),
        ("TB, HYPER,1\n", Some(Program::Ansys)),
        ("$\n*mat_077_h\n", Some(Program::LsDyna)),
        ("#\n/MAT/OGDEN/1\n", Some(Program::Radioss)),
        (
            "<?xml?>\n <febio_spec version=\"4.0\">",
            Some(Program::Febio),
        ),
        ("<material id=\"1\" type=\"Ogden\">", Some(Program::Febio)),
        ("umat = fem.NeoHooke(mu=1)", Some(Program::Felupe)),
        ("material.library = \"/opt/mat/law.so\"", None),
        ("# fem.NeoHooke\nmaterial.model = \"neo-hooke\"", None),
        ("# *HYPERELASTIC\n[material\nmodel = 1", None),
    ] {
        assert_eq!(Program::of_deck(text), program, "{text}");
    }
    for (name, program) in [
        ("LS-DYNA", Program::LsDyna),
        ("OpenRadioss", Program::Radioss),
        ("febio", Program::Febio),
    ] {
        assert_eq!(name.parse(), Ok(program), "{name}");
    }
    let error = "ls-dnya".parse::<Program>().expect_err("a typing error");
    assert_eq!(
        error,
        "expected abaqus, ansys, calculix, febio, felupe, hyperelastic, lsdyna or radioss; did you mean `lsdyna`?"
    );
}

/// Decks with truncated or repeated lines and replaced letters give an answer or an error, but never a panic.
#[test]
fn damaged_decks_are_read_or_refused() {
    let laws: [(&str, &[(&str, f64)]); 4] = [
        (
            "ogden",
            &[
                ("mu1", 0.6),
                ("alpha1", 1.3),
                ("mu2", -0.01),
                ("alpha2", -2.0),
                ("kappa", 50.0),
            ],
        ),
        (
            "polynomial",
            &[("c10", 0.4), ("c20", 0.01), ("kappa", 50.0)],
        ),
        (
            "arruda-boyce",
            &[("mu", 0.3), ("locking", 5.0), ("kappa", 50.0)],
        ),
        (
            "hyperfoam",
            &[("mu1", 2.0), ("alpha1", 4.0), ("beta1", 0.5)],
        ),
    ];
    let letters = [
        "", " ", "0", "-", ",", "é", "\n", "<", ">", "/", "*", "1e400", "nan",
    ];
    for program in Program::ALL {
        for (law, parameters) in laws {
            let Ok(written) = law_written(program, law, parameters) else {
                continue;
            };
            let text = written.text;
            for (at, _) in text.char_indices() {
                let end = at + text[at..].chars().next().map_or(0, char::len_utf8);
                for letter in letters {
                    let damaged = format!("{}{letter}{}", &text[..at], &text[end..]);
                    if let Ok(reading) = law_from(program, "a deck", &damaged, &[]) {
                        let numbers = reading
                            .assignments
                            .iter()
                            .filter_map(|own| own.split_once('='));
                        let finite = numbers
                            .filter_map(|(_, value)| value.parse::<f64>().ok())
                            .all(f64::is_finite);
                        assert!(finite, "{damaged}: {:?}", reading.assignments);
                    }
                }
                let _ = law_from(program, "a deck", &text[..at], &[]);
            }
        }
    }
}

/// Fractions of the instantaneous moduli with relaxation times, as each program defines them.
#[test]
fn prony_series_of_decks_are_read() {
    let prony = |program: Program, text: &str| {
        let read = law_of(program, "a deck", text, None, &[]).expect("a law");
        let of = |key: &str| {
            let own = read.assignments.iter();
            let mut own = own.filter_map(|own| own.strip_prefix(&format!("material.{key}=")));
            own.next().unwrap_or_default().to_owned()
        };
        let settings = MaterialSettings::of_file("", "", &read.assignments).expect("settings");
        settings.build().expect("a material");
        (of("prony"), of("moduli"))
    };
    let told = |series: &str, moduli: &str| (series.to_owned(), moduli.to_owned());
    let abaqus = "*HYPERELASTIC, NEO HOOKE, MODULI=INSTANTANEOUS\n0.4, 0.02\n*VISCOELASTIC, TIME=PRONY\n0.3, , 0.1\n0.2, 0.1, 5.";
    let series = "0.3, 0, 0.1; 0.2, 0.1, 5";
    assert_eq!(
        prony(Program::Abaqus, abaqus),
        told(series, "instantaneous")
    );
    let plain = abaqus.replace(", MODULI=INSTANTANEOUS", "");
    assert_eq!(prony(Program::Abaqus, &plain), told(series, "long-term"));
    let foam = "*HYPERFOAM, N=1\n0.2, 8.0, 0.3\n*VISCOELASTIC, TIME=PRONY\n0.3, 0., 0.1";
    assert_eq!(
        prony(Program::Abaqus, foam),
        told("0.3, 0.3, 0.1", "long-term")
    );
    let ansys = "TB,HYPER,1,1,,NEO\nTBDATA,1,0.4,0.02\nTB,PRONY,1,1,2,SHEAR\nTBDATA,1,0.3,0.1,0.2,5\nTB,PRONY,1,1,1,BULK\nTBDATA,1,0.1,5";
    assert_eq!(
        prony(Program::Ansys, ansys),
        told("0.3, 0, 0.1; 0.2, 0, 5; 0, 0.1, 5", "instantaneous")
    );
    let febio = "<material id=\"2\" type=\"viscoelastic\"><g1>0.5</g1><t1>10</t1><elastic type=\"neo-Hookean\"><E>1</E><v>0.3</v></elastic></material>";
    let third = 1.0 / 3.0;
    assert_eq!(
        prony(Program::Febio, febio),
        told(&format!("{third}, {third}, 10"), "long-term")
    );
    let uncoupled = febio.replace("\"viscoelastic\"", "\"uncoupled viscoelastic\"");
    let uncoupled = uncoupled.replace(
        "neo-Hookean\"><E>1</E><v>0.3</v>",
        "Mooney-Rivlin\"><c1>1</c1><c2>0</c2><k>10</k>",
    );
    assert_eq!(
        prony(Program::Febio, &uncoupled),
        told(&format!("{third}, 0, 10"), "long-term")
    );
    let dyna = "*MAT_VISCOELASTIC\n$ MID RO BULK G0 GI BETA\n1,1.0,10.0,4.0,1.0,20.0\n";
    assert_eq!(
        prony(Program::LsDyna, dyna),
        told("0.75, 0, 0.05", "long-term")
    );
    // The shear modulus 2 (C10 + C01) is 2, and G1 = 2 is added.
    let rubber = "*MAT_HYPERELASTIC_RUBBER\n1,1.0,0.49,0,1\n1.0,0,0,0,0,0\n2.0,4.0\n";
    assert_eq!(
        prony(Program::LsDyna, rubber),
        told("0.5, 0, 0.25", "long-term")
    );
}

/// Constants `r`, `m`, `beta` of the Mullins effect. Without them, and for forms that are not read, the keyword is listed.
#[test]
fn constants_of_the_mullins_effect_of_decks_are_read() {
    let read = |program: Program, text: &str| {
        let read = law_of(program, "a deck", text, None, &[]).expect("a law");
        let own = read.assignments.iter();
        let softening: Vec<_> = own
            .filter_map(|own| own.strip_prefix("material.mullins-"))
            .map(str::to_owned)
            .collect();
        let settings = MaterialSettings::of_file("", "", &read.assignments).expect("settings");
        assert_eq!(settings.softens(), !softening.is_empty());
        settings.build().expect("a material");
        (softening.join(" "), read.notes.join("\n"))
    };
    let abaqus = "*HYPERELASTIC, YEOH\n0.5, -0.01, 0.001, 0.02\n*MULLINS EFFECT\n1.5, 0.05, 0.1\n";
    let ansys = "TB,HYPER,1,1,1,NEO\nTBDATA,1,0.8,0.02\nTB,CDM,1,1,3,PSE2\nTBDATA,1,1.5,0.05,0.1\n";
    let foam = abaqus.replace("ELASTIC, YEOH", "FOAM, N=1");
    let foam = foam.replace("0.5, -0.01, 0.001, 0.02", "0.2, 8.0, 0.3");
    for (program, text) in [
        (Program::Abaqus, abaqus),
        (Program::Abaqus, &foam),
        (Program::Ansys, ansys),
        (
            Program::Ansys,
            &ansys.replace("TBDATA,1,1.5,0.05,0.1", "TBDATA,1,1.5\nTBDATA,2,0.05,0.1"),
        ),
    ] {
        let (softening, notes) = read(program, text);
        assert_eq!(softening, "r=1.5 m=0.05 beta=0.1", "{text}");
        assert!(!notes.contains("not read"), "{notes}");
    }
    for (program, text, words) in [
        (
            Program::Abaqus,
            abaqus.replace("EFFECT", "EFFECT, TEST DATA INPUT"),
            "*MULLINS EFFECT (line 3)",
        ),
        (
            Program::Abaqus,
            format!("{abaqus}2, 0.05, 0.1, 100.\n"),
            "*MULLINS EFFECT (line 3)",
        ),
        (
            Program::Ansys,
            ansys.replace("1,3,PSE2", "1,3,PSE1"),
            "TB,CDM,1 (line 3)",
        ),
        (
            Program::Ansys,
            format!("{ansys}TB,PRONY,1,1,1,SHEAR\nTBDATA,1,0.3,0.1\n"),
            "TB,CDM with PSE2 (line 3)",
        ),
    ] {
        let (softening, notes) = read(program, &text);
        assert_eq!(softening, "", "{text}");
        assert!(notes.contains(&format!("not read: {words}")), "{notes}");
    }
    let warm = abaqus.replace("0.05, 0.1", "0.05, 0.1, 60.");
    let (softening, notes) = read(Program::Abaqus, &warm);
    assert_eq!(softening, "r=1.5 m=0.05 beta=0.1");
    assert!(notes.contains("temperature 60 (line 4)"), "{notes}");
}

#[test]
fn messages_quote_at_most_the_beginning_of_one_word_of_a_deck() {
    let long = "SECRET".repeat(3000);
    for (program, deck) in [
        (
            Program::Ansys,
            format!("TB,HYPER,1,,1,SECRET{long}\nTBDATA,1,2\n"),
        ),
        (
            Program::Ansys,
            format!("TB,HYPER,1,,1,OGDEN\nTBDATA,1,{long}\n"),
        ),
        (
            Program::Abaqus,
            format!("*MATERIAL, NAME=a\n*HYPERELASTIC, {long}\n1, 2, 3\n"),
        ),
        (
            Program::Abaqus,
            format!("*HYPERELASTIC, OGDEN, N=1\n{long}, 2, 3\n"),
        ),
        (
            Program::Febio,
            format!("<material id=\"1\" type=\"{long}\"></material>"),
        ),
        (
            Program::Febio,
            format!("<material><{long}>1</other></material>"),
        ),
        (
            Program::Felupe,
            format!("umat = fem.Hyperelastic(fem.ogden, mu=[{long}], alpha=[2])\n"),
        ),
        (Program::LsDyna, format!("*MAT_{long}\n1\n")),
        (Program::Radioss, format!("/MAT/{long}/1\ntitle\n")),
    ] {
        let error = law_from(program, "a deck", &deck, &[]).expect_err("refused");
        let told = error.to_string();
        let count = told.to_ascii_uppercase().matches("SECRET").count();
        assert!(count <= 4 && told.len() < 1000, "{program:?}: {told}");
    }
}

#[test]
fn the_first_of_two_laws_of_a_material_is_read_and_the_other_is_named() {
    let deck = "*MATERIAL, NAME=a\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n*HYPERELASTIC, NEO HOOKE\n0.7, 0.02\n";
    let reading = law_from(Program::Abaqus, "a deck", deck, &[]).expect("a law");
    let notes = reading.notes.join("\n");
    assert!(
        notes.contains("not read: another *HYPERELASTIC, because line 2 is read (line 4)"),
        "{notes}"
    );
}

#[test]
fn parts_of_a_material_outside_its_law_are_named() {
    let abaqus = "*MATERIAL, NAME=A\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.1\n*VISCOELASTIC, TIME=PRONY\n0.3, 0.2, 0.1\n\
                  *VISCOELASTIC, TIME=FREQUENCY DATA\n1,2\n*UNIAXIAL TEST DATA\n0.1,0.1\n*VOLUMETRIC TEST DATA\n1.,.9\n";
    let card = |numbers: &[&str]| {
        let cells = numbers.iter().map(|number| format!("{number:>20}"));
        cells.collect::<String>()
    };
    let law = [
        card(&["1.1E-9"]),
        card(&[".495", "0", "0", "0", "         0         1"]),
        card(&[".5", "-.1"]),
        card(&["0"]),
        card(&["2", "-2"]),
        card(&["0"]),
    ];
    let radioss = &format!(
        "/MAT/LAW42/1\nrubber\n{}\n/VISC/PRONY/1\n1 1\n.3 .1\n/FAIL/JOHNSON/1\n0\n/FAIL/JOHNSON/2\n0\n/MAT/LAW999/7\nother\n1\n",
        law.join("\n")
    );
    let lsdyna = "*KEYWORD\n*MAT_BLATZ-KO_RUBBER\n4,1e-9,1.0,0\n*MAT_HYPERELASTIC_RUBBER\n2,1.1e-9,.499,0,1\n.4,.1,0,0,0,0\n.3,10.\n*END\n";
    for (program, text, parts) in [
        (
            Program::Abaqus,
            abaqus,
            &[
                "*VISCOELASTIC (line 6)",
                "*UNIAXIAL TEST DATA (line 8)",
                "*VOLUMETRIC TEST DATA (line 10)",
            ][..],
        ),
        (
            Program::Radioss,
            radioss,
            &[
                "/VISC/PRONY/1 (line 9)",
                "/FAIL/JOHNSON/1 (line 12)",
                "material 7, /MAT/LAW999 (line 16)",
            ],
        ),
        (
            Program::LsDyna,
            lsdyna,
            &["material 4, *MAT_BLATZ-KO_RUBBER (line 2)"],
        ),
    ] {
        let read = law_of(program, "a deck", text, None, &[]).expect("a law");
        let notes = read.notes.join("\n");
        for part in parts {
            assert!(notes.contains(part), "{part}: {notes}");
        }
        assert!(!notes.contains("/FAIL/JOHNSON/2"), "{notes}");
    }
}
