//! Reader for models of the Python packages `felupe` and `hyperelastic` with their keyword arguments, as in a script or in the output of a fit.
//!
//! The energies follow the documentation (felupe 11.3, hyperelastic 0.10). Ogden's moduli enter as `2 mu/alpha^2`, so that they add up to the shear
//! modulus. Polynomials are of `I1bar - 3` and `I2bar - 3`, and the volumetric part is `bulk (J - 1)^2/2`. The script is read as text: no Python
//! runs.

use super::law::{Energy, ForeignLaw, SQUARE, Volume, extended_tube, named, van_der_waals};
use super::unread::Chosen;
use super::write::{Block, Form, Refusal, Sheet, order, ordered};
use super::{Program, Trouble};
use onset_frames::brief;

/// Name of a model, and the conversion of its arguments to a law.
type Model = (&'static str, fn(&Call) -> Result<ForeignLaw, Trouble>);

const FELUPE: &[Model] = &[
    ("neo_hooke", neo_hooke),
    ("NeoHooke", neo_hooke),
    ("NeoHookeCompressible", compressible),
    ("mooney_rivlin", polynomial),
    ("yeoh", polynomial),
    ("third_order_deformation", polynomial),
    ("ogden", ogden),
    ("arruda_boyce", arruda_boyce),
    ("extended_tube", tube),
    ("storakers", storakers),
    ("blatz_ko", blatz_ko),
    ("saint_venant_kirchhoff", saint_venant_kirchhoff),
    ("anssari_benam_bucchi", anssari_benam_bucchi),
    ("lopez_pamies", lopez_pamies),
    ("van_der_waals", kilian),
];

/// Models of felupe without an equivalent energy in this program, and the reason.
const FELUPE_REFUSED: &[(&str, &str)] = &[
    (
        "alexander",
        "its energy is an integral of exp(k x^2), the imaginary error function, which formulas do not have",
    ),
    (
        "miehe_goektepe_lulei",
        "its energy is an average over the directions of a sphere, not a function of the invariants",
    ),
    (
        "saint_venant_kirchhoff_orthotropic",
        "its axes are three-dimensional vectors; set material.model=saint-venant-orthotropic with its parameters",
    ),
    (
        "morph",
        "its stress depends on the history of deformation; no energy determines it",
    ),
    (
        "morph_representative_directions",
        "its stress depends on the history of deformation; no energy determines it",
    ),
    (
        "finite_strain_viscoelastic",
        "its stress depends on the history of deformation; no energy determines it",
    ),
];

const HYPERELASTIC: &[Model] = &[("ThirdOrderDeformation", polynomial), ("Ogden", ogden)];

/// Arguments of the polynomials, with the powers of both invariants.
const POWERS: [(&str, (usize, usize)); 5] = [
    ("C10", (1, 0)),
    ("C01", (0, 1)),
    ("C11", (1, 1)),
    ("C20", (2, 0)),
    ("C30", (3, 0)),
];

/// A model with its arguments.
struct Call {
    line: usize,
    title: String,
    arguments: Vec<(String, Vec<f64>)>,
    /// Bulk modulus, from any part of the script.
    bulk: Option<f64>,
}

/// Statement of a script with models.
struct Statement<'t> {
    /// Name of the assigned variable; empty without an assignment.
    name: &'t str,
    text: &'t str,
    start: usize,
    /// Models in the statement, with their places in the script.
    models: Vec<(usize, &'static Model)>,
}

/// Reads a material of a text, by default the first material.
pub(super) fn read(
    program: Program,
    text: &str,
    material: Option<&str>,
) -> Result<ForeignLaw, Trouble> {
    let text = without_comments(text);
    let (package, models) = match program {
        Program::Hyperelastic => ("hyperelastic", HYPERELASTIC),
        _ => ("felupe", FELUPE),
    };
    let materials = materials(&text, models);
    let place = match material {
        None => 0,
        Some(wanted) => materials
            .iter()
            .position(|own| own.name == wanted)
            .ok_or_else(|| {
                let names: Vec<&str> = materials.iter().map(|own| own.name).collect();
                Trouble::no_such_material(wanted, &names)
            })?,
    };
    let Some(own) = materials.get(place) else {
        return Err(no_model(package, models, &words(&text), &text));
    };
    let (place_of_model, (name, make)) = own.models[0];
    let line = line_of(&text, place_of_model);
    let own_words = words(own.text);
    let refused = own_words.iter().find_map(|(place, word)| {
        let reason = FELUPE_REFUSED.iter().find(|(name, _)| name == word)?;
        Some((line_of(&text, own.start + place), reason))
    });
    if let Some((line, (name, reason))) = refused {
        return Err(not_supported(line, name, reason));
    }
    if let [_, (_, (second, _)), ..] = own.models[..] {
        return Err(Trouble::new(
            line,
            format!("the material is a sum, of {name} and {second}"),
            "one model is read with one volumetric part; type the energy of a sum with --energy",
        ));
    }
    if let Some((place, _)) = words(&text)
        .iter()
        .find(|(_, word)| ["DeformationSpace", "Deformation"].contains(word))
    {
        return Err(Trouble::new(
            line_of(&text, *place),
            "the model is applied to the whole deformation, which leaves stress at F = 1",
            "supported: models of the distortional part, DistortionalSpace",
        ));
    }
    let arguments = arguments(&text, place_of_model + name.len(), line)?;
    let count = |letters: [char; 3]| own.text.matches(letters).count();
    if count(['(', '[', '{']) > count([')', ']', '}']) {
        return Err(Trouble::new(
            line,
            format!("the brackets after {name} are not closed"),
            "the script is cut off, or lacks a bracket",
        ));
    }
    // A bulk modulus elsewhere in the script belongs to its only material.
    let bulk = match bulks(own.text, line)?[..] {
        [] if materials.len() == 1 => bulks(&text, line)?.first().copied(),
        [] => None,
        [one] => Some(one),
        _ => {
            return Err(Trouble::new(
                line,
                "the material has several bulk moduli, which add up",
                "give their sum as one bulk modulus",
            ));
        }
    };
    let mut law = make(&Call {
        line,
        title: format!("{name} of {package}"),
        arguments,
        bulk,
    })?;
    let softening = own_words.iter().find(|(_, word)| *word == "OgdenRoxburgh");
    law.unread.parts.extend(softening.map(|(place, word)| {
        (
            format!("{word}, softening by unloading"),
            line_of(&text, own.start + place),
        )
    }));
    law.unread.material = (materials.len() > 1).then(|| Chosen {
        name: own.name.to_owned(),
        place,
        all: materials
            .iter()
            .map(|other| other.name.to_owned())
            .collect(),
    });
    Ok(law)
}

/// Statements with models, except imports.
fn materials<'t>(text: &'t str, models: &'static [Model]) -> Vec<Statement<'t>> {
    let mut depth = 0_i32;
    let mut start = 0;
    let mut found = Vec::new();
    for (place, letter) in text.char_indices().chain([(text.len(), '\n')]) {
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            // A backslash continues the line.
            '\n' if place < text.len() && (depth > 0 || text[..place].ends_with('\\')) => {}
            '\n' | ';' => {
                let own = &text[start..place];
                let is_import = ["import ", "from "]
                    .iter()
                    .any(|word| own.trim_start().starts_with(word));
                let of_model = |(at, word): (usize, &str)| {
                    let model = models.iter().find(|(name, _)| *name == word)?;
                    Some((start + at, model))
                };
                let own_models: Vec<_> = words(own).into_iter().filter_map(of_model).collect();
                if !is_import && !own_models.is_empty() {
                    let name = own.split_once('=').map_or("", |(name, _)| name.trim());
                    let is_name = |name: &str| {
                        name.chars()
                            .all(|letter| letter.is_alphanumeric() || letter == '_')
                    };
                    found.push(Statement {
                        name: if is_name(name) { name } else { "" },
                        text: own,
                        start,
                        models: own_models,
                    });
                }
                (start, depth) = (place + 1, 0);
            }
            _ => {}
        }
    }
    found
}

