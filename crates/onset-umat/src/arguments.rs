//! Floating-point arguments of a routine, in one block of memory with guard values before, between and after them to detect overruns.

use std::ops::Range;

/// Number of guard values between two arguments.
const MARGIN_VALUES: usize = 64;

/// Guard value: a NaN that no computation produces, so that numbers read beyond an array spoil the result.
const GUARD: f64 = f64::from_bits(0x7ff8_0a11_0000_b0d1);

/// Guard value after the state variables. A routine that updates more of them than exist adds to this number and thereby changes it, which a NaN
/// would not reveal.
const STATE_GUARD: f64 = f64::from_bits(0x0211_0a11_0000_b0d1);

/// Names of the arguments of all routines.
pub const NAMES: [&str; 71] = [
    "STRESS",
    "STATEV",
    "DDSDDE",
    "SSE",
    "SPD",
    "SCD",
    "RPL",
    "DDSDDT",
    "DRPLDE",
    "DRPLDT",
    "PNEWDT",
    "STRAN",
    "DSTRAN",
    "TIME",
    "DTIME",
    "TEMP",
    "DTEMP",
    "PREDEF",
    "DPRED",
    "PROPS",
    "COORDS",
    "DROT",
    "CELENT",
    "DFGRD0",
    "DFGRD1",
    // Arguments of a VUMAT
    "stepTime",
    "totalTime",
    "dt",
    "coordMp",
    "charLength",
    "props",
    "density",
    "strainInc",
    "relSpinInc",
    "tempOld",
    "stretchOld",
    "defgradOld",
    "fieldOld",
    "stressOld",
    "stateOld",
    "enerInternOld",
    "enerInelasOld",
    "tempNew",
    "stretchNew",
    "defgradNew",
    "fieldNew",
    "stressNew",
    "stateNew",
    "enerInternNew",
    "enerInelasNew",
    // Arguments of onset_law
    "F_start",
    "F",
    "properties",
    "state",
    "W",
    "P",
    "A",
    // Arguments of a behavior of MFront
    "s0.gradients",
    "s1.gradients",
    "s0.thermodynamic_forces",
    "s1.thermodynamic_forces",
    "mass_density",
    "material_properties",
    "s0.internal_state_variables",
    "s1.internal_state_variables",
    "external_state_variables",
    "s0.energies",
    "s1.energies",
    "K",
    "rdt",
    "speed_of_sound",
];

/// Block of named arguments with their values.
#[derive(Debug)]
pub struct Arguments {
    numbers: Vec<f64>,
    /// Index in [`NAMES`] and range in the block of each argument.
    places: Vec<(usize, Range<usize>)>,
}

impl Arguments {
    /// Block with the given arguments.
    pub fn of(arguments: &[(&str, &[f64])]) -> Self {
        let size = arguments
            .iter()
            .map(|(_, values)| values.len() + MARGIN_VALUES);
        let mut numbers = Vec::with_capacity(MARGIN_VALUES + size.sum::<usize>());
        numbers.extend([GUARD; MARGIN_VALUES]);
        let mut places = Vec::with_capacity(arguments.len());
        for (name, values) in arguments {
            let start = numbers.len();
            numbers.extend_from_slice(values);
            places.push((place(name), start..numbers.len()));
            numbers.extend([guard_behind(place(name)); MARGIN_VALUES]);
        }
        Self { numbers, places }
    }

    fn range(&self, name: &str) -> Range<usize> {
        let wanted = place(name);
        let found = self.places.iter().find(|(place, _)| *place == wanted);
        found.map_or(0..0, |(_, range)| range.clone())
    }

    /// Values of an argument.
    pub fn values(&self, name: &str) -> &[f64] {
        &self.numbers[self.range(name)]
    }

    /// Pointer to the block, valid until the block is changed.
    pub fn start(&mut self) -> *mut f64 {
        self.numbers.as_mut_ptr()
    }

    /// Index of an argument's first number in the block.
    pub fn offset(&self, name: &str) -> usize {
        self.range(name).start
    }

    /// Index in [`NAMES`] of an argument that was written beyond its ends, or `None`.
    pub fn overrun(&self) -> Option<usize> {
        let changed_in = |start: usize, guard: f64| {
            let is_changed = |n: &usize| self.numbers[*n].to_bits() != guard.to_bits();
            (start..start + MARGIN_VALUES).find(is_changed)
        };
        let (first, _) = self.places.first()?;
        if changed_in(0, GUARD).is_some() {
            return Some(*first);
        }
        let mut behind = self.places.iter().enumerate();
        behind.find_map(|(index, (place, range))| {
            let changed = changed_in(range.end, guard_behind(*place))?;
            // A changed value closer to the next argument belongs to that argument.
            let next = self.places.get(index + 1).map(|(next, _)| *next);
            let is_near = changed < range.end + MARGIN_VALUES / 2;
            Some(if is_near {
                *place
            } else {
                next.unwrap_or(*place)
            })
        })
    }
}

/// Returns true for an array of state variables.
pub fn is_state(name: &str) -> bool {
    ["STATEV", "stateNew", "stateOld", "state"].contains(&name)
}

fn guard_behind(place: usize) -> f64 {
    match NAMES.get(place).is_some_and(|name| is_state(name)) {
        true => STATE_GUARD,
        false => GUARD,
    }
}

fn place(name: &str) -> usize {
    let found = NAMES.iter().position(|known| *known == name);
    found.unwrap_or(NAMES.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_next_to_an_argument_are_guarded_and_values_inside_are_not() {
        let all: Vec<(&str, &[f64])> = NAMES.iter().map(|name| (*name, &[1.0, 2.0][..])).collect();
        let size = Arguments::of(&all).numbers.len();
        for n in 0..size {
            let mut block = Arguments::of(&all);
            assert_eq!(block.overrun(), None);
            block.numbers[n] = 0.5;
            let inside = NAMES.iter().any(|name| block.range(name).contains(&n));
            assert_eq!(block.overrun().is_none(), inside, "{n}");
        }
        let mut block = Arguments::of(&all);
        for (place, name) in NAMES.iter().enumerate() {
            assert_eq!(block.values(name), [1.0, 2.0]);
            let end = block.range(name).end;
            for n in [end, end + 20, block.range(name).start - 1] {
                let guard = std::mem::replace(&mut block.numbers[n], 0.5);
                assert_eq!(block.overrun(), Some(place), "{name}");
                block.numbers[n] = guard;
            }
        }
    }
}
