//! Viscoelasticity of the material: the Prony series that belongs to a hyperelastic law or to a law in rate form without yield.

use super::error::{Origin, SettingError};
use super::key::key;
use super::material::PLANE;
use super::{Key, Kind, MaterialSettings, Plane, Settings, Value, units};
use onset::material::{Hyperelastic, MaterialError, Moduli, PronyTerm, Viscoelastic};
use std::sync::Arc;

/// Key, without its section, for the Prony series.
const PRONY: &str = "prony";
/// Key, without its section, for the moduli that the constants of the law are.
const MODULI: &str = "moduli";
/// Key, without its section, for the speed at which states are reached.
const LOADING: &str = "loading";

/// Words of the keys; the first is the default.
const OF_MODULI: &[&str] = &["long-term", "instantaneous"];
const OF_LOADING: &[&str] = &["slow", "fast"];

/// The keys, in the order of the documentation.
pub(super) const RELAXATION_KEYS: [Key; 3] = [
    key(
        "material.prony",
        Kind::Text,
        "Prony series of a viscoelastic law, `g, k, tau` for each term with `;` between terms: fractions of the instantaneous deviatoric and mean stress that relax, and the relaxation time",
    ),
    key(
        "material.moduli",
        Kind::Words(OF_MODULI),
        "moduli that the constants of a law with a Prony series describe",
    ),
    key(
        "material.loading",
        Kind::Words(OF_LOADING),
        "speed at which states of a law with a Prony series are reached: slow, so that the stress has relaxed, or fast, so that it has not",
    ),
];

/// Returns true if a key, without its section, belongs to the relaxation of a law.
pub(super) fn is_of_relaxation(name: &str) -> bool {
    [PRONY, MODULI, LOADING].contains(&name)
}

/// Default of a key, without its section.
pub(super) fn default_of(name: &str) -> Option<&'static str> {
    match name {
        MODULI => Some(OF_MODULI[0]),
        LOADING => Some(OF_LOADING[0]),
        _ => None,
    }
}

/// Text of a Prony series as the key takes it.
pub(super) fn text_of(terms: &[PronyTerm]) -> String {
    let term = |term: &PronyTerm| format!("{}, {}, {}", term.shear, term.bulk, term.time);
    terms.iter().map(term).collect::<Vec<_>>().join("; ")
}

/// Term, and whether its time has a unit.
type Typed = (PronyTerm, bool);

/// Reads a term as typed.
fn term(text: &str) -> Result<Typed, String> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    let [shear, bulk, time] = fields[..] else {
        return Err(format!(
            "`{}` has {} numbers; expected g, k, tau",
            onset_frames::brief(text),
            fields.len()
        ));
    };
    let number = |text: &str| {
        text.parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
            .ok_or_else(|| format!("`{}` is not a number", onset_frames::brief(text)))
    };
    let measured = units::time(time)?;
    Ok((
        PronyTerm {
            shear: number(shear)?,
            bulk: number(bulk)?,
            time: match measured {
                Some(time) => time,
                None => number(time)?,
            },
        },
        measured.is_some(),
    ))
}

impl MaterialSettings {
    /// Terms of the Prony series with whether each time has a unit, and the place of the series; `None` for a law without relaxation.
    fn prony(&self) -> Option<(Result<Vec<Typed>, String>, &Origin)> {
        let Some(Value::Word(text)) = self.given(PRONY) else {
            return None;
        };
        Some((text.split(';').map(term).collect(), self.origin(PRONY)?))
    }

    /// Returns true if the law has a Prony series.
    pub fn relaxes(&self) -> bool {
        self.given(PRONY).is_some()
    }

    /// Returns true for a viscoelastic law whose states have relaxed, so that fast increments are stiffer.
    pub fn is_relaxed(&self) -> bool {
        self.relaxes() && self.is_slow()
    }

    /// Returns true if states are reached so slowly that they have relaxed.
    fn is_slow(&self) -> bool {
        self.given(LOADING) != Some(&Value::Word(OF_LOADING[1].to_owned()))
    }

