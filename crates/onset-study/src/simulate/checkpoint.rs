//! Checkpoints: all data needed to resume a run so that it ends with identical files.
//!
//! A checkpoint contains eight bytes that name the format, the identifier of the run, the counts of each kind of number, the numbers, and a CRC-32C
//! of everything before it; all data are little-endian.

use super::SimulateError;
use onset::motion::PatchState;
use std::path::Path;

/// Name of the checkpoint file.
pub const CHECKPOINT: &str = "checkpoint.onset";

/// Hint for an error that resuming cannot repair.
pub(super) const FRESH_START: &str = "start afresh with --overwrite, or choose another folder";
const FORMAT: &[u8; 8] = b"onsetck3";
/// Number of digits in an identifier.
const IDENTIFIER_DIGITS: usize = 12;
/// Progress of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Progress {
    pub(super) state: PatchState,
    /// Lines of the history, concatenated.
    pub(super) history: Vec<f64>,
    /// Times and amplitudes of the record.
    pub(super) samples: Vec<[f64; 2]>,
    /// Displacements of all fields that have been written, concatenated; kept for small patches only.
    pub(super) fields: Vec<f64>,
}

impl Progress {
    /// Encodes the progress as a checkpoint.
    pub(super) fn bytes(&self, mark: &str) -> Vec<u8> {
        let mut bytes = FORMAT.to_vec();
        bytes.extend(mark.as_bytes());
        let counts = [
            self.state.step,
            self.state.displacements.len() as u64,
            self.state.deformations.len() as u64,
            self.history.len() as u64,
            self.samples.len() as u64,
            self.fields.len() as u64,
        ];
        bytes.extend(counts.iter().flat_map(|count| count.to_le_bytes()));
        let state = self
            .state
            .displacements
            .iter()
            .chain(&self.state.velocities)
            .chain(&self.state.deformations)
            .chain([&self.state.work]);
        let lists = self
            .history
            .iter()
            .chain(self.samples.as_flattened())
            .chain(&self.fields);
        bytes.extend(state.chain(lists).flat_map(|number| number.to_le_bytes()));
        let sum = crc32c::crc32c(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// Decodes a checkpoint of a run with the given identifier, whose numbers must match the sizes of `start`.
    pub(super) fn of_bytes(
        path: &Path,
        bytes: &[u8],
        mark: &str,
        start: &PatchState,
    ) -> Result<Self, SimulateError> {
        let wrong = |what: &str, hint| SimulateError::Checkpoint {
            path: path.to_owned(),
            what: what.to_owned(),
            hint,
        };
        let Some(rest) = bytes.strip_prefix(FORMAT) else {
            return Err(wrong(
                "this is not a checkpoint of `onset simulate`",
                FRESH_START,
            ));
        };
        let damaged = || wrong("the checkpoint is cut off or damaged", FRESH_START);
        let (content, sum) = bytes.split_last_chunk::<4>().ok_or_else(damaged)?;
        if crc32c::crc32c(content) != u32::from_le_bytes(*sum) {
            return Err(damaged());
        }
        let (own, rest) = rest
            .split_at_checked(IDENTIFIER_DIGITS)
            .ok_or_else(damaged)?;
        if own != mark.as_bytes() {
            return Err(wrong(
                "the checkpoint is of another run: study, state, wave, body or steps differ",
                "resume with the arguments of that run, or run this one into another folder",
            ));
        }
        let (numbers, _) = rest[..rest.len() - 4].as_chunks::<8>();
        let (counts, numbers) = numbers.split_at_checked(6).ok_or_else(damaged)?;
        let counts: [u64; 6] = std::array::from_fn(|i| u64::from_le_bytes(counts[i]));
        let numbers: Vec<f64> = numbers.iter().map(|own| f64::from_le_bytes(*own)).collect();
        let [step, components, carried, lines, samples, fields] = counts;
        let (size, tensors) = (start.displacements.len(), start.deformations.len());
        // The work is a single number.
        let total = lines
            .checked_add(1)
            .and_then(|all| all.checked_add(samples.checked_mul(2)?))
            .and_then(|all| all.checked_add(components.checked_mul(2)?))
            .and_then(|all| all.checked_add(carried))
            .and_then(|all| all.checked_add(fields));
        let is_whole = components == size as u64 && carried == tensors as u64;
        if !is_whole || total != Some(numbers.len() as u64) {
            return Err(damaged());
        }
        if let Some(place) = numbers.iter().position(|number| !number.is_finite()) {
            let what = match place {
                place if place < size => "the displacement",
                place if place < 2 * size => "the velocity",
                place if place < 2 * size + tensors => "the deformation",
                _ => "the history",
            };
            return Err(SimulateError::Checkpoint {
                path: path.to_owned(),
                what: format!(
                    "{what} number {} is {}, at step {step}",
                    place % size.max(1),
                    numbers[place]
                ),
                hint: FRESH_START,
            });
        }
        let (displacements, rest) = numbers.split_at(size);
        let (velocities, rest) = rest.split_at(size);
        let (deformations, rest) = rest.split_at(tensors);
        let (work, rest) = rest.split_at(1);
        let (history, rest) = rest.split_at(lines as usize);
        let (samples, fields) = rest.split_at(2 * samples as usize);
        Ok(Self {
            state: PatchState {
                step,
                displacements: displacements.to_vec(),
                velocities: velocities.to_vec(),
                deformations: deformations.to_vec(),
                work: work[0],
            },
            history: history.to_vec(),
            samples: samples.as_chunks().0.to_vec(),
            fields: fields.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Progress;
    use onset::motion::PatchState;
    use std::path::Path;

    fn progress() -> Progress {
        Progress {
            state: PatchState {
                step: 7,
                displacements: vec![0.1, -0.2],
                velocities: vec![1e-300, 3.0],
                deformations: vec![1.0, 0.5, 0.0, 1.25],
                work: 0.125,
            },
            history: vec![0.5, 1.5, 2.5],
            samples: vec![[0.0, 1.0], [0.1, 0.9], [0.2, 0.7]],
            fields: vec![0.25, 0.5],
        }
    }

    #[test]
    fn a_checkpoint_is_restored_as_it_was_written() {
        let bytes = progress().bytes("0123456789ab");
        let start = progress().state;
        let read = Progress::of_bytes(Path::new("c"), &bytes, "0123456789ab", &start);
        assert_eq!(read.expect("a checkpoint"), progress());
    }

    #[test]
    fn damage_of_any_kind_is_reported() {
        let bytes = progress().bytes("0123456789ab");
        let own = progress().state;
        let read = |bytes: &[u8], mark: &str, start: &PatchState| {
            let read = Progress::of_bytes(Path::new("c"), bytes, mark, start);
            read.expect_err("refused").to_string()
        };
        for cut in 0..bytes.len() {
            let told = read(&bytes[..cut], "0123456789ab", &own);
            assert!(
                told.contains("cut off") || told.contains("not a checkpoint"),
                "{told}"
            );
        }
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0x10;
            read(&changed, "0123456789ab", &own);
        }
        assert!(read(&bytes, "0123456789ac", &own).contains("another run"));
        let mut another = own.clone();
        another.displacements.push(0.0);
        assert!(read(&bytes, "0123456789ab", &another).contains("damaged"));
        let without = PatchState {
            deformations: Vec::new(),
            ..own.clone()
        };
        assert!(read(&bytes, "0123456789ab", &without).contains("damaged"));
        let mut wrong = progress();
        wrong.state.velocities[1] = f64::NAN;
        let told = read(&wrong.bytes("0123456789ab"), "0123456789ab", &own);
        assert!(
            told.contains("velocity number 1 is NaN, at step 7"),
            "{told}"
        );
    }
}
