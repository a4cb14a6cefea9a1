//! Protocol between this process and the process of the routine: binary frames of known size in native byte order.
//!
//! 1. The parent sends the setup: interface of the routine, numbers of properties and state variables, limits of memory and of processor time, the properties, and the name of the behavior.
//! 2. The host replies with a greeting: ready, or the reason for a failure, and the number of state variables.
//! 3. The parent sends batches of paths of deformation gradients; the host replies with one outcome per path, in order, as each is finished.

use std::io::{self, Read};

/// Magic number at the start of the host's greeting, with the version of the protocol.
pub const GREETING: u64 = u64::from_le_bytes(*b"onsetU04");

/// Result of loading the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loaded {
    Ready,
    Failed,
    NoRoutine,
    Unsuitable,
}

impl Loaded {
    pub const fn code(self) -> u64 {
        self as u64
    }

    pub fn of_code(code: u64) -> Option<Self> {
        [Self::Ready, Self::Failed, Self::NoRoutine, Self::Unsuitable]
            .into_iter()
            .find(|loaded| loaded.code() == code)
    }
}

/// Outcome of a path of deformation gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passed {
    Done,
    SmallerIncrement,
    Overrun,
    NoIncrement,
    /// The response contradicts the balance of angular momentum.
    Skew,
    /// The whole path was followed, and the tangent consists of differences of the stress.
    Differenced,
}

impl Passed {
    pub const fn code(self) -> u64 {
        self as u64
    }

    pub fn of_code(code: u64) -> Option<Self> {
        [
            Self::Done,
            Self::SmallerIncrement,
            Self::Overrun,
            Self::NoIncrement,
            Self::Skew,
            Self::Differenced,
        ]
        .into_iter()
        .find(|passed| passed.code() == code)
    }
}

/// Outcome of a path: its result, the increment in which it ended, and the numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    pub passed: Passed,
    pub increment: u32,
    /// Index in [`crate::arguments::NAMES`] of the argument that was written beyond its ends.
    pub argument: u32,
    /// `STRESS`, `DDSDDE` by columns, `SSE`, `SPD`, `SCD`, `PNEWDT`, `STATEV`.
    pub numbers: Vec<f64>,
}

/// Number of values in a reply before the state variables.
pub const FIXED: usize = 6 + 36 + 4;

impl Reply {
    pub fn write(&self, frame: &mut Vec<u8>) {
        put(frame, self.passed.code());
        put(frame, u64::from(self.increment));
        put(frame, u64::from(self.argument));
        put_numbers(frame, &self.numbers);
    }

    pub fn read(from: &mut impl Read, variables: usize) -> io::Result<Self> {
        let mut bytes = vec![0; 8 * (3 + FIXED + variables)];
        from.read_exact(&mut bytes)?;
        let mut words = words(&bytes);
        let mut next = || words.next().unwrap_or_default();
        let passed = Passed::of_code(next()).ok_or_else(nonsense)?;
        let increment = u32::try_from(next()).map_err(|_| nonsense())?;
        let argument = u32::try_from(next()).map_err(|_| nonsense())?;
        Ok(Self {
            passed,
            increment,
            argument,
            numbers: words.map(f64::from_bits).collect(),
        })
    }
}

pub fn put(frame: &mut Vec<u8>, word: u64) {
    frame.extend_from_slice(&word.to_ne_bytes());
}

pub fn put_numbers(frame: &mut Vec<u8>, numbers: &[f64]) {
    for number in numbers {
        put(frame, number.to_bits());
    }
}

pub fn put_text(frame: &mut Vec<u8>, text: &str) {
    put(frame, text.len() as u64);
    frame.extend_from_slice(text.as_bytes());
}

/// Takes a text; bytes that are not UTF-8 are replaced.
pub fn take_text(from: &mut impl Read) -> io::Result<String> {
    let length = take(from)?;
    let mut text = Vec::new();
    from.take(length).read_to_end(&mut text)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

pub fn take(from: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    Ok(u64::from_ne_bytes(bytes))
}

pub fn take_size(from: &mut impl Read) -> io::Result<usize> {
    usize::try_from(take(from)?).map_err(|_| nonsense())
}

pub fn take_numbers(from: &mut impl Read, count: usize) -> io::Result<Vec<f64>> {
    let mut bytes = vec![0; 8 * count];
    from.read_exact(&mut bytes)?;
    Ok(words(&bytes).map(f64::from_bits).collect())
}

/// Returns the error for input that is not a frame of the protocol.
pub fn nonsense() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "no frame")
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u64> + '_ {
    bytes.chunks_exact(8).map(|chunk| {
        let mut word = [0; 8];
        word.copy_from_slice(chunk);
        u64::from_ne_bytes(word)
    })
}