fn not_supported(line: usize, name: &str, reason: &str) -> Trouble {
    Trouble::new(
        line,
        format!("{name} of felupe is not supported: {reason}"),
        "choose another law, or type its energy with --energy",
    )
}

/// Error for a text without a known model.
fn no_model(
    package: &'static str,
    models: &[Model],
    words: &[(usize, &str)],
    text: &str,
) -> Trouble {
    let refused = words.iter().find_map(|(place, word)| {
        let reason = FELUPE_REFUSED.iter().find(|(name, _)| name == word)?;
        (package == "felupe").then_some((*place, reason))
    });
    if let Some((place, (name, reason))) = refused {
        return not_supported(line_of(text, place), name, reason);
    }
    let names: Vec<&str> = models.iter().map(|(name, _)| *name).collect();
    let is_gent = words
        .iter()
        .any(|(_, word)| word.eq_ignore_ascii_case("gent"));
    match is_gent {
        true => Trouble::new(
            1,
            format!("{package} has no model of Gent's law; a script must define it as a function"),
            "set it by name, with J_m = I1bar - 3 at locking: --set material.model=gent --set material.mu=0.3 --set material.jm=50 --set \
             material.kappa=300",
        ),
        false => Trouble::new(
            1,
            format!(
                "there is no model of {package} in this text; supported: {}",
                names.join(", ")
            ),
            "expected a model with its arguments by name, for example `fem.Hyperelastic(fem.ogden, mu=[1.0, 0.2], alpha=[1.7, -1.5])` of felupe or \
             `ThirdOrderDeformation(C10=0.5, C20=-0.05)` of hyperelastic",
        ),
    }
}

