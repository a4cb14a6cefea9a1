//! Assignment of columns to quantities, by names given by the user or by the usual names of codes.

use crate::error::{FrameError, Place};
use crate::frame::{Cells, Frame};
use crate::reading::{Quantity, Reading};

/// Column of a file and its use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnUse {
    /// Name in the file.
    pub name: String,
    /// Quantity, or `None` if the column is not used.
    pub quantity: Option<Quantity>,
    /// Whether the user named the column; otherwise it was guessed.
    pub is_given: bool,
    /// Number of components in the file.
    pub components: usize,
    /// Whether the values belong to points or to cells.
    pub support: Support,
    /// Whether the order of tensor components was assumed (matrices row by row), because the names of the columns do not determine it.
    pub order_is_assumed: bool,
}

/// Support of the values of a column: points or cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// One value for each particle or node.
    Points,
    /// One value for each cell or element.
    Cells,
}

/// Family of formats, which determines names and the order of components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// The names of computes, fixes and variables have a prefix.
    Lammps,
    /// Symmetric tensors are ordered xx, yy, zz, xy, yz, xz.
    Vtk,
    /// Plain tables and arrays, without rules of a program.
    Plain,
}

/// Column that a file contains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Available {
    pub name: String,
    pub components: usize,
    /// Whether the components are a square matrix, by the shape of the array.
    pub is_matrix: bool,
    pub support: Support,
}

impl Available {
    pub(crate) fn scalar(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            components: 1,
            is_matrix: false,
            support: Support::Points,
        }
    }
}

/// Component of a column that becomes a component of a quantity.
#[derive(Clone, Copy, Debug)]
struct Part {
    column: usize,
    component: usize,
    target: usize,
}

#[derive(Clone, Debug)]
struct Use {
    quantity: Quantity,
    support: Support,
    is_given: bool,
    order_is_assumed: bool,
    parts: Vec<Part>,
    /// Column of a pressure that is subtracted from the normal components of a deviatoric stress.
    pressure: Option<usize>,
}

/// Assignment of the columns of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    available: Vec<Available>,
    uses: Vec<Use>,
}

