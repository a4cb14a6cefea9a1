//! Reader for isotropic materials of FEBio.
//!
//! The energies follow the FEBio User and Theory Manuals, and the stresses of the sources of FEBio 4.
//!
//! - Uncoupled materials have `U(J)` by `pressure_model` with the bulk modulus `k`: `k/2 (ln J)^2` by default.
//! - Ogden has `c_i/m_i^2`. Mooney-Rivlin, Yeoh and Arruda-Boyce have the isochoric invariants.
//! - `neo-Hookean`, `coupled Mooney-Rivlin` and `Ogden unconstrained` are energies of the whole deformation.

use super::law::{Energy, ForeignLaw, HENCKY, LOGARITHM, SQUARE, Volume, named};
use super::unread::{Chosen, Relaxation, Unread};
use super::write::{Block, Form, Refusal, Sheet, order, ordered};
use super::{Program, Trouble, number};
use onset::material::PronyTerm;
use onset_frames::{brief, cut};
use roxmltree::{Document, Node};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::BTreeSet;

/// Materials by type, and what reads them.
const LAWS: [(&str, Reader); 10] = [
    ("neo-Hookean", neo_hooke),
    ("incomp neo-Hookean", uncoupled_neo_hooke),
    ("Mooney-Rivlin", mooney_rivlin),
    ("coupled Mooney-Rivlin", coupled_mooney_rivlin),
    ("Yeoh", yeoh),
    ("polynomial", polynomial),
    ("Ogden", ogden),
    ("Ogden unconstrained", unconstrained_ogden),
    ("Arruda-Boyce", arruda_boyce),
    ("Gent", gent),
];

/// Powers of the constants of `polynomial`.
const POWERS: [(usize, usize); 8] = [
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (2, 1),
    (1, 2),
    (2, 2),
];

type Reader = fn(&Law<'_, '_>) -> Result<ForeignLaw, Trouble>;

/// Element of a law.
struct Law<'d, 't> {
    node: Node<'d, 't>,
    kind: &'d str,
    line: usize,
    /// Names of the parameters that the law has.
    known: RefCell<BTreeSet<String>>,
}

/// Reads the law of the material with the given number or name, or the first law.
pub(super) fn read(text: &str, material: Option<&str>) -> Result<ForeignLaw, Trouble> {
    // A block may be a part of a file, with several materials and no root element. Line breaks before it are kept, so that errors name the right line.
    let body = match text.trim_start().starts_with("<?") {
        true => text.split_once("?>").map_or("", |(_, body)| body),
        false => text,
    };
    let before = text[..text.len() - body.len()].matches('\n').count();
    let whole = format!("{}<all>{body}\n</all>", "\n".repeat(before));
    let document = Document::parse(&whole).map_err(|error| {
        Trouble::new(
            error.pos().row as usize,
            format!("the text is not XML: {}", fault(&error)),
            "expected <material id=\"1\" type=\"Ogden\"> with its parameters",
        )
    })?;
    let materials: Vec<Node<'_, '_>> = document
        .descendants()
        .filter(|node| node.has_tag_name("material") && node.attribute("type").is_some())
        .collect();
    let name = |node: &Node<'_, '_>| {
        let own = node.attribute("name").or_else(|| node.attribute("id"));
        own.unwrap_or_default().to_owned()
    };
    let with_law: Vec<_> = materials
        .iter()
        .filter_map(|node| Some((name(node), node, law_in(*node)?)))
        .collect();
    let is_wanted = |node: &Node<'_, '_>| {
        material.is_none_or(|wanted| {
            [node.attribute("name"), node.attribute("id")].contains(&Some(wanted))
        })
    };
    let at = with_law.iter().position(|(_, node, _)| is_wanted(node));
    let Some(at) = at else {
        let names: Vec<&str> = with_law.iter().map(|(name, _, _)| name.as_str()).collect();
        return Err(match (material, materials.first()) {
            (Some(wanted), _) if !names.is_empty() => Trouble::no_such_material(wanted, &names),
            (_, Some(node)) => elastic(*node).unwrap_or_else(|| {
                Trouble::new(
                    line_of(node),
                    format!(
                        "the type \"{}\" is not supported",
                        cut(node.attribute("type").unwrap_or_default())
                    ),
                    HINT,
                )
            }),
            (_, None) => Trouble::no_law(Program::Febio, HINT),
        });
    };
    let (own, node, (law, reader)) = &with_law[at];
    let law = &Law {
        node: *law,
        kind: law.attribute("type").unwrap_or_default(),
        line: line_of(law),
        known: RefCell::new(BTreeSet::from(["density".to_owned()])),
    };
    let mut read = reader(law)?;
    read.unread = unread(**node, law, read.shear)?;
    read.unread.material = Some(Chosen {
        name: own.clone(),
        place: at,
        all: with_law.iter().map(|(name, ..)| name.clone()).collect(),
    });
    Ok(read)
}