/// Blanks out the comments and the texts in triple quotes, so that positions stay valid.
fn without_comments(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    let first = |rest: &str| {
        let begins = ["#", "\"\"\"", "'''"].map(|mark| Some((rest.find(mark)?, mark)));
        begins.into_iter().flatten().min()
    };
    while let Some((begin, mark)) = first(rest) {
        let (before, own) = rest.split_at(begin);
        let end = match mark {
            "#" => own.find('\n'),
            quotes => own[3..].find(quotes).map(|end| end + 6),
        };
        let (blank, after) = own.split_at(end.unwrap_or(own.len()));
        kept.push_str(before);
        for letter in blank.chars() {
            match letter {
                '\n' => kept.push('\n'),
                _ => kept.extend(std::iter::repeat_n(' ', letter.len_utf8())),
            }
        }
        rest = after;
    }
    kept + rest
}

/// Names in a text with their positions.
fn words(text: &str) -> Vec<(usize, &str)> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let mut words = Vec::new();
    let mut start = None;
    for (place, letter) in text.char_indices().chain([(text.len(), ' ')]) {
        match (start, is_part(letter)) {
            (None, true) => start = Some(place),
            (Some(begin), false) => {
                words.push((begin, &text[begin..place]));
                start = None;
            }
            _ => {}
        }
    }
    words
}

fn line_of(text: &str, place: usize) -> usize {
    text[..place].matches('\n').count() + 1
}

/// Named arguments of a model, from the parentheses after it or around it.
fn arguments(text: &str, end: usize, line: usize) -> Result<Vec<(String, Vec<f64>)>, Trouble> {
    let rest = text[end..].trim_start();
    let inside = rest.strip_prefix('(').unwrap_or(rest);
    let mut depth = 0_i32;
    let mut parts = vec![String::new()];
    for letter in inside.chars() {
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        if depth < 0 {
            break;
        }
        match parts.last_mut() {
            Some(part) if letter != ',' || depth > 0 => part.push(letter),
            _ => parts.push(String::new()),
        }
    }
    let parts = parts.iter().map(|part| part.trim());
    parts
        .filter(|part| !part.is_empty())
        .map(|part| match part.split_once('=') {
            Some((name, value)) => Ok((name.trim().to_owned(), numbers(value, name.trim(), line)?)),
            None => Err(Trouble::new(
                line,
                format!("the argument `{}` has no name", brief(part)),
                "give arguments by name, as in mu=[1.0], alpha=[2.0]",
            )),
        })
        .filter(|argument| {
            // Other options of a material are not part of the law.
            !matches!(argument, Ok((name, _)) if ["parallel", "nstatevars"].contains(&name.as_str()))
        })
        .collect()
}