/// Rule for recognizing a quantity by the usual names of its columns.
#[derive(Clone, Copy)]
enum Rule {
    /// Name of a vector or tensor, or the common part of the names of its components.
    Base(&'static str),
    /// Names of the components of a vector.
    Names([&'static str; 3]),
}

use Rule::{Base, Names};

/// Usual names, the preferred ones first.
fn rules(quantity: Quantity) -> &'static [Rule] {
    match quantity {
        Quantity::Position => &[
            Names(["xu", "yu", "zu"]),
            Names(["x", "y", "z"]),
            Names(["xsu", "ysu", "zsu"]),
            Names(["xs", "ys", "zs"]),
            Base("position"),
            Base("positions"),
            Base("pos"),
            Base("coordinates"),
            Base("coords"),
            Base("points"),
            Base("x"),
            Names(["X", "Y", "Z"]),
        ],
        Quantity::Reference => &[
            Base("reference"),
            Base("reference_position"),
            Base("reference_positions"),
            Base("ref"),
            Base("initial_position"),
            Base("initial_positions"),
            Base("initial_coordinates"),
            Base("InitialPosition"),
            Names(["x0", "y0", "z0"]),
            Names(["X", "Y", "Z"]),
            Base("X0"),
            Base("x0"),
            Base("X"),
        ],
        Quantity::Displacement => &[
            Base("displacement"),
            Base("displacements"),
            Base("disp"),
            Names(["ux", "uy", "uz"]),
            Names(["u_x", "u_y", "u_z"]),
            Base("u"),
            Base("U"),
        ],
        Quantity::Velocity => &[
            Base("velocity"),
            Base("velocities"),
            Base("vel"),
            Base("velo"),
            Names(["vx", "vy", "vz"]),
            Base("v"),
            Base("V"),
            Names(["u", "v", "w"]),
        ],
        Quantity::Gradient => &[
            Base("F"),
            Base("deformation_gradient"),
            Base("DeformationGradient"),
            Base("defgrad"),
            Base("def_grad"),
        ],
        Quantity::Stress => &[
            Base("stress"),
            Base("stresses"),
            Base("cauchy"),
            Base("cauchy_stress"),
            Base("CauchyStress"),
            Base("sigma"),
            Base("sig"),
            Base("s"),
            Base("S"),
        ],
        Quantity::Density => &[Base("density"), Base("rho"), Base("mass_density")],
        Quantity::Identity => &[
            Base("id"),
            Base("ids"),
            Base("identity"),
            Base("particle_id"),
            Base("ParticleID"),
            Base("OriginalParticleID"),
            Base("original_id"),
            Base("Idp"),
            Base("global_id"),
            Base("GlobalNodeId"),
            Base("vtkOriginalPointIds"),
            Base("index"),
        ],
        Quantity::Kind => &[
            Base("type"),
            Base("kind"),
            Base("material"),
            Base("material_id"),
            Base("MaterialID"),
            Base("species"),
        ],
        Quantity::Held => &[
            Base("held"),
            Base("fixed"),
            Base("is_fixed"),
            Base("clamped"),
        ],
        Quantity::Time => &[Base("time"), Base("t"), Base("TimeValue")],
        Quantity::Volume => &[Base("volume"), Base("vol")],
        Quantity::Mass => &[Base("mass"), Base("m")],
    }
}

const VECTOR_ENDINGS: [[&str; 3]; 3] = [["x", "y", "z"], ["0", "1", "2"], ["1", "2", "3"]];
const MATRIX_ENDINGS: [[&str; 9]; 3] = [
    ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
    ["11", "12", "13", "21", "22", "23", "31", "32", "33"],
    ["00", "01", "02", "10", "11", "12", "20", "21", "22"],
];
const SYMMETRIC_ENDINGS: [[&str; 6]; 3] = [
    ["xx", "yy", "zz", "xy", "xz", "yz"],
    ["11", "22", "33", "12", "13", "23"],
    ["00", "11", "22", "01", "02", "12"],
];
const NUMBERS: [&str; 10] = ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9"];

impl Quantity {
    /// Components of the quantity for a column with the given number of components: (component of the column, component of the quantity).
    fn targets(
        self,
        components: usize,
        is_matrix: bool,
        dialect: Dialect,
    ) -> Option<Vec<(usize, usize)>> {
        let list = |targets: &[usize]| Some(targets.iter().copied().enumerate().collect());
        match self {
            Self::Position | Self::Reference | Self::Displacement | Self::Velocity => {
                match components {
                    1..=3 => Some((0..components).map(|axis| (axis, axis)).collect()),
                    _ => None,
                }
            }
            Self::Gradient => match components {
                4 => list(&[0, 1, 3, 4]),
                5 => list(&[0, 1, 3, 4, 8]),
                9 => list(&[0, 1, 2, 3, 4, 5, 6, 7, 8]),
                _ => None,
            },
            Self::Stress => match (components, is_matrix) {
                (3, _) => list(&[0, 1, 3]),
                (4, true) => Some(vec![(0, 0), (3, 1), (1, 3)]),
                (4, false) => list(&[0, 1, 2, 3]),
                (6, _) if dialect == Dialect::Vtk => list(&[0, 1, 2, 3, 5, 4]),
                (6, _) => list(&[0, 1, 2, 3, 4, 5]),
                (9, _) => Some(vec![(0, 0), (4, 1), (8, 2), (1, 3), (2, 4), (5, 5)]),
                _ => None,
            },
            _ => match components {
                1 => list(&[0]),
                _ => None,
            },
        }
    }

    /// Description of the numbers of components that a column may have.
    const fn sizes(self) -> &'static str {
        match self {
            Self::Position | Self::Reference | Self::Displacement | Self::Velocity => "1 to 3",
            Self::Gradient => "4 (xx, xy, yx, yy) or 9",
            Self::Stress => "3 (xx, yy, xy), 4 (xx, yy, zz, xy), 6 or 9",
            _ => "1",
        }
    }

    const fn is_vector(self) -> bool {
        matches!(
            self,
            Self::Position | Self::Reference | Self::Displacement | Self::Velocity
        )
    }
}

/// Columns by their plain names, some of them already assigned.
struct Columns<'a> {
    available: &'a [Available],
    plain: Vec<&'a str>,
    is_used: Vec<bool>,
    support: Support,
    dialect: Dialect,
}

