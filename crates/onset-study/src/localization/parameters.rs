//! The law and the loading path of `onset localize`. The law has the keys of a material, as for other commands.

use super::LocalizationError;
use crate::settings::{
    Choice, Key, Kind, MaterialSettings, Model, Origin, Plane, SettingError, Trust, Units, Value,
    units, unknown_key,
};
use onset::material::Admitted::{NotNegative, Within};
use onset::material::MaterialError;
use onset::plasticity::{
    Bands, FlowLaw, IncrementalLaw, Load, Loading, LoadingPath, PlasticityError, Strains, flow_law,
    yielding,
};
use onset_umat::Umat;
use serde::de::DeserializeOwned;

/// Definition of a parameter of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Dotted name of the parameter.
    pub name: &'static str,
    /// Kind of value that the parameter accepts.
    pub kind: Kind,
    /// Default value, as the user would type it.
    pub default: &'static str,
    /// Meaning, with formula or options.
    pub meaning: &'static str,
    /// Condition for an effect: another parameter or `material.model`, and its values; `None` without a condition.
    pub only_with: Option<(&'static str, &'static [&'static str])>,
}

const fn parameter(
    name: &'static str,
    kind: Kind,
    default: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        kind,
        default,
        meaning,
        only_with: None,
    }
}

impl Parameter {
    const fn only_with(mut self, name: &'static str, words: &'static [&'static str]) -> Self {
        self.only_with = Some((name, words));
        self
    }

    fn default_value(&self) -> Value {
        Value::typed(self.default, Some(self.kind))
    }

    /// Converts the parameter to a key of settings, so that it accepts units.
    fn key(&self) -> Key {
        Key {
            name: self.name,
            kind: self.kind,
            meaning: self.meaning,
            read_with: &[],
        }
    }

    fn words(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Words(words) => words,
            _ => &[],
        }
    }
}

const MODEL: &str = "material.model";
const CONFINEMENT: &str = "plasticity.confinement";
const INCREMENTS: &str = "increments";
/// Number of increments along the path to the end, unless it is set.
const USUAL_INCREMENTS: usize = 200;
/// Name of the default law of `onset localize`.
const DEFAULT_MODEL: &str = "drucker-prager";
/// Model names of user routines. First yield is determined from their tangent; differences of the stress of a VUMAT do not resolve it.
const ROUTINES: &[&str] = &["umat", "library"];

/// Names of the laws that can be followed.
pub fn models() -> impl Iterator<Item = &'static str> {
    let laws = yielding().iter().map(|law| law.name);
    laws.chain(ROUTINES.iter().copied())
}

/// Parameters of the path, in the order of the documentation.
pub const PARAMETERS: &[Parameter] = &[
    parameter(
        "plasticity.path",
        Kind::Words(&[
            "uniaxial-stress",
            "uniaxial-strain",
            "plane-strain",
            "pure-shear",
            "triaxial-compression",
            "sheet-stretch",
        ]),
        "plane-strain",
        "loading path",
    ),
    parameter(
        "plasticity.strain-ratio",
        Kind::Number("1", Within(-1.0, 1.0)),
        "0",
        "ratio of the strain along axis 2 to the strain along axis 1, above -1 and at most 1",
    )
    .only_with("plasticity.path", &["sheet-stretch"]),
    parameter(
        "plasticity.load",
        Kind::Words(&["tension", "compression"]),
        "compression",
        "sense of the strain along axis 1",
    )
    .only_with(
        "plasticity.path",
        &[
            "uniaxial-stress",
            "uniaxial-strain",
            "plane-strain",
            "pure-shear",
            "sheet-stretch",
        ],
    ),
    parameter(
        "plasticity.strains",
        Kind::Words(&["small", "finite"]),
        "small",
        "small strain, or finite strain with logarithmic stretches",
    ),
    parameter(
        "plasticity.bands",
        Kind::Words(&["bulk", "sheet"]),
        "bulk",
        "bands of any orientation, or necks across a thin sheet normal to axis 3",
    ),
    parameter(
        CONFINEMENT,
        Kind::Number("stress", NotNegative),
        "0",
        "initial pressure, kept by constant lateral stresses; other laws have material.confinement",
    )
    .only_with(MODEL, ROUTINES),
    parameter(
        "plasticity.slip",
        Kind::Number("1", Within(1e-9, 1e3)),
        "0.2",
        "plastic shear strain at the end of the path",
    ),
];