/// Reads a number or a list of numbers.
fn numbers(value: &str, name: &str, line: usize) -> Result<Vec<f64>, Trouble> {
    if ["True", "False"].contains(&value.trim()) {
        return Ok(Vec::new());
    }
    if value.trim().is_empty() {
        return Err(Trouble::new(
            line,
            format!("{} has no value", brief(name)),
            "expected a number, or a list of numbers",
        ));
    }
    // `np.array([...])` is a list with a name before it.
    let list = value
        .find(['[', '('])
        .map_or(value, |open| &value[open..])
        .trim_matches(|letter: char| "[](), \t\n".contains(letter));
    let fields = list
        .split(',')
        .map(str::trim)
        .filter(|field| !field.is_empty());
    fields
        .map(|field| {
            let plain = field.replace('_', "");
            let number = plain
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite());
            number.ok_or_else(|| {
                Trouble::new(
                    line,
                    format!("{} is `{}`", brief(name), brief(field)),
                    "expected numbers, not names of a script or expressions",
                )
            })
        })
        .collect()
}

/// Values of `bulk=` in a text, as in `Volumetric(bulk=...)` and solid bodies.
fn bulks(text: &str, line: usize) -> Result<Vec<f64>, Trouble> {
    let stated = words(text).into_iter().filter_map(|(place, word)| {
        let value = text[place + word.len()..].trim_start().strip_prefix('=')?;
        (word == "bulk").then(|| {
            value
                .split([',', ')', '\n', '}'])
                .next()
                .unwrap_or_default()
        })
    });
    let mut found = Vec::new();
    for value in stated {
        found.extend(numbers(value, "bulk", line)?);
    }
    Ok(found)
}

impl Call {
    fn list(&self, name: &str) -> Option<&[f64]> {
        let found = self.arguments.iter().find(|(own, _)| own == name);
        found.map(|(_, numbers)| numbers.as_slice())
    }

    fn required(&self, name: &str) -> Result<&[f64], Trouble> {
        self.list(name)
            .filter(|list| !list.is_empty())
            .ok_or_else(|| {
                Trouble::new(
                    self.line,
                    format!("{} has no `{name}`", self.title),
                    "give all arguments by name, as the documentation of the package names them",
                )
            })
    }

    fn one(&self, name: &str) -> Result<f64, Trouble> {
        match self.required(name)? {
            [one] => Ok(*one),
            list => Err(Trouble::new(
                self.line,
                format!("`{name}` has {} numbers; expected one", list.len()),
                "a list is for models with several terms",
            )),
        }
    }

    /// Lists of equal length, with nonzero exponents.
    fn terms<const N: usize>(&self, names: [&str; N]) -> Result<Vec<[f64; N]>, Trouble> {
        let mut lists = Vec::new();
        for name in names {
            lists.push(self.required(name)?);
        }
        let count = lists[0].len();
        if lists.iter().any(|list| list.len() != count) || count > 6 {
            return Err(Trouble::new(
                self.line,
                format!(
                    "{} differ in length, or are more than six",
                    names.join(" and ")
                ),
                "expected one number in each for each term, up to six terms",
            ));
        }
        let terms: Vec<[f64; N]> = (0..count)
            .map(|n| std::array::from_fn(|list| lists[list][n]))
            .collect();
        match terms.iter().any(|term| term[1] == 0.0) {
            true => Err(Trouble::new(
                self.line,
                "an exponent alpha is 0",
                "expected exponents other than 0",
            )),
            false => Ok(terms),
        }
    }