/// Name without a unit in brackets, and without the prefixes of LAMMPS.
fn plain(name: &str, dialect: Dialect) -> &str {
    let name = name.trim();
    let name = match name.split_once([' ', '[', '(']) {
        // An index is a part of the name.
        Some((before, rest))
            if !before.is_empty() && !rest.starts_with(|c: char| c.is_ascii_digit()) =>
        {
            before
        }
        _ => name,
    };
    if dialect != Dialect::Lammps {
        return name;
    }
    let prefixes = ["c_", "f_", "v_", "d_", "i_", "d2_", "i2_"];
    let stripped = prefixes.iter().find_map(|prefix| name.strip_prefix(prefix));
    stripped.filter(|rest| !rest.is_empty()).unwrap_or(name)
}

/// Compares names; case is significant in short names, where it distinguishes quantities (x, X).
fn is_same(name: &str, pattern: &str) -> bool {
    match pattern.len() {
        0..=2 => name == pattern,
        _ => name.eq_ignore_ascii_case(pattern),
    }
}

impl<'a> Columns<'a> {
    fn free(&self) -> impl Iterator<Item = usize> {
        (0..self.available.len())
            .filter(|n| !self.is_used[*n] && self.available[*n].support == self.support)
    }

    /// Column with this name.
    fn named(&self, name: &str) -> Option<usize> {
        self.free().find(|n| is_same(self.plain[*n], name))
    }

    fn scalar(&self, name: &str) -> Option<usize> {
        self.named(name)
            .filter(|n| self.available[*n].components == 1)
    }

    /// Scalar column whose name is `base` with an ending.
    fn component(&self, base: &str, ending: &str) -> Option<usize> {
        let is_match = |name: &str| {
            let Some((start, rest)) = name.split_at_checked(base.len()) else {
                return false;
            };
            let rest = rest.strip_prefix(['_', ':', '.', '-', '[']).unwrap_or(rest);
            let rest = rest.strip_suffix(']').unwrap_or(rest);
            let is_base = match base.len() {
                0..=2 => start == base,
                _ => start.eq_ignore_ascii_case(base),
            };
            is_base && !base.is_empty() && rest.eq_ignore_ascii_case(ending)
        };
        self.free()
            .find(|n| self.available[*n].components == 1 && is_match(self.plain[*n]))
    }

    /// Parts of a quantity whose components are separate columns, and whether their order was assumed.
    fn components(&self, quantity: Quantity, base: &str) -> Option<(Vec<Part>, bool)> {
        let find = |endings: &[&str], needed: &[usize]| {
            let found: Vec<Option<usize>> = endings
                .iter()
                .map(|ending| self.component(base, ending))
                .collect();
            let parts = found.iter().enumerate().filter_map(|(target, column)| {
                Some(Part {
                    column: (*column)?,
                    component: 0,
                    target,
                })
            });
            let parts: Vec<Part> = parts.collect();
            needed
                .iter()
                .all(|target| found[*target].is_some())
                .then_some(parts)
        };
        if quantity.is_vector() {
            let parts = VECTOR_ENDINGS.iter().find_map(|endings| {
                let parts = find(endings, &[0])?;
                // Numbered columns need a second component: `x0` alone is another quantity.
                (endings[0] == "x" || parts.len() > 1).then_some(parts)
            })?;
            return Some((parts, false));
        }
        let named = match quantity {
            Quantity::Gradient => MATRIX_ENDINGS
                .iter()
                .find_map(|endings| find(endings, &[0, 1, 3, 4])),
            Quantity::Stress => SYMMETRIC_ENDINGS
                .iter()
                .find_map(|endings| find(endings, &[0, 1, 3])),
            _ => return None,
        };
        if let Some(parts) = named {
            return Some((parts, false));
        }
        // Components with numbers from 0 or 1.
        [&NUMBERS[..9], &NUMBERS[1..]].iter().find_map(|numbers| {
            let found = numbers.iter().map_while(|n| self.component(base, n));
            let found: Vec<usize> = found.collect();
            let targets = quantity.targets(found.len(), false, self.dialect)?;
            let parts = targets.into_iter().map(|(n, target)| Part {
                column: found[n],
                component: 0,
                target,
            });
            Some((parts.collect(), true))
        })
    }

