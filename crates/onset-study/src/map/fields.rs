//! Fields stored for each state: the table of fields, with the function that computes each value.

use super::record::{Certainty, Finding, Outcomes, Proof, Record};
use crate::settings::MapSettings;
use crate::store::{Column, Field, Kind};
use onset::bloch::Stability;
use onset::certificate::Reason;
use onset::verdict::Verdict;

/// Name of the field with the verdict, which is written last.
pub const VERDICT: &str = "verdict";

/// Name of the field with the certainty for the particles.
pub const CERTAINTY: &str = "certainty";
/// Name of the field with the certainty for the material.
pub const CERTAINTY_MATERIAL: &str = "certainty_material";
/// Name of the field with the reason why the particles are undecided.
pub(super) const REASON: &str = "undecided_because";
/// Name of the field that flags corrections of the search by a proof.
pub(super) const CORRECTED: &str = "corrected";
/// First meaning of [`REASON`].
const NO_REASON: &str = "decided-or-not-asked";

/// Function that computes the value of a field for a state.
#[derive(Clone, Copy, Debug)]
enum Taken {
    /// Flag for the finding at a state.
    Word(fn(Finding) -> i8),
    /// Flag of a property of a computed record; -1 if the property does not apply.
    Flag(fn(Option<&Record>) -> i8),
    /// Number, for computed states only.
    Number(fn(&Record) -> f64),
    /// Vector, for computed states only.
    Vector(fn(&Record) -> [f64; 3]),
}

/// Fields of a map, each with the function that computes its value.
pub(super) struct Table(Vec<(Field, Taken)>);

/// Fields of a map, in the order of the store.
pub fn fields(map: &MapSettings) -> Vec<Field> {
    Table::of(map).fields()
}

impl Table {
    pub(super) fn of(map: &MapSettings) -> Self {
        let mut table = words();
        table.extend(numbers());
        if map.certify {
            table.extend(proofs());
        }
        table.retain(|(field, _)| map.outputs.hold(field.name));
        Self(table)
    }

    pub(super) fn fields(&self) -> Vec<Field> {
        self.0.iter().map(|(field, _)| field.clone()).collect()
    }

    /// Columns of a tile.
    pub(super) fn columns(&self, outcomes: &Outcomes, components: usize) -> Vec<Column> {
        let Outcomes { findings, computed } = outcomes;
        let numbers = |components: usize, take: &dyn Fn(&Record, &mut [f64])| {
            let mut numbers = vec![f64::NAN; findings.len() * components];
            for (state, record) in computed {
                take(record, &mut numbers[state * components..][..components]);
            }
            Column::Numbers(numbers)
        };
        let column = |(_, taken): &(Field, Taken)| match *taken {
            Taken::Word(take) => {
                let mut flags = Vec::with_capacity(findings.len());
                for run in findings.chunk_by(PartialEq::eq) {
                    flags.resize(flags.len() + run.len(), take(run[0]));
                }
                Column::Flags(flags)
            }
            Taken::Flag(take) => {
                let mut flags = vec![take(None); findings.len()];
                for (state, record) in computed {
                    flags[*state] = take(Some(record));
                }
                Column::Flags(flags)
            }
            Taken::Number(take) => numbers(1, &|record, to| to[0] = take(record)),
            Taken::Vector(take) => numbers(components, &|record, to| {
                to.copy_from_slice(&take(record)[..components]);
            }),
        };
        self.0.iter().map(column).collect()
    }
}

/// Names of the verdicts, in the order of their flags.
pub(super) fn verdicts() -> Vec<&'static str> {
    let names = Verdict::ALL.iter().map(|verdict| verdict.name());
    names.chain(["undefined"]).collect()
}

/// Names of the kinds of stability, in the order of their flags.
const STABILITIES: [(Stability, &str); 3] = [
    (Stability::Stable, "stable"),
    (Stability::Flutter, "flutter"),
    (Stability::Divergence, "divergence"),
];

/// Index of an element in a list, or the length of the list if it is missing.
fn flag<T: PartialEq>(list: &[T], element: Option<T>) -> i8 {
    element
        .and_then(|element| list.iter().position(|other| *other == element))
        .unwrap_or(list.len()) as i8
}

