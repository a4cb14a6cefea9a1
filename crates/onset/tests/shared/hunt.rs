//! Tests on random cases; `cargo xtask hunt` runs any number of cases.

/// The seed, and the number of cases: a few in the tests.
pub fn hunted(cases: usize) -> (u64, usize) {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let seed = number("ONSET_SEED").unwrap_or(1);
    let asked = number("ONSET_CASES").map(|cases| cases as usize);
    (seed, asked.unwrap_or(cases))
}