    /// `bulk (J - 1)^2/2`; incompressible if the script gives no bulk modulus.
    fn volume(&self) -> Result<Volume<'static>, Trouble> {
        match self.bulk {
            None => Ok(Volume::Function(SQUARE, None)),
            Some(bulk) if bulk > 0.0 => Ok(Volume::Function(SQUARE, Some(bulk))),
            Some(bulk) => Err(Trouble::new(
                self.line,
                format!("bulk is {bulk}; expected a positive number"),
                "omit bulk for an incompressible material",
            )),
        }
    }

    /// Refuses arguments that the model does not have.
    fn only(&self, names: &[&str]) -> Result<(), Trouble> {
        let known = |name: &str| names.contains(&name) || name == "bulk";
        match self.arguments.iter().find(|(name, _)| !known(name)) {
            None => Ok(()),
            Some((name, _)) => Err(Trouble::new(
                self.line,
                format!(
                    "{} has no argument `{}`; its arguments are {}",
                    self.title,
                    brief(name),
                    names.join(", ")
                ),
                "check the name, upper and lower case count",
            )),
        }
    }

    /// Polynomial with constants by the powers of both invariants, and the volumetric part of the call.
    fn polynomial(&self, constants: &[((usize, usize), f64)]) -> Result<ForeignLaw, Trouble> {
        let volume = self.volume()?;
        Ok(ForeignLaw::polynomial(
            self.line,
            &self.title,
            constants,
            volume,
        ))
    }
}

fn neo_hooke(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu"])?;
    let constants = [((1, 0), 0.5 * call.one("mu")?)];
    call.polynomial(&constants)
}

/// Reads `C10`, `C01`, ...; missing constants are zero in both packages, or not part of the model.
fn polynomial(call: &Call) -> Result<ForeignLaw, Trouble> {
    let taken: &[&str] = match call.title.split(' ').next() {
        Some("mooney_rivlin") => &["C10", "C01"],
        Some("yeoh") => &["C10", "C20", "C30"],
        _ => &["C10", "C01", "C11", "C20", "C30"],
    };
    // `strain=False` measures invariants from 3, which is the usual convention.
    call.only(&[taken, &["strain"]].concat())?;
    let mut constants = Vec::new();
    for (name, powers) in POWERS {
        if call.list(name).is_some() {
            constants.push((powers, call.one(name)?));
        }
    }
    if constants.iter().all(|(_, value)| *value == 0.0) {
        return Err(Trouble::new(
            call.line,
            format!("all constants of {} are zero", call.title),
            "expected C10=0.5, ...",
        ));
    }
    call.polynomial(&constants)
}

/// `2 mu_i/alpha_i^2` in `sum 2 mu_i/alpha_i^2 (sum lbar^alpha_i - 3)` corresponds to `mu_i/alpha_i` in the library.
fn ogden(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "alpha"])?;
    let terms = call.terms(["mu", "alpha"])?;
    let terms: Vec<(f64, f64)> = terms
        .iter()
        .map(|[mu, alpha]| (2.0 * mu / alpha, *alpha))
        .collect();
    let volume = call.volume()?;
    Ok(ForeignLaw::ogden(call.line, &call.title, &terms, volume))
}

/// Arruda-Boyce law with five terms of its series, `C1` as the modulus and `limit` as the locking stretch.
fn arruda_boyce(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["C1", "limit"])?;
    let constants = (call.one("C1")?, call.one("limit")?);
    let volume = call.volume()?;
    Ok(ForeignLaw::arruda_boyce(
        call.line,
        &call.title,
        constants,
        volume,
    ))
}

fn tube(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["Gc", "delta", "Ge", "beta"])?;
    let mut constants = [0.0; 4];
    for (constant, name) in constants.iter_mut().zip(["Gc", "delta", "Ge", "beta"]) {
        *constant = call.one(name)?;
    }
    extended_tube(call.line, &call.title, constants, call.volume()?)
}

/// Energy of felupe for foams: `sum 2 mu/alpha^2 (sum l^alpha - 3 + (J^(-alpha beta) - 1)/beta)`.
fn storakers(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "alpha", "beta"])?;
    let terms = call.terms(["mu", "alpha", "beta"])?;
    Ok(ForeignLaw::foam(call.line, &call.title, &terms))
}