fn words() -> Vec<(Field, Taken)> {
    let stabilities = STABILITIES.map(|(_, name)| name);
    vec![
        words_of(
            VERDICT,
            "the origin of the first instability",
            verdicts(),
            |finding| flag(&Verdict::ALL, finding.verdict),
        ),
        words_of(
            "stability",
            "how perturbations of the discretization develop",
            stabilities.into_iter().chain(["undefined"]).collect(),
            |finding| {
                let stabilities = STABILITIES.map(|(stability, _)| stability);
                flag(&stabilities, finding.stability)
            },
        ),
        flags(
            "evaluated",
            "whether the state was computed, or its verdict follows from its surroundings",
            vec!["filled-in", "computed"],
            |record| i8::from(record.is_some()),
        ),
        flags(
            "long_wave",
            "whether wave_vector belongs to a wave of finite length or is the direction of a long wave",
            vec!["finite", "limit"],
            |record| {
                let is_long_wave = record.and_then(|record| record.is_long_wave);
                is_long_wave.map_or(-1, i8::from)
            },
        ),
    ]
}

fn numbers() -> Vec<(Field, Taken)> {
    vec![
        number(
            "acoustic_minimum",
            "smallest eigenvalue of the acoustic tensor over all directions; values within rounding of zero are zero",
            "stress",
            |record| record.acoustic_minimum,
        ),
        vector(
            "acoustic_direction",
            "reference direction of the softest wave of the continuum",
            "1",
            |record| record.acoustic_direction,
        ),
        number(
            "scaled_minimum",
            "smallest Re omega^2 / (c^2 |k|^2) over the Brillouin zone and the limit of long waves",
            "1",
            |record| record.scaled_minimum,
        ),
        vector(
            "wave_vector",
            "reference wave vector of scaled_minimum; its unit direction in the limit of long waves",
            "1/length",
            |record| record.wave_vector,
        ),
        number(
            "lowest_omega_squared",
            "smallest Re omega^2 over the Brillouin zone",
            "1/time^2",
            |record| record.lowest_omega_squared,
        ),
        number(
            "growth_rate",
            "growth rate of the fastest growing mode, zero if stable; with a transfer of material points, in discrete time with the step discretization.time-step",
            "1/time",
            |record| record.growth_rate,
        ),
        number(
            "critical_time_step",
            "critical time step of time.integrator for the waves of the infinite lattice that do not grow (2 / omega_max of central differences without damping); free faces and distorted cells need less. With a transfer of material points, the critical time step of the transfer",
            "time",
            |record| record.critical_time_step,
        ),
    ]
}

fn proofs() -> Vec<(Field, Taken)> {
    vec![
        flags(
            CERTAINTY,
            "proof status of the waves of the discretization; not-asked if the state was filled in or is undefined",
            Certainty::ALL.map(Certainty::name).to_vec(),
            |record| flag(&Certainty::ALL, Some(proof(record).particles)),
        ),
        flags(
            CERTAINTY_MATERIAL,
            "proof status of the strong ellipticity of the material; not-asked if the state was filled in or is undefined",
            Certainty::ALL.map(Certainty::name).to_vec(),
            |record| flag(&Certainty::ALL, Some(proof(record).material)),
        ),
        flags(
            REASON,
            "reason why the discretization is undecided",
            [NO_REASON]
                .into_iter()
                .chain(Reason::ALL.map(Reason::name))
                .collect(),
            |record| match proof(record).reason {
                None => 0,
                reason => 1 + flag(&Reason::ALL, reason),
            },
        ),
        flags(
            CORRECTED,
            "whether the proof corrects the verdict or the stability found by the search; all numbers except growth_rate are results of the search",
            vec!["as-searched", "corrected"],
            |record| i8::from(proof(record).corrects),
        ),
        number(
            "proved_bound",
            "proved bound of scaled_minimum: a lower bound if stable, an upper bound if unstable",
            "1",
            |record| record.proof.bound,
        ),
        number(
            "material_bound",
            "proved bound of acoustic_minimum over the largest acoustic eigenvalue of the reference state: a lower bound if elliptic, an upper \
             bound otherwise",
            "1",
            |record| record.proof.material_bound,
        ),
    ]
}