/// Description of an error of XML, without names of the text.
fn fault(error: &roxmltree::Error) -> String {
    use roxmltree::Error;
    let own = match error {
        Error::UnexpectedCloseTag(..) => "a tag is closed under another name",
        Error::DuplicatedAttribute(..) => "an attribute is given twice",
        Error::DuplicatedNamespace(..) | Error::UnknownNamespace(..) => {
            "a namespace is unknown or defined twice"
        }
        Error::UnknownEntityReference(..) => "an entity is unknown",
        other => return other.to_string(),
    };
    own.to_owned()
}

const HINT: &str = "supported: neo-Hookean, incomp neo-Hookean, Mooney-Rivlin, coupled Mooney-Rivlin, Yeoh, polynomial, Ogden, Ogden unconstrained, \
                    Arruda-Boyce and Gent";

/// Error for a material of the type `isotropic elastic`.
fn elastic(node: Node<'_, '_>) -> Option<Trouble> {
    if node.attribute("type") != Some("isotropic elastic") {
        return None;
    }
    let modulus = |name: &str| {
        let own = node.children().find(|child| child.has_tag_name(name))?;
        value_of(&own).ok()
    };
    Trouble::linear(
        line_of(&node),
        "\"isotropic elastic\"",
        [modulus("E")?, modulus("v")?],
    )
}