/// Reads the compressible law `mu (tr C/2 - ln J) + lambda (ln J)^2/2`.
fn compressible(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "lmbda"])?;
    let lambda = match call.list("lmbda") {
        Some(_) => call.one("lmbda")?,
        None => 0.0,
    };
    let constants = named(&[("mu", call.one("mu")?), ("lambda", lambda)]);
    let model = Energy::Model("neo-hooke");
    Ok(ForeignLaw::of_constants(
        call.line,
        &call.title,
        model,
        constants,
    ))
}

/// felupe documents `mu/2 (I2/I3 + 2 J - 5)` and evaluates twice this energy.
fn blatz_ko(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu"])?;
    let constants = named(&[("mu", 2.0 * call.one("mu")?)]);
    let model = Energy::Model("blatz-ko");
    let mut law = ForeignLaw::of_constants(call.line, &call.title, model, constants);
    law.notes.push(
        "blatz_ko of felupe 11.3 evaluates mu (I2/I3 + 2 J - 5) with the shear modulus 2 mu, twice its documented energy; onset reads the energy that felupe evaluates"
            .to_owned(),
    );
    Ok(law)
}

fn saint_venant_kirchhoff(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "lmbda", "k"])?;
    let (mu, lambda) = (call.one("mu")?, call.one("lmbda")?);
    let exponent = match call.list("k") {
        Some(_) => call.one("k")?,
        None => 2.0,
    };
    let (model, constants) = match exponent {
        2.0 => ("saint-venant-kirchhoff", [("mu", mu), ("lambda", lambda)]),
        0.0 => ("hencky", [("mu", mu), ("kappa", lambda + mu / 1.5)]),
        _ => {
            return Err(Trouble::new(
                call.line,
                format!("k is {exponent}; expected 2 (Green's strain) or 0 (Hencky's strain)"),
                "type the energy of other strains with --energy",
            ));
        }
    };
    Ok(ForeignLaw::of_constants(
        call.line,
        &call.title,
        Energy::Model(model),
        named(&constants),
    ))
}

/// Reads the law of Anssari-Benam and Bucchi: `mu N ((I1bar - 3)/(6 N) - ln((I1bar - 3 N)/(3 - 3 N)))`.
fn anssari_benam_bucchi(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "N"])?;
    let (mu, links) = (call.one("mu")?, call.one("N")?);
    if links <= 1.0 {
        return Err(Trouble::new(
            call.line,
            format!("N is {links}; expected more than 1"),
            "N is the number of segments of a chain",
        ));
    }
    let volume = call.volume()?;
    let energy = format!(
        "mu*((I1bar - 3)/6 - links*ln((3*links - I1bar)/(3*links - 3))) + {}",
        volume.energy()
    );
    let shear = mu * (3.0 * links - 1.0) / (3.0 * links - 3.0);
    Ok(ForeignLaw::new(
        call.line,
        &call.title,
        Energy::Formula(energy),
        named(&[("mu", mu), ("links", links)]),
        (shear, volume),
    ))
}

/// Reads the law of Lopez-Pamies: `sum 3^(1 - alpha)/(2 alpha) mu (I1bar^alpha - 3^alpha)`.
fn lopez_pamies(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "alpha"])?;
    let terms = call.terms(["mu", "alpha"])?;
    let mut constants = Vec::new();
    for (n, [mu, alpha]) in terms.iter().enumerate() {
        constants.push((format!("mu{}", n + 1), *mu));
        constants.push((format!("alpha{}", n + 1), *alpha));
    }
    let term =
        |n: usize| format!("3^(1 - alpha{n})/(2*alpha{n})*mu{n}*(I1bar^alpha{n} - 3^alpha{n})");
    let volume = call.volume()?;
    let energy: Vec<String> = (1..=terms.len()).map(term).collect();
    let energy = format!("{} + {}", energy.join(" + "), volume.energy());
    let shear = terms.iter().map(|[mu, _]| mu).sum();
    let energy = Energy::Formula(energy);
    Ok(ForeignLaw::new(
        call.line,
        &call.title,
        energy,
        constants,
        (shear, volume),
    ))
}

