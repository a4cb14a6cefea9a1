//! Standing checks: tests on random cases, of which `cargo xtask hunt` runs as many as one likes.

/// The seed, and the number of cases: a few in the tests.
pub fn hunted(cases: usize) -> (u64, usize) {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let seed = number("ONSET_SEED").unwrap_or(1);
    let asked = number("ONSET_CASES").map(|cases| cases as usize);
    (seed, asked.unwrap_or(cases))
}

/// The seeds of random cases. Without a seed of the environment, seeds of cases that a search got wrong once come first.
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