/// Line of an element, found by reading the text from its beginning: not for each element of a file.
fn line_of(node: &Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

/// The material itself or the first part of it that has a known type.
fn law_in<'d, 't>(material: Node<'d, 't>) -> Option<(Node<'d, 't>, Reader)> {
    material.descendants().find_map(|node| {
        let kind = node.attribute("type")?;
        let (_, reader) = LAWS.iter().find(|(name, _)| *name == kind)?;
        Some((node, *reader))
    })
}

/// Parameters that the law does not have, and parts of a material around the law.
fn unread(
    material: Node<'_, '_>,
    law: &Law<'_, '_>,
    shear: Option<f64>,
) -> Result<Unread, Trouble> {
    let mut unread = Unread::default();
    let known = law.known.borrow();
    let parameters = law.node.children().filter(Node::is_element);
    let parameters = parameters.filter(|node| !known.contains(node.tag_name().name()));
    // Only the first parts are shown with their lines.
    let shown_line = |n: usize, node: &Node<'_, '_>| match n < super::LISTED {
        true => line_of(node),
        false => 0,
    };
    let parameters = parameters.enumerate().map(|(n, node)| {
        let part = format!("<{}>", brief(node.tag_name().name()));
        (part, shown_line(n, &node))
    });
    unread.parts.extend(parameters);
    if material == law.node {
        return Ok(unread);
    }
    let kind = material.attribute("type").unwrap_or_default();
    let others = material.children().filter(|node| {
        node.attribute("type").is_some() && !law.node.ancestors().any(|around| around == *node)
    });
    let others = others.enumerate().map(|(n, node)| {
        let part = format!(
            "<{} type=\"{}\">",
            brief(node.tag_name().name()),
            cut(node.attribute("type").unwrap_or_default())
        );
        (part, shown_line(n, &node))
    });
    unread.parts.extend(others);
    if kind.ends_with("viscoelastic") && shear.is_some() {
        let mut rest = 1.0;
        let mut parts = [BTreeMap::new(), BTreeMap::new()];
        for node in material.children().filter(Node::is_element) {
            let name = node.tag_name().name();
            let numbered = |letter: char| name.strip_prefix(letter)?.parse::<usize>().ok();
            match (numbered('g'), numbered('t')) {
                (Some(0), _) => rest = value_of(&node)?,
                (Some(n), _) => drop(parts[0].insert(n, value_of(&node)?)),
                (_, Some(n)) => drop(parts[1].insert(n, value_of(&node)?)),
                _ => {}
            }
        }
        let [strengths, times] = parts;
        let sum: f64 = strengths.values().sum();
        let term = |(n, strength): (&usize, &f64)| {
            let shear = strength / (1.0 + sum);
            Some(PronyTerm {
                shear,
                // The uncoupled form relaxes the deviatoric stress alone.
                bulk: if kind.starts_with("uncoupled") {
                    0.0
                } else {
                    shear
                },
                time: *times.get(n)?,
            })
        };
        let terms: Option<Vec<PronyTerm>> = strengths.iter().map(term).collect();
        unread.relaxation = Some(Relaxation {
            terms: terms.filter(|_| rest == 1.0 && sum > 0.0),
            is_long_term: true,
            by: "FEBio adds g1, g2, ... to g0 = 1",
            keyword: Some((format!("type=\"{}\"", cut(kind)), line_of(&material))),
        });
    }
    let relaxation = unread.relaxation.as_ref();
    if relaxation.is_none_or(|own| own.terms.is_none()) {
        let part = format!("type=\"{}\"", cut(kind));
        unread.parts.insert(0, (part, line_of(&material)));
    }
    Ok(unread)
}

/// Number of an element.
fn value_of(node: &Node<'_, '_>) -> Result<f64, Trouble> {
    let text = node.text().unwrap_or_default();
    let kind = node.attribute("type").filter(|kind| *kind != "const");
    if let Some(kind) = kind {
        return Err(Trouble::new(
            line_of(node),
            format!(
                "<{}> is given by type=\"{}\", which is not supported",
                node.tag_name().name(),
                brief(kind)
            ),
            "expected a number",
        ));
    }
    if node.attribute("lc").is_some() {
        return Err(Trouble::new(
            line_of(node),
            format!(
                "<{}> is multiplied by a load curve, which is not supported",
                node.tag_name().name()
            ),
            "give the value at one time, without lc",
        ));
    }
    number(text, 0).map_err(|trouble| Trouble {
        line: line_of(node),
        ..trouble
    })
}

impl Law<'_, '_> {
    fn title(&self) -> String {
        format!("{} of FEBio", self.kind)
    }

    /// Parameter of the law, or of a material around it.
    fn given(&self, name: &str) -> Result<Option<f64>, Trouble> {
        self.known.borrow_mut().insert(name.to_owned());
        let mut around = self
            .node
            .ancestors()
            .take_while(|node| !node.has_tag_name("all"));
        let found = around.find_map(|node| node.children().find(|own| own.has_tag_name(name)));
        found.map(|node| value_of(&node)).transpose()
    }

    fn required(&self, name: &str) -> Result<f64, Trouble> {
        self.given(name)?.ok_or_else(|| {
            Trouble::new(
                self.line,
                format!("the material {} has no <{name}>", self.kind),
                "give all parameters of the material as the FEBio User Manual names them",
            )
        })
    }

    fn or_zero(&self, name: &str) -> Result<f64, Trouble> {
        Ok(self.given(name)?.unwrap_or(0.0))
    }

    /// Numbered constants, zero where they are missing.
    fn list<const N: usize>(&self, letter: char) -> Result<[f64; N], Trouble> {
        let mut numbers = [0.0; N];
        for (n, own) in numbers.iter_mut().enumerate() {
            *own = self.or_zero(&format!("{letter}{}", n + 1))?;
        }
        Ok(numbers)
    }

    /// `U(J)` of an uncoupled material.
    fn volume(&self) -> Result<Volume<'static>, Trouble> {
        let bulk = self.required("k")?;
        if bulk <= 0.0 {
            return Err(Trouble::new(
                self.line,
                format!("k is {bulk}; expected a positive bulk modulus"),
                "FEBio refuses it too",
            ));
        }
        self.known.borrow_mut().insert("pressure_model".to_owned());
        let mut around = self.node.ancestors();
        let model = around.find_map(|node| {
            node.children()
                .find(|own| own.has_tag_name("pressure_model"))
        });
        let model = model
            .and_then(|node| node.text())
            .unwrap_or("0")
            .trim()
            .to_ascii_lowercase();
        let function = match model.as_str() {
            "0" | "default" => HENCKY,
            "1" | "nike3d" | "3" | "abaqus (goh)" => LOGARITHM,
            "2" | "abaqus" => SQUARE,
            other => {
                return Err(Trouble::new(
                    self.line,
                    format!("pressure_model is {}", brief(other)),
                    "expected default, NIKE3D, Abaqus or Abaqus (GOH), or 0 to 3",
                ));
            }
        };
        Ok(Volume::Function(function, Some(bulk)))
    }

    /// Terms `c_i/m_i^2 (...)` as `mu_i/alpha_i (...)`.
    fn terms(&self) -> Result<Vec<(f64, f64)>, Trouble> {
        let (moduli, exponents) = (self.list::<6>('c')?, self.list::<6>('m')?);
        let mut own = Vec::new();
        for (modulus, exponent) in moduli.into_iter().zip(exponents) {
            // FEBio takes the exponent 1 where it is missing.
            let exponent = if exponent == 0.0 { 1.0 } else { exponent };
            if modulus != 0.0 {
                own.push((modulus / exponent, exponent));
            }
        }
        match own.is_empty() {
            true => Err(Trouble::new(
                self.line,
                format!("the material {} has no <c1> other than 0", self.kind),
                "expected c1, m1, c2, m2, ...",
            )),
            false => Ok(own),
        }
    }

    fn polynomial(&self, constants: &[((usize, usize), f64)]) -> Result<ForeignLaw, Trouble> {
        let volume = self.volume()?;
        Ok(ForeignLaw::polynomial(
            self.line,
            self.title(),
            constants,
            volume,
        ))
    }

    fn of_constants(&self, energy: Energy, constants: &[(&str, f64)], shear: f64) -> ForeignLaw {
        let mut law = ForeignLaw::of_constants(self.line, self.title(), energy, named(constants));
        law.shear = Some(shear);
        law
    }
}