    /// Parts of a quantity that is one column.
    fn whole(&self, quantity: Quantity, column: usize) -> Option<(Vec<Part>, bool)> {
        let own = &self.available[column];
        let targets = quantity.targets(own.components, own.is_matrix, self.dialect)?;
        let parts = targets.into_iter().map(|(component, target)| Part {
            column,
            component,
            target,
        });
        let is_tensor = matches!(quantity, Quantity::Gradient | Quantity::Stress);
        Some((parts.collect(), is_tensor))
    }

    fn guessed(&self, quantity: Quantity) -> Option<Use> {
        let with = |(parts, order_is_assumed): (Vec<Part>, bool)| Use {
            quantity,
            support: self.support,
            is_given: false,
            order_is_assumed,
            parts,
            pressure: None,
        };
        if quantity == Quantity::Stress {
            // Deviator and pressure, as in PySPH.
            if let (Some(pressure), Some(_)) = (self.scalar("p"), self.scalar("s00")) {
                let parts = self.components(quantity, "s")?;
                return Some(Use {
                    pressure: Some(pressure),
                    ..with(parts)
                });
            }
        }
        rules(quantity).iter().find_map(|rule| match rule {
            Base(base) => {
                let whole = self.named(base).and_then(|n| {
                    // A scalar `x` is a component, and not the vector.
                    let is_vector = !quantity.is_vector() || self.available[n].components > 1;
                    is_vector.then(|| self.whole(quantity, n)).flatten()
                });
                whole.or_else(|| self.components(quantity, base)).map(with)
            }
            Names(names) => {
                let parts: Vec<Part> = names
                    .iter()
                    .enumerate()
                    .map_while(|(target, name)| {
                        self.scalar(name).map(|column| Part {
                            column,
                            component: 0,
                            target,
                        })
                    })
                    .collect();
                // One name of three is ambiguous, except for a bar along x.
                (parts.len() > 1 || parts.len() == 1 && names[0] == "x")
                    .then(|| with((parts, false)))
            }
        })
    }

    /// Parts of a quantity whose columns are named by the user.
    fn given(
        &self,
        quantity: Quantity,
        names: &[String],
        place: &Place,
    ) -> Result<Use, FrameError> {
        let exact = |name: &str| {
            let raw = self.free().find(|n| self.available[*n].name == name);
            raw.or_else(|| self.free().find(|n| self.plain[*n] == name))
        };
        let missing = |name: &str| FrameError::NoColumn {
            place: Box::new(place.clone()),
            quantity,
            name: crate::error::cut(name),
            available: names_of(self.available),
        };
        let wrong = |count: usize| {
            FrameError::refused(
                place.clone(),
                format!("{count} components for {quantity}"),
                &format!("{quantity} has {} components", quantity.sizes()),
            )
        };
        let (parts, order_is_assumed) = match names {
            [] => return Err(wrong(0)),
            [name] => match exact(name) {
                Some(column) => self
                    .whole(quantity, column)
                    .ok_or_else(|| wrong(self.available[column].components))?,
                None => self
                    .components(quantity, plain(name, self.dialect))
                    .ok_or_else(|| missing(name))?,
            },
            names => {
                let targets = quantity
                    .targets(names.len(), false, Dialect::Plain)
                    .ok_or_else(|| wrong(names.len()))?;
                let part = |(name, target): (&String, usize)| match exact(name) {
                    Some(column) if self.available[column].components == 1 => Ok(Part {
                        column,
                        component: 0,
                        target,
                    }),
                    Some(column) => Err(wrong(self.available[column].components)),
                    None => Err(missing(name)),
                };
                let targets = targets.into_iter().map(|(n, target)| (&names[n], target));
                (targets.map(part).collect::<Result<_, _>>()?, false)
            }
        };
        Ok(Use {
            quantity,
            support: self.support,
            is_given: true,
            order_is_assumed,
            parts,
            pressure: None,
        })
    }
}

