//! Completion in shells: the function of bash, and the words of values.

use super::Scratch;
use std::process::Command;

/// Candidates of bash for a line whose cursor is at its end. Words are split at blanks and equals signs, as bash splits them.
fn completed(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for word in line.split(' ') {
        let mut parts = word.split('=');
        words.extend(parts.next().map(str::to_owned));
        for part in parts {
            words.push("=".to_owned());
            words.extend(Some(part.to_owned()).filter(|part| !part.is_empty()));
        }
    }
    let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    let binary = std::path::Path::new(env!("CARGO_BIN_EXE_onset"));
    let folder = binary.parent().expect("a folder").display();
    let script = format!(
        "PATH={folder}:$PATH\nsource <(onset completions bash)\ncompopt() {{ :; }}\nCOMP_WORDS=({})\nCOMP_CWORD={}\n\
         COMP_WORDBREAKS=$' \\t\\n=:'\n_onset\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"",
        quoted.join(" "),
        words.len() - 1
    );
    let output = Command::new("bash")
        .args(["--norc", "-c", &script])
        .output()
        .expect("bash");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.is_empty(), "{told}");
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes_keys_values_and_words_of_options() {
    for (line, expected) in [
        ("onset sta", vec!["state"]),
        (
            "onset state --set discretization.transf",
            vec!["discretization.transfer=", "discretization.transfer-order="],
        ),
        (
            "onset state --set discretization.method=mat",
            vec!["material-points"],
        ),
        (
            "onset state --set discretization.lattice=ch --stretch 1,1 --set material.plane=",
            vec!["strain", "stress", "membrane"],
        ),
        ("onset state --set material.model=blatz", vec!["blatz-ko"]),
        ("onset path --mode sim", vec!["simple-shear"]),
        ("onset simulate --mode ", vec!["critical", "noise"]),
        (
            "onset path --lateral plane-s",
            vec!["plane-stress", "plane-strain"],
        ),
        ("onset card --from cal", vec!["calculix"]),
        ("onset path --read-as cal", vec!["calculix"]),
        ("onset fit pull.csv --law yeo", vec!["yeoh"]),
        ("onset fit pull.csv --law yeoh,gen", vec!["yeoh,gent"]),
        ("onset plot --field growth", vec!["growth_rate"]),
        (
            "onset compare --vary discretization.kern",
            vec!["discretization.kernel="],
        ),
        (
            "onset compare --vary discretization.kernel=gaussian,wendland-c",
            vec![
                "gaussian,wendland-c2",
                "gaussian,wendland-c4",
                "gaussian,wendland-c6",
            ],
        ),
        (
            "onset limit --vary discretization.spac",
            vec!["discretization.spacing"],
        ),
        (
            "onset tune discretization.pen",
            vec!["discretization.penalty"],
        ),
        ("onset list ker", vec!["kernels"]),
        ("onset list method upd", vec!["updated-sph"]),
        ("onset verify deck --code pys", vec!["pysph"]),
        ("onset zoo trixi-371-c", vec!["trixi-371-cubic"]),
        (
            "onset state --preset lammps-smd-t",
            vec!["lammps-smd-tlsph"],
        ),
        ("onset map --set map.ada", vec!["map.adaptive="]),
        ("onset map --set map.adaptive=t", vec!["true"]),
        ("onset compare --set compare.sta", vec!["compare.states="]),
        ("onset localize --model mohr", vec!["mohr-coulomb"]),
        (
            "onset map --fail-on numerical,zero",
            vec!["numerical,zero-energy"],
        ),
    ] {
        assert_eq!(completed(line), expected, "{line}");
    }
    let deck = Scratch::new("two.inp");
    let text = "*MATERIAL, NAME=RUBBER_A\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.001\n\
                *MATERIAL, NAME=STEEL\n*ELASTIC\n2e5, 0.3\n\
                *MATERIAL, NAME=RUBBER_B\n*HYPERELASTIC, OGDEN, N=1\n0.6, 1.3, 0.001\n";
    std::fs::write(&deck, text).expect("a deck");
    let line = format!("onset card {} --material ", deck.display());
    assert_eq!(completed(&line), ["RUBBER_A", "RUBBER_B"]);
    assert_eq!(completed(&format!("{line}RUBBER_B")), ["RUBBER_B"]);
    let files = completed("onset check Car");
    assert!(files.iter().any(|file| file == "Cargo.toml"), "{files:?}");
}