fn neo_hooke(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let (young, poisson) = (law.required("E")?, law.required("v")?);
    if young <= 0.0 || poisson <= -1.0 || poisson >= 0.5 {
        return Err(Trouble::new(
            law.line,
            format!("E is {young} and v is {poisson}; expected E above 0 and v between -1 and 0.5"),
            "FEBio refuses them too",
        ));
    }
    let mu = young / (2.0 * (1.0 + poisson));
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    let model = Energy::Model("neo-hooke");
    Ok(law.of_constants(model, &[("mu", mu), ("lambda", lambda)], mu))
}

fn uncoupled_neo_hooke(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    law.polynomial(&[((1, 0), 0.5 * law.required("G")?)])
}

fn mooney_rivlin(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    law.polynomial(&[((1, 0), law.required("c1")?), ((0, 1), law.or_zero("c2")?)])
}

fn coupled_mooney_rivlin(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let (c10, c01) = (law.required("c1")?, law.or_zero("c2")?);
    let constants = [("c10", c10), ("c01", c01), ("lambda", law.required("k")?)];
    let model = Energy::Model("mooney-rivlin");
    Ok(law.of_constants(model, &constants, 2.0 * (c10 + c01)))
}

fn yeoh(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let own = law.list::<6>('c')?;
    let constants: Vec<_> = own
        .iter()
        .enumerate()
        .map(|(n, c)| ((n + 1, 0), c / (n + 1) as f64))
        .collect();
    let note = own[1..].iter().any(|c| *c != 0.0).then(|| {
        "FEBio documents the energy sum c_i x^i, x = I1bar - 3, and evaluates the stress of sum c_i x^i/i; onset reads the law that FEBio evaluates"
            .to_owned()
    });
    Ok(law.polynomial(&constants)?.noted(note))
}

fn polynomial(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let mut constants = Vec::new();
    for (i, j) in POWERS {
        constants.push(((i, j), law.or_zero(&format!("c{i}{j}"))?));
    }
    // FEBio multiplies by D1 where other programs divide.
    let compressibilities = [law.required("D1")?, law.or_zero("D2")?];
    let compressibilities = compressibilities.map(|d| if d == 0.0 { 0.0 } else { 1.0 / d });
    let volume = Volume::Powers(&compressibilities);
    Ok(ForeignLaw::polynomial(
        law.line,
        law.title(),
        &constants,
        volume,
    ))
}

fn ogden(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let (terms, volume) = (law.terms()?, law.volume()?);
    Ok(ForeignLaw::ogden(law.line, law.title(), &terms, volume))
}

fn unconstrained_ogden(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let terms = law.terms()?;
    let mut constants = Vec::new();
    let mut energy = String::new();
    for (n, (mu, alpha)) in terms.iter().enumerate() {
        let n = n + 1;
        constants.push((format!("mu{n}"), *mu));
        constants.push((format!("alpha{n}"), *alpha));
        energy.push_str(&format!(
            "mu{n}/alpha{n}*(lambda1^alpha{n} + lambda2^alpha{n} + lambda3^alpha{n} - 3 - alpha{n}*ln(J)) + "
        ));
    }
    energy.push_str("cp/2*(J - 1)^2");
    constants.push(("cp".to_owned(), law.or_zero("cp")?));
    let mut own =
        ForeignLaw::of_constants(law.line, law.title(), Energy::Formula(energy), constants);
    own.shear = Some(0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>());
    Ok(own)
}