/// Plastic law and loading path as given by the user.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticSettings {
    /// Law that yields, with its constants.
    material: MaterialSettings,
    /// One value for each of [`PARAMETERS`].
    values: Vec<Value>,
    /// Origin of each value that was set; `None` for defaults.
    origins: Vec<Option<Origin>>,
    /// Whether each value was given with a unit; it is then in SI.
    with_units: Vec<bool>,
}

/// Plastic law, by the way in which it is evaluated.
pub enum PlasticLaw {
    /// Law in rate form, with yield surface and flow rule.
    Flow(Box<dyn FlowLaw>),
    /// Law of finite increments, with the number of increments.
    Increments(Box<dyn IncrementalLaw>, usize),
}

impl PlasticSettings {
    /// Applies assignments such as `material.friction=0.7` and `plasticity.path=pure-shear` to the defaults, in order.
    ///
    /// ```
    /// use onset_study::localization::PlasticSettings;
    /// let error = PlasticSettings::from_assignments(&["material.model=j2", "material.friction=0.3"]);
    /// assert!(error.unwrap_err().to_string().contains("j2 has no parameter `friction`"));
    /// ```
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key, a value of the wrong kind, a key that has no effect, or a law that does not flow.
    pub fn from_assignments<S: AsRef<str>>(assignments: &[S]) -> Result<Self, SettingError> {
        Self::of_file("", "", assignments, &Trust::default())
    }

