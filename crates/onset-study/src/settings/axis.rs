//! The axes of a study: which quantity a map varies, over which range, in how many states.

use super::key::ANY_DIMENSION;
use super::{KEYS, Key, Kind, Units, Value, units};

/// Quantity that an axis varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A stretch by its number, 1 to 3: along the axes of the plane, and out of it.
    Stretch(usize),
    /// The amount of shear.
    Shear,
    /// Angle of the lattice relative to the load; radians.
    Rotation,
    /// A key with a numeric value.
    Setting(&'static Key),
}

impl Quantity {
    /// The quantities of the deformation.
    pub const OF_STATE: [Self; 5] = [
        Self::Stretch(1),
        Self::Stretch(2),
        Self::Stretch(3),
        Self::Shear,
        Self::Rotation,
    ];

    /// Every quantity that an axis can vary, in the order of the documentation.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let settings = KEYS.iter().filter(|key| key.is_varied());
        Self::OF_STATE
            .into_iter()
            .chain(settings.map(Self::Setting))
    }

    /// Returns the quantity with this name, or `None`.
    pub fn of_name(name: &str) -> Option<Self> {
        let setting = || Key::named(name).filter(|key| key.is_varied());
        Self::OF_STATE
            .into_iter()
            .find(|quantity| quantity.name() == name)
            .or_else(|| setting().map(Self::Setting))
    }

    /// Name of the quantity in a study.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stretch(1) => "stretch-1",
            Self::Stretch(2) => "stretch-2",
            Self::Stretch(_) => "stretch-3",
            Self::Shear => "shear",
            Self::Rotation => "rotation",
            Self::Setting(key) => key.name,
        }
    }

    /// Key that sets the quantity if no axis varies it.
    pub fn key_name(self) -> String {
        match self {
            Self::Setting(key) => key.name.to_owned(),
            of_state => format!("state.{}", of_state.name()),
        }
    }

    /// Unit or dimension of the quantity; `1` if dimensionless.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Rotation => "rad",
            Self::Setting(key) => key.unit().unwrap_or("1"),
            Self::Stretch(_) | Self::Shear => "1",
        }
    }

    /// Kind of the key that sets the quantity. The law itself restricts its parameters.
    fn kind(self) -> Kind {
        match self {
            Self::Setting(key) if key.is_parameter() => {
                Kind::Number(key.unit().unwrap_or("1"), ANY_DIMENSION)
            }
            Self::Setting(key) => key.kind,
            _ => Key::named(&self.key_name()).map_or(Kind::Text, |key| key.kind),
        }
    }

    /// Description of the admissible values.
    pub fn expects(self) -> String {
        self.kind().expects()
    }

    /// Smallest and largest admissible value; `None` without limits.
    pub fn limits(self) -> Option<[f64; 2]> {
        self.kind().limits()
    }

    /// Returns true if the quantity can have this value.
    pub fn admits(self, value: f64) -> bool {
        self.kind().accepts(&Value::Number(value))
    }
}

/// An axis of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Quantity that the axis varies.
    pub quantity: Quantity,
    /// Ends of the axis; the states lie in the middle of equal cells between them.
    pub range: (f64, f64),
    /// Number of states along the axis.
    pub count: usize,
}

impl Axis {
    /// Name of the quantity in a study, for example `stretch-1` or `discretization.support`.
    pub fn name(&self) -> &'static str {
        self.quantity.name()
    }

    /// Title of the axis in a figure, without the unit.
    pub fn title(&self) -> &'static str {
        match self.quantity {
            Quantity::Stretch(1) => "stretch λ₁",
            Quantity::Stretch(2) => "stretch λ₂",
            Quantity::Stretch(_) => "stretch λ₃",
            Quantity::Shear => "shear γ",
            Quantity::Rotation => "rotation of the lattice θ",
            Quantity::Setting(key) => key.title(),
        }
    }

    /// Label of the axis in a figure, with the unit.
    pub fn label(&self, units: Units) -> String {
        units.label(self.title(), self.unit())
    }

    /// Unit or dimension of the axis; `1` if dimensionless.
    pub fn unit(&self) -> &'static str {
        self.quantity.unit()
    }

    /// SI unit of the axis; `None` if dimensionless.
    pub fn si_unit(&self) -> Option<&'static str> {
        units::si(self.unit())
    }

    /// Value of state `i`: the middle of its cell.
    pub fn coordinate(&self, i: usize) -> f64 {
        let (low, high) = self.range;
        low + (high - low) * (i as f64 + 0.5) / self.count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Quantity, Units};
    use onset::material::library;

    #[test]
    fn states_lie_in_the_middle_of_equal_cells() {
        let axis = Axis {
            quantity: Quantity::Stretch(1),
            range: (1.0, 3.0),
            count: 4,
        };
        let states: Vec<f64> = (0..4).map(|i| axis.coordinate(i)).collect();
        assert_eq!(states, [1.25, 1.75, 2.25, 2.75]);
    }

    #[test]
    fn every_quantity_is_found_by_its_name_and_has_a_label_with_its_unit() {
        let mut names = Vec::new();
        for quantity in Quantity::all() {
            assert_eq!(Quantity::of_name(quantity.name()), Some(quantity));
            let axis = Axis {
                quantity,
                range: (1.0, 2.0),
                count: 2,
            };
            for units in [Units::Own, Units::Si] {
                let unit = units.unit(axis.unit()).replace('1', "−");
                let (label, unit) = (axis.label(units), unit.replace("^3", "³"));
                assert!(label.ends_with(&format!("({unit})")), "{label}");
            }
            names.push(axis.name());
        }
        for parameter in library().iter().flat_map(|law| law.parameters) {
            assert!(names.contains(&format!("material.{}", parameter.name).as_str()));
        }
        names.retain(|name| !name.starts_with("material."));
        let others = "stretch-1 stretch-2 stretch-3 shear rotation discretization.aspect discretization.perturbation \
                      discretization.spacing discretization.density discretization.support \
                      discretization.stress-point-weight discretization.penalty \
                      discretization.shear-coefficient discretization.viscosity \
                      discretization.artificial-stress discretization.artificial-stress-exponent \
                      discretization.velocity-smoothing discretization.hourglass-stiffness \
                      discretization.hourglass-viscosity discretization.modification discretization.horizon \
                      discretization.control-coefficient discretization.offset discretization.flip-share \
                      discretization.time-step";
        assert_eq!(names.join(" "), others);
        assert_eq!(Quantity::of_name("discretization.frame"), None);
    }
}