fn arruda_boyce(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let (mu, links) = (law.required("mu")?, law.required("N")?);
    if mu <= 0.0 || links <= 0.0 {
        return Err(Trouble::new(
            law.line,
            format!("mu is {mu} and N is {links}; expected positive numbers"),
            "N is the number of links of a chain",
        ));
    }
    let volume = law.volume()?;
    let energy = format!(
        "let b = 1/links; mu*((I1bar - 3)/2 + b*(I1bar^2 - 9)/10 + 11*b^2*(I1bar^3 - 27)/350 + 19*b^3*(I1bar^4 - 81)/1750 \
         + 519*b^4*(I1bar^5 - 243)/134750) + {}",
        volume.energy()
    );
    let constants = named(&[("mu", mu), ("links", links)]);
    let energy = Energy::Formula(energy);
    let own = ForeignLaw::new(law.line, law.title(), energy, constants, (mu, volume));
    Ok(own.noted(Some(
        "FEBio documents the series of Arruda and Boyce, and evaluates its i-th term i times; onset reads the law that FEBio evaluates".to_owned(),
    )))
}

fn gent(law: &Law<'_, '_>) -> Result<ForeignLaw, Trouble> {
    let constants = (law.required("G")?, law.required("Jm")?);
    let volume = law.volume()?;
    Ok(ForeignLaw::gent(law.line, law.title(), constants, volume))
}

/// Writes a law as a material.
pub(super) fn write(sheet: &Sheet) -> Result<Block, Refusal> {
    let bulk = || sheet.required_bulk();
    let named = |name: &str, value: f64| (name.to_owned(), value);
    let mut notes = Vec::new();
    let (kind, mut parameters) = match &sheet.form {
        Form::Polynomial(constants) => match order(constants) {
            (1, true) => ("incomp neo-Hookean", vec![named("G", sheet.shear())]),
            (1, false) => {
                let values = ordered(constants, &[(1, 0), (0, 1)])?;
                (
                    "Mooney-Rivlin",
                    vec![named("c1", values[0]), named("c2", values[1])],
                )
            }
            (2..=6, true) => {
                notes.push("FEBio 4 evaluates Yeoh as sum c_i x^i/i with x = I1bar - 3, so c_i is i times the constant of the law".to_owned());
                let own = constants
                    .iter()
                    .map(|((i, _), value)| (format!("c{i}"), *i as f64 * value));
                ("Yeoh", own.collect())
            }
            _ => {
                ordered(constants, &POWERS)?;
                let own = constants
                    .iter()
                    .map(|((i, j), value)| (format!("c{i}{j}"), *value));
                let own = own.chain([named("D1", 0.5 * bulk()?), named("D2", 0.0)]);
                ("polynomial", own.collect())
            }
        },
        Form::Ogden(terms) if terms.len() > 6 => return Err(Refusal::Lacks),
        Form::Ogden(terms) => {
            let own = terms.iter().enumerate().flat_map(|(n, (mu, alpha))| {
                let n = n + 1;
                [(format!("c{n}"), mu * alpha), (format!("m{n}"), *alpha)]
            });
            ("Ogden", own.collect())
        }
        Form::Gent(mu, limit) => ("Gent", vec![named("G", *mu), named("Jm", *limit)]),
        // FEBio's material Arruda-Boyce evaluates another series.
        Form::ArrudaBoyce(..) | Form::Foam(_) => return Err(Refusal::Lacks),
    };
    if kind != "polynomial" {
        let model = if sheet.function == SQUARE { 2.0 } else { 3.0 };
        parameters.extend([named("k", bulk()?), named("pressure_model", model)]);
    }
    let mut lines = vec![
        format!("<material id=\"1\" name=\"law\" type=\"{kind}\">"),
        "  <density>1</density>".to_owned(),
    ];
    lines.extend(
        parameters
            .iter()
            .map(|(name, value)| format!("  <{name}>{value}</{name}>")),
    );
    lines.push("</material>".to_owned());
    Ok(Block {
        lines,
        function: Some(sheet.function),
        notes,
    })
}