    /// Relaxation times: key, value, whether it has a unit, and place.
    pub(super) fn relaxation_times(&self) -> Vec<(Key, Option<f64>, bool, Option<&Origin>)> {
        let Some((Ok(terms), origin)) = self.prony() else {
            return Vec::new();
        };
        let told =
            |(term, has_unit): Typed| (RELAXATION_KEYS[0], Some(term.time), has_unit, Some(origin));
        terms.into_iter().map(told).collect()
    }

    /// Viscoelastic law in three dimensions; `None` without a Prony series.
    fn viscoelastic(&self) -> Result<Option<Viscoelastic>, MaterialError> {
        let Some((terms, _)) = self.prony() else {
            return Ok(None);
        };
        let terms = terms.map_err(|message| MaterialError::Prony { message })?;
        let constants = match self.given(MODULI) == Some(&Value::Word(OF_MODULI[1].to_owned())) {
            true => Moduli::Instantaneous,
            false => Moduli::LongTerm,
        };
        let terms = terms.into_iter().map(|(term, _)| term).collect();
        Viscoelastic::new(Arc::from(self.of_model()?), terms, constants).map(Some)
    }

    /// Law of the states: relaxed, or with instantaneous moduli.
    pub(super) fn as_loaded(&self) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        Ok(match self.viscoelastic()? {
            None => self.softened()?,
            Some(law) if self.is_slow() => law.relaxed(),
            Some(law) => law.instantaneous(),
        })
    }

    /// Viscoelastic law in three dimensions whose states have relaxed; `None` for other laws, and if states are reached fast.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid.
    pub fn relaxed(&self) -> Result<Option<Viscoelastic>, MaterialError> {
        Ok(self.viscoelastic()?.filter(|_| self.is_slow()))
    }

    /// Refuses a law whose stress relaxes, for commands whose particles move with an elastic law.
    ///
    /// # Errors
    /// [`SettingError`] with the alternatives.
    pub(crate) fn check_moves(&self) -> Result<(), SettingError> {
        match self.prony() {
            Some((_, origin)) if self.is_slow() => Err(SettingError::new(
                origin.clone(),
                "the particles of this command move with an elastic law, and `material.prony` makes the stress relax",
            )
            .hint("set material.loading=fast for motion that is faster than relaxation, or omit material.prony")),
            _ => Ok(()),
        }
    }

    /// Refuses relaxation of laws that cannot have it, and keys without effect.
    pub(super) fn check_relaxation(&self) -> Result<(), SettingError> {
        let Some((terms, origin)) = self.prony() else {
            let lone = [MODULI, LOADING]
                .into_iter()
                .find_map(|name| Some((name, self.origin(name)?)));
            return match lone {
                Some((name, origin)) => Err(SettingError::new(
                    origin.clone(),
                    format!("`material.{name}` has no effect without `material.prony`"),
                )
                .hint("set material.prony, or omit the key")),
                None => Ok(()),
            };
        };
        let refused = |message: String, hint: &str| {
            Err(SettingError::new(origin.clone(), message).hint(hint))
        };
        if let Err(message) = terms {
            return refused(
                format!("`material.prony`: {message}"),
                "for example material.prony=\"0.3, 0, 1e-3; 0.2, 0, 0.1\"",
            );
        }
        if self.model.yields() {
            return refused(
                format!(
                    "{} flows, and a law with a Prony series must not",
                    self.model.name()
                ),
                "omit material.prony, or choose a hyperelastic law",
            );
        }
        if self.plane() == Plane::Membrane {
            let origin = self.origin(PLANE).unwrap_or(origin).clone();
            return Err(SettingError::new(
                origin,
                "`material.plane` is membrane, and a two-dimensional law has no deviatoric and mean stress of space for `material.prony`",
            )
            .hint("set material.plane=stress for a sheet of a three-dimensional law"));
        }
        Ok(())
    }
}

impl Settings {
    /// Law of increments of relaxed states that are faster than all relaxation, for the dimension of the discretization; `None` for other laws.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid, or the law has no plane stress.
    pub(crate) fn fast_law(&self) -> Result<Option<Arc<dyn Hyperelastic>>, MaterialError> {
        let Some(law) = self.material.relaxed()? else {
            return Ok(None);
        };
        self.material
            .in_dimension(law.fast(), self.dimension())
            .map(Some)
    }
}
