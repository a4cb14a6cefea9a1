"""Deterministic pseudo-random states, the same as those of `benches/map.rs`."""

import numpy as np

LOW, HIGH = 0.5, 2.5


def states(count, seed=1):
    """Stretches (stretch-1, stretch-2) [count, 2] in [0.5, 2.5]^2, by splitmix64."""
    with np.errstate(over="ignore"):
        n = np.arange(1, 2 * count + 1, dtype=np.uint64)
        z = np.uint64(seed) + n * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z ^= z >> np.uint64(31)
    uniform = (z >> np.uint64(11)).astype(np.float64) * 2.0**-53
    return (LOW + (HIGH - LOW) * uniform).reshape(count, 2)