    /// Reads the law of a study, and applies assignments. The study may load the libraries that the user trusts.
    ///
    /// # Errors
    /// [`SettingError`] in the cases of [`MaterialSettings::of_file`] and [`PlasticSettings::from_assignments`].
    pub fn of_file<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
        trust: &Trust,
    ) -> Result<Self, SettingError> {
        let assignments = assignments.iter().map(|own| own.as_ref().trim());
        let (of_path, mut of_law): (Vec<&str>, Vec<&str>) =
            assignments.partition(|own| own.starts_with("plasticity."));
        let usual = format!("{MODEL}={DEFAULT_MODEL}");
        let sets_model = |own: &&str| own.split('=').next().is_some_and(|key| key.trim() == MODEL);
        if text.is_empty() && !of_law.iter().any(sets_model) {
            of_law.insert(0, &usual);
        }
        let mut material = MaterialSettings::of_file(name, text, &of_law)?;
        material.allow(trust);
        let mut settings = Self {
            material,
            values: PARAMETERS.iter().map(Parameter::default_value).collect(),
            origins: vec![None; PARAMETERS.len()],
            with_units: vec![false; PARAMETERS.len()],
        };
        for assignment in of_path {
            let origin = Origin::CommandLine(format!("--set {assignment}"));
            let Some((name, text)) = assignment.split_once('=') else {
                return Err(SettingError::new(
                    origin,
                    format!("`{assignment}` is not an assignment"),
                )
                .hint("write --set key=value, for example --set plasticity.slip=0.1"));
            };
            settings.set(name.trim(), text.trim(), origin)?;
        }
        settings.check_law()?;
        settings.check()?;
        Ok(settings)
    }

    /// Refuses laws that cannot be followed.
    fn check_law(&self) -> Result<(), SettingError> {
        let model = self.material.model.name();
        if !models().any(|known| known == model) {
            let known: Vec<&str> = models().collect();
            let message = format!("the law is {model}, which `onset localize` cannot follow");
            return Err(SettingError::new(Origin::Combination, message)
                .hint(format!("expected a law that flows: {}", known.join(", "))));
        }
        if self.material.plane() != Plane::Strain {
            let message = "`material.plane` has no effect here".to_owned();
            return Err(SettingError::new(Origin::Combination, message)
                .hint("plasticity.path determines which strains and stresses are prescribed"));
        }
        if self.increments() < 2 {
            let message = "`material.increments` is less than 2 along the path".to_owned();
            return Err(
                SettingError::new(Origin::Combination, message).hint(format!(
                    "set a larger material.increments, or omit it ({USUAL_INCREMENTS} increments)"
                )),
            );
        }
        Ok(())
    }

    /// Number of increments of a user material along the path.
    fn increments(&self) -> usize {
        let set = self.material.given(INCREMENTS).and_then(Value::number);
        set.map_or(USUAL_INCREMENTS, |count| count as usize)
    }

    /// Sets one parameter. [`PlasticSettings::check`] checks afterwards whether it has an effect.
    fn set(&mut self, name: &str, text: &str, origin: Origin) -> Result<(), SettingError> {
        let names = PARAMETERS.iter().map(|parameter| parameter.name);
        let Some(place) = names.clone().position(|known| known == name) else {
            let of_law = name.replacen("plasticity", "material", 1);
            let error = unknown_key(name, names, origin);
            let known = Key::named(&of_law).filter(|key| !key.is_free());
            return Err(match known {
                Some(key) => {
                    error.hint(format!("the law has the keys of a material: {}", key.name))
                }
                None => error,
            });
        };
        let parameter = &PARAMETERS[place];
        let typed = Value::typed(text, Some(parameter.kind));
        let measured = units::converted(&parameter.key(), &typed, &origin)?;
        let has_unit = measured.is_some();
        let value = measured.unwrap_or(typed);
        if !parameter.kind.accepts(&value) {
            let (expects, meaning) = (parameter.kind.expects(), parameter.meaning);
            return Err(
                SettingError::new(origin, format!("`{name}` cannot be {value}"))
                    .hint(format!("expected {expects} ({meaning})"))
                    .nearest_word(name, &value, parameter.words()),
            );
        }
        self.values[place] = value;
        self.origins[place] = Some(origin);
        self.with_units[place] = has_unit;
        Ok(())
    }

    /// Refuses parameters that were set and have no effect.
    fn check(&self) -> Result<(), SettingError> {
        for (parameter, origin) in PARAMETERS.iter().zip(&self.origins) {
            let (Some(origin), false) = (origin, self.has_effect(parameter)) else {
                continue;
            };
            let Some((needed, words)) = parameter.only_with else {
                continue;
            };
            return Err(SettingError::new(
                origin.clone(),
                format!("`{}` has no effect here", parameter.name),
            )
            .hint(format!(
                "it is used only with {needed} = {}",
                words.join(" or ")
            )));
        }
        self.check_units()
    }

    /// Checks that either all values with dimensions in effect have units, or none.
    fn check_units(&self) -> Result<(), SettingError> {
        let states = PARAMETERS.iter().zip(&self.values);
        let states = states.zip(self.with_units.iter().zip(&self.origins));
        let of_path = states
            .filter(|((parameter, _), _)| self.has_effect(parameter))
            .filter_map(|((parameter, value), (has_unit, origin))| {
                let key = parameter.key();
                key.unit().and_then(units::si)?;
                Some((key, Some(value.number()?), *has_unit, origin.as_ref()))
            });
        units::check(self.material.measures().chain(of_path)).map(drop)
    }

    /// Returns the units of answers.
    pub fn units(&self) -> Units {
        match self.with_units.contains(&true) {
            true => Units::Si,
            false => self.material.units(),
        }
    }

    fn has_effect(&self, parameter: &Parameter) -> bool {
        parameter.only_with.is_none_or(|(needed, words)| {
            let set = match self.value(needed) {
                _ if needed == MODEL => self.material.model.name(),
                Value::Word(word) => word,
                _ => return false,
            };
            words.contains(&set)
        })
    }

    /// Law and parameters in effect as a text: names with values, and units if there is a dimension.
    pub fn told(&self) -> String {
        let is_si = self.units().are_si();
        let one = |(name, value): (String, Value)| {
            let mut of_path = PARAMETERS.iter().filter(|own| own.name == name);
            let key = Key::named(&name).copied();
            let key = key.or_else(|| of_path.next().map(Parameter::key));
            let unit = key.and_then(|key| key.unit()).and_then(units::si);
            let choice = Choice {
                value,
                default: false,
                unit: unit.filter(|_| is_si),
            };
            choice.told(name.split_once('.').map_or(&*name, |(_, own)| own))
        };
        let all: Vec<String> = self.entries().map(one).collect();
        all.join(", ")
    }

    /// Keys of the law and of the path that are in effect, with their values.
    pub fn entries(&self) -> impl Iterator<Item = (String, Value)> {
        let model = Value::Word(self.material.model.name().to_owned());
        let of_law = self.material.entries().into_iter();
        let of_law = of_law.map(|(name, value)| (format!("material.{name}"), value));
        let of_path = PARAMETERS
            .iter()
            .zip(&self.values)
            .filter(|(parameter, _)| self.has_effect(parameter))
            .map(|(parameter, value)| (parameter.name.to_owned(), value.clone()));
        std::iter::once((MODEL.to_owned(), model))
            .chain(of_law)
            .chain(of_path)
    }

    fn value(&self, name: &str) -> &Value {
        const NONE: &Value = &Value::Switch(false);
        let place = PARAMETERS.iter().position(|known| known.name == name);
        place.map_or(NONE, |place| &self.values[place])
    }

    fn number(&self, name: &str) -> f64 {
        self.value(name).number().unwrap_or(f64::NAN)
    }

    fn word<T: DeserializeOwned + Default>(&self, name: &str) -> T {
        self.value(name).word().unwrap_or_default()
    }

    /// Builds the plastic law.
    ///
    /// # Errors
    /// [`LocalizationError::Plasticity`] when the parameters are invalid.
    pub fn law(&self) -> Result<PlasticLaw, LocalizationError> {
        let flow = match self.material.model {
            Model::Law(law) => flow_law(law, &self.material.values()),
            Model::Own(_) => None,
        };
        match flow {
            Some(law) => Ok(PlasticLaw::Flow(law?)),
            None => self.routine(),
        }
    }

    fn routine(&self) -> Result<PlasticLaw, LocalizationError> {
        let of_law = |error: MaterialError| LocalizationError::from(PlasticityError::from(error));
        let settings = self.material.umat_permitted().map_err(of_law)?;
        let settings = settings.ok_or_else(|| {
            of_law(MaterialError::External {
                message: "material.library is missing".to_owned(),
            })
        })?;
        let umat = Umat::new(settings).map_err(|error| of_law(error.into()))?;
        Ok(PlasticLaw::Increments(Box::new(umat), self.increments()))
    }

    /// Returns the loading path.
    pub fn loading(&self) -> Loading {
        let values = self.material.values();
        let mut own = values.iter().filter(|(name, _)| *name == "confinement");
        let confinement = own.next().map(|(_, value)| *value);
        Loading {
            path: self.word::<LoadingPath>("plasticity.path"),
            load: self.word::<Load>("plasticity.load"),
            strains: self.word::<Strains>("plasticity.strains"),
            bands: self.word::<Bands>("plasticity.bands"),
            confinement: confinement.unwrap_or_else(|| self.number(CONFINEMENT)),
            strain_ratio: self.number("plasticity.strain-ratio"),
            slip: self.number("plasticity.slip"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::word_of;

    fn of(assignments: &[&str]) -> Result<PlasticSettings, SettingError> {
        PlasticSettings::from_assignments(assignments)
    }

    #[test]
    fn every_law_can_be_followed_with_its_default_parameters() {
        for parameter in PARAMETERS {
            assert!(
                parameter.kind.accepts(&parameter.default_value()),
                "{}",
                parameter.name
            );
        }
        for law in yielding() {
            let settings = of(&[&format!("material.model={}", law.name)]).expect("valid");
            assert!(
                matches!(settings.law(), Ok(PlasticLaw::Flow(_))),
                "{}",
                law.name
            );
        }
        assert_eq!(of(&[]).expect("valid").material.model.name(), DEFAULT_MODEL);
    }

    #[test]
    fn every_word_is_the_name_that_serialization_uses() {
        for parameter in PARAMETERS {
            for word in parameter.words() {
                let loading = of(&[&format!("{}={word}", parameter.name)])
                    .expect("valid")
                    .loading();
                let told = match parameter.name {
                    "plasticity.path" => word_of(&loading.path),
                    "plasticity.load" => word_of(&loading.load),
                    "plasticity.strains" => word_of(&loading.strains),
                    "plasticity.bands" => word_of(&loading.bands),
                    other => panic!("{other}"),
                };
                assert_eq!(told, *word);
            }
        }
    }

    #[test]
    fn invalid_settings_are_refused_with_a_hint() {
        let error =
            |assignments: &[&str]| of(assignments).expect_err("a wrong assignment").to_string();
        for (assignment, hint) in [
            ("material.fricton=1", "did you mean `material.friction`?"),
            ("friction=1", "`material.friction`"),
            (
                "plasticity.friction=1",
                "keys of a material: material.friction",
            ),
            ("plasticity.slop=1", "did you mean `plasticity.slip`?"),
            (
                "plasticity.path=planestrain",
                "did you mean `plane-strain`?",
            ),
            ("plasticity.slip", "not an assignment"),
            ("material.model=umat", "material.library"),
            ("material.model=neo-hooke", "a law that flows: j2"),
            ("material.library=a.so", "drucker-prager has no parameter"),
            (
                "plasticity.confinement=3",
                "used only with material.model = umat or library",
            ),
            ("discretization.support=2", "has no effect"),
        ] {
            let told = error(&[assignment]);
            assert!(told.contains(hint), "{assignment}: {told}");
        }
        let routine = ["material.model=umat", "material.library=a.so"];
        for (assignment, fact) in [
            ("material.increments=1", "less than 2"),
            ("material.plane=membrane", "no effect"),
        ] {
            let told = error(&[routine[0], routine[1], assignment]);
            assert!(told.contains(fact), "{assignment}: {told}");
        }
    }

    #[test]
    fn a_law_has_its_pressure_and_a_routine_takes_it_from_the_path() {
        let confinement =
            |assignments: &[&str]| of(assignments).expect("valid").loading().confinement;
        assert_eq!(confinement(&["material.model=cam-clay"]), 50.0);
        assert_eq!(confinement(&["material.confinement=10"]), 10.0);
        assert_eq!(confinement(&["material.model=j2"]), 0.0);
        let routine = [
            "material.model=umat",
            "material.library=a.so",
            "plasticity.confinement=3",
        ];
        assert_eq!(confinement(&routine), 3.0);
    }

    #[test]
    fn either_all_stresses_have_units_or_none() {
        let all = [
            "material.mu=80 GPa",
            "material.kappa=170GPa",
            "material.strength=200MPa",
            "material.hardening-modulus=1 GPa",
            "material.residual=150 MPa",
        ];
        let settings = of(&all).expect("valid");
        assert_eq!(settings.units(), Units::Si);
        let told = settings.told();
        assert!(
            told.starts_with("model drucker-prager, mu 8e10 Pa, kappa"),
            "{told}"
        );
        let some = of(&all[..4]).expect_err("one without a unit").to_string();
        assert!(
            some.contains("material.residual = 10 (the default) has none"),
            "{some}"
        );
        let routine = ["material.model=umat", "material.library=a.so"];
        let settings = of(&[routine[0], routine[1], "plasticity.confinement=1MPa"]).expect("valid");
        assert_eq!(
            (settings.units(), settings.loading().confinement),
            (Units::Si, 1e6)
        );
        assert_eq!(of(&[]).expect("valid").units(), Units::Own);
    }
}