fn names_of(available: &[Available]) -> Vec<String> {
    available.iter().map(|own| own.name.clone()).collect()
}

impl Plan {
    /// Assigns columns named by the user, then guesses the remaining ones.
    pub(crate) fn of(
        available: Vec<Available>,
        reading: &Reading,
        dialect: Dialect,
        place: &Place,
    ) -> Result<Self, FrameError> {
        let mut names = Columns {
            available: &available,
            plain: available
                .iter()
                .map(|own| plain(&own.name, dialect))
                .collect(),
            is_used: vec![false; available.len()],
            support: Support::Points,
            dialect,
        };
        let mut uses: Vec<Use> = Vec::new();
        let mut take = |names: &mut Columns<'_>, found: Use| {
            for part in &found.parts {
                names.is_used[part.column] = true;
            }
            if let Some(pressure) = found.pressure {
                names.is_used[pressure] = true;
            }
            uses.push(found);
        };
        for (quantity, list) in &reading.columns {
            let on_points = names.given(*quantity, list, place);
            let found = on_points.or_else(|error| {
                names.support = Support::Cells;
                let on_cells = names.given(*quantity, list, place);
                names.support = Support::Points;
                on_cells.map_err(|_| error)
            })?;
            take(&mut names, found);
        }
        let is_given = |quantity| reading.columns.iter().any(|(own, _)| *own == quantity);
        for support in [Support::Points, Support::Cells] {
            names.support = support;
            for quantity in Quantity::ALL.into_iter().filter(|own| !is_given(*own)) {
                let is_possible = support == Support::Points
                    || matches!(
                        quantity,
                        Quantity::Gradient
                            | Quantity::Stress
                            | Quantity::Density
                            | Quantity::Volume
                            | Quantity::Kind
                    );
                if let Some(found) = names.guessed(quantity).filter(|_| is_possible) {
                    take(&mut names, found);
                }
            }
        }
        let plan = Self { available, uses };
        let has = |quantity| plan.find(quantity, Support::Points).is_some();
        let is_displaced = has(Quantity::Reference) && has(Quantity::Displacement);
        if !has(Quantity::Position) && !is_displaced {
            return Err(FrameError::NoPositions {
                place: Box::new(place.clone()),
                available: names_of(&plan.available),
            });
        }
        Ok(plan)
    }

    fn find(&self, quantity: Quantity, support: Support) -> Option<&Use> {
        self.uses
            .iter()
            .find(|own| own.quantity == quantity && own.support == support)
    }

    /// Lists the columns with their use, for display.
    pub(crate) fn listed(&self) -> Vec<ColumnUse> {
        let list = self.available.iter().enumerate();
        list.map(|(n, own)| {
            let used = self.uses.iter().find(|used| {
                used.pressure == Some(n) || used.parts.iter().any(|part| part.column == n)
            });
            ColumnUse {
                name: own.name.clone(),
                quantity: used.map(|used| used.quantity),
                is_given: used.is_some_and(|used| used.is_given),
                components: own.components,
                support: own.support,
                order_is_assumed: used.is_some_and(|used| used.order_is_assumed),
            }
        })
        .collect()
    }

    /// Returns true if the plan also applies to a frame with these columns.
    pub(crate) fn is_for(&self, available: &[Available]) -> bool {
        self.available == available
    }

    /// Like [`Plan::is_for`], for scalar columns.
    pub(crate) fn is_for_names(&self, names: &[String]) -> bool {
        self.available.iter().map(|own| &own.name).eq(names)
    }

    /// Columns of the file.
    pub(crate) fn available(&self) -> &[Available] {
        &self.available
    }

    /// Returns for each column whether it is used.
    pub(crate) fn wanted(&self) -> Vec<bool> {
        let mut wanted = vec![false; self.available.len()];
        for used in &self.uses {
            for part in &used.parts {
                wanted[part.column] = true;
            }
            if let Some(pressure) = used.pressure {
                wanted[pressure] = true;
            }
        }
        wanted
    }

    /// Returns true if data of cells are used.
    pub(crate) fn has_cells(&self) -> bool {
        self.uses.iter().any(|own| own.support == Support::Cells)
    }

    /// Number of components of the positions.
    pub(crate) fn dimensions(&self) -> usize {
        [Quantity::Position, Quantity::Reference]
            .into_iter()
            .find_map(|quantity| self.find(quantity, Support::Points))
            .map_or(0, |used| used.parts.len())
    }

    /// Columns of a quantity of the points.
    pub(crate) fn columns_of(&self, quantity: Quantity) -> Vec<usize> {
        let found = self.find(quantity, Support::Points);
        found.map_or_else(Vec::new, |used| {
            used.parts.iter().map(|part| part.column).collect()
        })
    }

    /// Returns a frame with the values of the used columns, without time, step and source.
    ///
    /// # Errors
    /// Description of a column whose length does not match.
    pub(crate) fn frame(
        &self,
        columns: &[Vec<f64>],
        points: usize,
        cells: Option<Cells>,
    ) -> Result<Frame, String> {
        let count_of = |support: Support| match support {
            Support::Points => points,
            Support::Cells => cells.as_ref().map_or(0, Cells::len),
        };
        for (n, is_wanted) in self.wanted().into_iter().enumerate() {
            let own = &self.available[n];
            let count = count_of(own.support);
            if is_wanted && count.checked_mul(own.components) != Some(columns[n].len()) {
                return Err(format!(
                    "{count} values with {} components in `{}`",
                    own.components,
                    crate::error::cut(&own.name)
                ));
            }
        }
        let build = Build {
            plan: self,
            columns,
            support: Support::Points,
            count: points,
        };
        let mut frame = Frame {
            dimensions: self.dimensions(),
            velocity: build.vector(Quantity::Velocity),
            reference: build.vector(Quantity::Reference),
            displacement: build.vector(Quantity::Displacement),
            density: build.scalar(Quantity::Density),
            volume: build.scalar(Quantity::Volume),
            mass: build.scalar(Quantity::Mass),
            kind: build.whole(Quantity::Kind)?,
            held: build
                .scalar(Quantity::Held)
                .map(|values| values.into_iter().map(|value| value != 0.0).collect()),
            time: build
                .scalar(Quantity::Time)
                .and_then(|values| values.first().copied()),
            ..Frame::default()
        };
        (frame.gradient, frame.gradient_given) = build.gradient();
        (frame.stress, frame.stress_given) = build.stress();
        if let Some(ids) = build.whole(Quantity::Identity)? {
            let ids: Result<Vec<u64>, _> = ids.into_iter().map(u64::try_from).collect();
            frame.identity = Some(ids.map_err(|_| "numbers of particles from 0".to_owned())?);
        }
        let sum = |a: &[[f64; 3]], b: &[[f64; 3]], sign: f64| {
            let pairs = a.iter().zip(b);
            pairs
                .map(|(a, b)| std::array::from_fn(|axis| a[axis] + sign * b[axis]))
                .collect::<Vec<[f64; 3]>>()
        };
        let position = build.vector(Quantity::Position);
        frame.position = match (position, &frame.reference, &frame.displacement) {
            (Some(position), _, _) => position,
            (None, Some(reference), Some(displacement)) => sum(reference, displacement, 1.0),
            _ => return Err("positions".to_owned()),
        };
        if frame.reference.is_none() {
            frame.reference = frame
                .displacement
                .as_ref()
                .map(|displacement| sum(&frame.position, displacement, -1.0));
        }
        if let Some(mut cells) = cells {
            let build = Build {
                support: Support::Cells,
                count: cells.len(),
                ..build
            };
            (cells.gradient, cells.gradient_given) = build.gradient();
            (cells.stress, cells.stress_given) = build.stress();
            cells.density = build.scalar(Quantity::Density);
            cells.volume = build.scalar(Quantity::Volume);
            cells.kind = build.whole(Quantity::Kind)?;
            frame.cells = Some(cells);
        }
        Ok(frame)
    }
}

