//! Verdicts on all states of a map with two axes.

use crate::answers::{Problem, ProblemError};
use crate::csv::Table;
use crate::figure::{Color, Regions, palette};
use crate::settings::Study;
use nalgebra::SVector;
use onset::bloch::Stability;
use onset::cancel::Scope;
use onset::verdict::Verdict;
use rayon::prelude::*;

/// Verdict on a state as maps show it, with separate classes for flutter and undefined states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Verdict on the state.
    Verdict(Verdict),
    /// Verdict `numerical` by flutter alone: `Re omega^2` is nowhere negative.
    Flutter,
    /// The method cannot be evaluated, because its support contains too few particles.
    Undefined,
}

impl Class {
    /// All classes, in the order of the legend.
    pub const ALL: [Self; 7] = [
        Self::Verdict(Verdict::Stable),
        Self::Verdict(Verdict::Physical),
        Self::Verdict(Verdict::Numerical),
        Self::Flutter,
        Self::Verdict(Verdict::ZeroEnergy),
        Self::Verdict(Verdict::Suppressed),
        Self::Undefined,
    ];

    /// The entry of the legend.
    pub fn title(self) -> &'static str {
        match self {
            Self::Verdict(verdict) => verdict.title(),
            other => other.name(),
        }
    }

    /// The word used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Verdict(verdict) => verdict.name(),
            Self::Flutter => "numerical (flutter only)",
            Self::Undefined => "undefined",
        }
    }

    /// Color of the class in maps.
    pub fn color(self) -> Color {
        match self {
            Self::Flutter => palette::YELLOW,
            other => palette::verdict(other.name()).unwrap_or(palette::GREY),
        }
    }

    /// Returns true if the discretization is stable.
    pub fn is_stable_for_particles(self) -> bool {
        matches!(
            self,
            Self::Verdict(Verdict::Stable | Verdict::Suppressed | Verdict::ZeroEnergy)
        )
    }
}

type Wave = SVector<f64, 3>;

/// Number of times that the cells of a map are halved for a smooth picture.
const HALVINGS: usize = 3;

/// Map of a study: cell-centered states, with the first stretch varying fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Domain {
    /// Study of the map.
    pub study: Study,
    /// Class of each state.
    pub classes: Vec<Class>,
    /// Wave vector of a growing wave in each state, if one was found. A state that was filled in inherits the wave vector of the coarser state that
    /// contains it.
    witnesses: Vec<Option<Wave>>,
}

impl Domain {
    fn new(study: Study, found: Vec<(Class, Option<Wave>)>) -> Self {
        let (classes, witnesses) = found.into_iter().unzip();
        Self {
            study,
            classes,
            witnesses,
        }
    }

    /// Evaluates a study in parallel.
    ///
    /// # Errors
    /// [`ProblemError`] when the study itself is invalid; states at which the support is too small are [`Class::Undefined`].
    pub fn of(study: &Study) -> Result<Self, ProblemError> {
        let problem = Problem::new(study.settings.clone())?;
        evaluated(study, &problem)
    }

    /// Refines the map eightfold along each axis, for smooth boundaries. States are computed where the neighboring classes differ, and filled in
    /// elsewhere.
    ///
    /// # Errors
    /// Fails like [`Domain::of`].
    pub fn smoothed(&self) -> Result<Self, ProblemError> {
        let problem = Problem::new(self.study.settings.clone())?;
        let mut finer = self.clone();
        for _ in 0..HALVINGS {
            finer = halved(&finer, &problem)?;
        }
        Ok(finer)
    }

    /// Refines the map twofold along each axis; otherwise like [`Domain::smoothed`].
    ///
    /// # Errors
    /// Fails like [`Domain::of`].
    pub fn halved(&self) -> Result<Self, ProblemError> {
        let problem = Problem::new(self.study.settings.clone())?;
        halved(self, &problem)
    }

    /// Returns the map as a layer of a figure.
    pub fn layer(&self) -> Regions {
        let index = |class: &Class| {
            Class::ALL
                .iter()
                .position(|other| other == class)
                .unwrap_or(0) as u8
        };
        let key = Class::ALL.map(|class| (class.title().to_owned(), class.color()));
        let [first, second] = self.study.plane();
        Regions::new(
            first.range,
            second.range,
            (first.count, second.count),
            self.classes.iter().map(index).collect(),
            key.to_vec(),
        )
    }

    /// Returns the fraction of stable states of the discretization among the states that satisfy a condition.
    pub fn stable_fraction(&self, condition: impl Fn([f64; 2], Class) -> bool) -> f64 {
        let (mut all, mut stable) = (0.0, 0.0);
        for (index, class) in self.classes.iter().enumerate() {
            let coordinates = self.study.coordinates(index);
            if condition([coordinates[0], coordinates[1]], *class) {
                all += 1.0;
                stable += f64::from(u8::from(class.is_stable_for_particles()));
            }
        }
        stable / all
    }