/// Kilian's energy; the evaluation of felupe differs where the volume changes.
fn kilian(call: &Call) -> Result<ForeignLaw, Trouble> {
    call.only(&["mu", "limit", "a", "beta"])?;
    let mut constants = [0.0; 4];
    for (constant, name) in constants.iter_mut().zip(["mu", "limit", "a", "beta"]) {
        *constant = call.one(name)?;
    }
    let mut law = van_der_waals(call.line, &call.title, constants, call.volume()?)?;
    law.notes.push(
        "Kilian's energy of the isochoric invariants is read; felupe 11.3 adds 1e-4 to I - 3, and with beta > 0 forms its second invariant from tr C \
         with the change of volume"
            .to_owned(),
    );
    Ok(law)
}

/// Writes a law as a script.
pub(super) fn write(program: Program, sheet: &Sheet) -> Result<Block, Refusal> {
    let list = |values: Vec<f64>| {
        let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        format!("[{}]", values.join(", "))
    };
    let is_felupe = program == Program::Felupe;
    let (model, arguments) = match &sheet.form {
        Form::Polynomial(constants) => {
            let (model, count) = match order(constants) {
                _ if !is_felupe => ("invariants.ThirdOrderDeformation", 5),
                (1, true) => ("neo_hooke", 1),
                (1, false) => ("mooney_rivlin", 2),
                (2 | 3, true) => ("yeoh", 3),
                _ => ("third_order_deformation", 5),
            };
            let powers: Vec<(usize, usize)> = POWERS.iter().map(|(_, powers)| *powers).collect();
            let values = ordered(constants, &powers)?;
            let arguments = POWERS.iter().zip(values);
            let arguments = arguments.filter(|((_, (_, j)), _)| count != 3 || *j == 0);
            let arguments: Vec<String> = match count {
                1 => vec![format!("mu={:?}", sheet.shear())],
                2 => arguments.take(2).map(argument).collect(),
                _ => arguments.map(argument).collect(),
            };
            (model, arguments.join(", "))
        }
        Form::Ogden(terms) => {
            let model = if is_felupe {
                "ogden"
            } else {
                "stretches.Ogden"
            };
            let moduli = terms.iter().map(|(mu, alpha)| 0.5 * mu * alpha).collect();
            let exponents = terms.iter().map(|(_, alpha)| *alpha).collect();
            let arguments = format!("mu={}, alpha={}", list(moduli), list(exponents));
            (model, arguments)
        }
        Form::ArrudaBoyce(mu, locking) if is_felupe => {
            ("arruda_boyce", format!("C1={mu:?}, limit={locking:?}"))
        }
        Form::Foam(terms) if is_felupe => {
            let of = |place: usize| list(terms.iter().map(|term| term[place]).collect());
            let arguments = format!("mu={}, alpha={}, beta={}", of(0), of(1), of(2));
            ("storakers", arguments)
        }
        _ => return Err(Refusal::Lacks),
    };
    let volume = match (&sheet.form, sheet.bulk) {
        (Form::Foam(_), _) | (_, None) => String::new(),
        (_, Some(bulk)) => format!(" & fem.Volumetric(bulk={bulk:?})"),
    };
    let mut lines = vec!["import felupe as fem".to_owned()];
    match is_felupe {
        true => lines.push(format!(
            "umat = fem.Hyperelastic(fem.{model}, {arguments}){volume}"
        )),
        false => {
            let framework = match sheet.form {
                Form::Ogden(_) => "StretchesFramework",
                _ => "InvariantsFramework",
            };
            lines.push("import hyperelastic".to_owned());
            lines.push(format!("model = hyperelastic.models.{model}({arguments})"));
            lines.push(format!("framework = hyperelastic.{framework}(model)"));
            lines.push(format!(
                "umat = hyperelastic.DistortionalSpace(framework){volume}"
            ));
        }
    }
    let is_foam = matches!(sheet.form, Form::Foam(_));
    Ok(Block {
        lines,
        function: (!is_foam).then_some(SQUARE),
        notes: Vec::new(),
    })
}

fn argument(((name, _), value): (&(&str, (usize, usize)), f64)) -> String {
    format!("{name}={value:?}")
}