/// Values of a frame, by columns.
struct Build<'a> {
    plan: &'a Plan,
    columns: &'a [Vec<f64>],
    support: Support,
    count: usize,
}

impl Build<'_> {
    fn value(&self, part: &Part, item: usize) -> f64 {
        let components = self.plan.available[part.column].components;
        self.columns[part.column][item * components + part.component]
    }

    fn tensor<const N: usize>(
        &self,
        quantity: Quantity,
        start: [f64; N],
    ) -> (Option<Vec<[f64; N]>>, [bool; N]) {
        let mut given = [false; N];
        let Some(used) = self.plan.find(quantity, self.support) else {
            return (None, given);
        };
        let mut values = vec![start; self.count];
        for part in &used.parts {
            given[part.target] = true;
            for (item, value) in values.iter_mut().enumerate() {
                value[part.target] = self.value(part, item);
            }
        }
        (Some(values), given)
    }

    fn vector(&self, quantity: Quantity) -> Option<Vec<[f64; 3]>> {
        self.tensor(quantity, [0.0; 3]).0
    }

    fn gradient(&self) -> (Option<Vec<[f64; 9]>>, [bool; 9]) {
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        self.tensor(Quantity::Gradient, identity)
    }

    fn stress(&self) -> (Option<Vec<[f64; 6]>>, [bool; 6]) {
        let (mut stress, given) = self.tensor(Quantity::Stress, [0.0; 6]);
        let used = self.plan.find(Quantity::Stress, self.support);
        if let (Some(stress), Some(pressure)) = (&mut stress, used.and_then(|used| used.pressure)) {
            for (stress, pressure) in stress.iter_mut().zip(&self.columns[pressure]) {
                for axis in (0..3).filter(|axis| given[*axis]) {
                    stress[axis] -= pressure;
                }
            }
        }
        (stress, given)
    }

    fn scalar(&self, quantity: Quantity) -> Option<Vec<f64>> {
        let used = self.plan.find(quantity, self.support)?;
        let part = used.parts.first()?;
        Some((0..self.count).map(|item| self.value(part, item)).collect())
    }

    /// Integers, which may be written as floating-point numbers.
    fn whole(&self, quantity: Quantity) -> Result<Option<Vec<i64>>, String> {
        /// Integers up to 2^53 are exact.
        const LARGEST_INTEGER: f64 = 9_007_199_254_740_992.0;
        let Some(values) = self.scalar(quantity) else {
            return Ok(None);
        };
        let whole = values.into_iter().map(|value| {
            let is_whole = value.abs() <= LARGEST_INTEGER && value.fract() == 0.0;
            is_whole.then_some(value as i64)
        });
        let whole: Option<Vec<i64>> = whole.collect();
        whole
            .map(Some)
            .ok_or_else(|| format!("integers of at most 16 digits for {quantity}"))
    }
}