    /// Returns the map as CSV.
    pub fn csv(&self) -> String {
        let [first, second] = self.study.plane();
        let column = |name: &str| name.replace(['-', '.'], "_");
        let states: Vec<_> = self
            .classes
            .iter()
            .enumerate()
            .map(|(index, class)| (self.study.coordinates(index), class))
            .collect();
        Table::new(&states, self.study.settings.units())
            .with(column(first.name()), first.unit(), |(place, _)| place[0])
            .with(column(second.name()), second.unit(), |(place, _)| place[1])
            .with("class", "1", |(_, class)| class.name())
            .to_string()
    }
}

/// Evaluates all states in parallel.
fn evaluated(study: &Study, problem: &Problem) -> Result<Domain, ProblemError> {
    let scope = Scope::current();
    let of_state = |index: usize| scope.run(|| class(study, problem, index, None));
    let found: Vec<_> = (0..study.states())
        .into_par_iter()
        .map(of_state)
        .collect::<Result<_, ProblemError>>()?;
    Ok(Domain::new(study.clone(), found))
}

/// Refines the map twofold along each axis.
fn halved(map: &Domain, problem: &Problem) -> Result<Domain, ProblemError> {
    let [first, second] = map.study.plane();
    let (columns, rows) = (first.count, second.count);
    let mut study = map.study.clone();
    study.axes[0].count *= 2;
    study.axes[1].count *= 2;
    let scope = Scope::current();
    let of_state = |index: usize| {
        let (column, row) = (index % (2 * columns), index / (2 * columns));
        let whole = row / 2 * columns + column / 2;
        // The coarser states around the finer state, including the state whose cell contains it.
        let around = |at: usize, count: usize| {
            let (half, side) = (at / 2, at % 2);
            let next = if side == 0 {
                half.saturating_sub(1)
            } else {
                (half + 1).min(count - 1)
            };
            [half, next]
        };
        let neighbors = || {
            around(row, rows)
                .into_iter()
                .flat_map(|j| around(column, columns).map(|i| j * columns + i))
        };
        if neighbors().all(|state| map.classes[state] == map.classes[whole]) {
            return Ok((map.classes[whole], map.witnesses[whole]));
        }
        let beside = neighbors().filter_map(|state| map.witnesses[state]);
        let mut beside: Vec<Wave> = beside.collect();
        // At the boundary of the map, and where states were filled in, several neighbors have the same wave vector.
        beside.dedup();
        scope.run(|| class(&study, problem, index, Some(&beside)))
    };
    let found: Vec<_> = (0..4 * columns * rows)
        .into_par_iter()
        .map(of_state)
        .collect::<Result<_, ProblemError>>()?;
    Ok(Domain::new(study, found))
}

/// Class of a state, with a growing wave if the state is unstable and a wave was found.
///
/// `beside` contains the growing waves of neighboring states, or is `None` if these are unknown. `problem` belongs to all states, unless axes vary a
/// setting.
fn class(
    study: &Study,
    problem: &Problem,
    index: usize,
    beside: Option<&[Wave]>,
) -> Result<(Class, Option<Wave>), ProblemError> {
    let coordinates = study.coordinates(index);
    let f = study.deformation_at(&coordinates)?;
    let own = match study.varies_settings() {
        true => Some(Problem::new(study.settings_at(&coordinates)?)?),
        false => None,
    };
    let problem = own.as_ref().unwrap_or(problem);
    let judged = match problem.analysis.judge(&f, beside) {
        Ok(judged) => judged,
        Err(error) if error.leaves_undefined() => return Ok((Class::Undefined, None)),
        Err(error) => return Err(error.into()),
    };
    let class = match (judged.verdict, judged.stability) {
        (Verdict::Numerical, Stability::Flutter) => Class::Flutter,
        (verdict, _) => Class::Verdict(verdict),
    };
    Ok((class, judged.witness))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a refined map each state has the class that a separate evaluation gives, even if it was filled in or an axis varies a setting.
    #[test]
    fn states_of_a_refined_map_have_the_classes_of_single_evaluations() {
        let window = |second: &str| {
            let text = format!(
                "[discretization]\nframe = \"eulerian\"\n\
                 [[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 1.6]\nstates = 7\n[[axes]]\n{second}\nstates = 6\n"
            );
            let study = Study::parse("window.toml", &text).expect("a study");
            Domain::of(&study).expect("a map")
        };
        for second in [
            "quantity = \"discretization.support\"\nrange = [1.2, 2.6]",
            "quantity = \"stretch-2\"\nrange = [0.5, 1.6]",
        ] {
            let coarse = window(second);
            let fine = coarse.halved().expect("a map");
            let alone = Domain::of(&fine.study).expect("a map");
            let is_filled_in = |index: usize| {
                let (column, row) = (index % 14, index / 14);
                fine.classes[index] == coarse.classes[row / 2 * 7 + column / 2]
            };
            let (mut same, mut changed) = (0, 0);
            for index in 0..fine.classes.len() {
                let is_alike = fine.classes[index] == alone.classes[index];
                assert!(is_alike || is_filled_in(index), "{second}: {index}");
                same += usize::from(is_alike);
                changed += usize::from(!is_filled_in(index));
            }
            // Pockets smaller than a state are missed.
            assert!(10 * same > 9 * fine.classes.len(), "{second}: {same}");
            assert!(changed > 5, "{second}: {changed}");
        }
    }
}
