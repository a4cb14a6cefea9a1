//! Tests on random cases; `cargo xtask hunt` runs any number of cases.

/// Seed and number of cases, which is small in the tests.
pub fn hunted(cases: usize) -> (u64, usize) {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let seed = number("ONSET_SEED").unwrap_or(1);
    let asked = number("ONSET_CASES").map(|cases| cases as usize);
    (seed, asked.unwrap_or(cases))
}

/// Seeds of random cases. Without a seed in the environment, they start with the seeds of cases for which an earlier search was wrong.
#[allow(dead_code)]
pub fn seeds(cases: usize, mended: &[u64]) -> Vec<u64> {
    let (seed, cases) = hunted(cases);
    let is_hunt = std::env::var("ONSET_SEED").is_ok();
    let mended = if is_hunt { &[] } else { mended };
    mended
        .iter()
        .copied()
        .chain(seed..seed + cases as u64)
        .collect()
}