fn proof(record: Option<&Record>) -> Proof {
    record.map_or(Proof::NONE, |record| record.proof)
}

fn field(name: &'static str, long_name: &'static str, kind: Kind, taken: Taken) -> (Field, Taken) {
    let is_vector = matches!(taken, Taken::Vector(_));
    let field = Field {
        name,
        long_name,
        kind,
        is_vector,
    };
    (field, taken)
}

fn words_of(
    name: &'static str,
    long_name: &'static str,
    meanings: Vec<&'static str>,
    take: fn(Finding) -> i8,
) -> (Field, Taken) {
    field(name, long_name, Kind::Flags(meanings), Taken::Word(take))
}

fn flags(
    name: &'static str,
    long_name: &'static str,
    meanings: Vec<&'static str>,
    take: fn(Option<&Record>) -> i8,
) -> (Field, Taken) {
    field(name, long_name, Kind::Flags(meanings), Taken::Flag(take))
}

fn number(
    name: &'static str,
    long_name: &'static str,
    unit: &'static str,
    take: fn(&Record) -> f64,
) -> (Field, Taken) {
    field(name, long_name, Kind::Numbers(unit), Taken::Number(take))
}

fn vector(
    name: &'static str,
    long_name: &'static str,
    unit: &'static str,
    take: fn(&Record) -> [f64; 3],
) -> (Field, Taken) {
    field(name, long_name, Kind::Numbers(unit), Taken::Vector(take))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{OUTPUTS, Value};

    #[test]
    fn outputs_are_the_numbers_of_a_state_and_are_stored_only_if_requested() {
        let names: Vec<&str> = numbers().iter().map(|(field, _)| field.name).collect();
        assert_eq!(names, OUTPUTS);
        let mut map = MapSettings::default();
        let names = |map: &MapSettings| -> Vec<&str> {
            fields(map).iter().map(|field| field.name).collect()
        };
        assert!(map.set("outputs", &Value::Words(vec!["growth_rate".to_owned()])));
        assert_eq!(
            names(&map),
            ["verdict", "stability", "evaluated", "growth_rate"]
        );
        assert!(map.set("outputs", &Value::Words(vec!["wave_vector".to_owned()])));
        assert_eq!(
            names(&map),
            [
                "verdict",
                "stability",
                "evaluated",
                "long_wave",
                "wave_vector"
            ]
        );
        assert!(!map.set("outputs", &Value::Words(vec!["growth".to_owned()])));
    }

    #[test]
    fn every_flag_that_a_state_can_have_has_a_meaning() {
        let map = MapSettings {
            certify: true,
            ..MapSettings::default()
        };
        let table = Table::of(&map);
        for verdict in Verdict::ALL.map(Some).into_iter().chain([None]) {
            for (stability, _) in STABILITIES {
                let finding = Finding {
                    verdict,
                    stability: verdict.map(|_| stability),
                };
                let record = Record {
                    finding,
                    is_long_wave: Some(true),
                    ..Record::UNDEFINED
                };
                let columns = table.columns(&vec![record].into(), 2);
                for (field, column) in table.fields().iter().zip(&columns) {
                    if let Kind::Flags(meanings) = &field.kind {
                        let flag = column.flags()[0];
                        assert!((0..meanings.len() as i8).contains(&flag), "{field:?}");
                    }
                }
                let name = verdict.map_or("undefined", Verdict::name);
                assert_eq!(verdicts()[columns[0].flags()[0] as usize], name);
            }
        }
    }

    #[test]
    fn filled_in_states_have_flags_but_no_numbers() {
        let finding = Finding {
            verdict: Some(Verdict::Numerical),
            stability: Some(Stability::Flutter),
        };
        let outcomes = Outcomes {
            findings: vec![finding],
            computed: Vec::new(),
        };
        let table = Table::of(&MapSettings::default());
        for (field, column) in table.fields().iter().zip(table.columns(&outcomes, 2)) {
            let expected = match field.name {
                "verdict" => 3,
                "stability" => 1,
                "evaluated" => 0,
                _ => -1,
            };
            match column {
                Column::Flags(flags) => assert_eq!(flags, [expected], "{}", field.name),
                Column::Numbers(numbers) => assert!(numbers.iter().all(|n| n.is_nan())),
            }
        }
    }
}
