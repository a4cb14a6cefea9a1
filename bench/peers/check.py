"""Checks the peers against the command: `python -m peers.check --onset target/release/onset`.

The dynamical matrix that NumPy computes at random states and wave vectors; the extremes that NumPy and JAX find on the grid
of the zone against each other; and their minimum against the frequency that the command gives at its wave vector. Exits
with 1 when one of them differs by more than 1e-9.
"""

import argparse
import json
import subprocess
import sys

import numpy as np

from . import eulerian, lagrangian, lattice, material, with_jax, with_numpy
from .states import LOW, states

TOLERANCE = 1e-9
# The growth rate of a complex pair is the square root of a difference that cancels where branches meet.
TOLERANCE_OF_GROWTH = 1e-6
FRAMES = ("lagrangian", "eulerian")


def answer(onset, frame, state, k):
    """The command's D(k) [2, 2] and lowest Re omega^2; `None` where the support is lost."""
    text = lambda numbers: ",".join(repr(float(number)) for number in numbers)
    arguments = [onset, "dispersion", "--json", "--stretch", text(state), "--wave-vector", text(k)]
    arguments += ["--set", f"discretization.frame={frame}"]
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode == 2 and "support" in done.stderr:
        return None
    done.check_returncode()
    read = json.loads(done.stdout)
    matrix = [[complex(entry["re"], entry["im"]) for entry in row] for row in read["dynamical_matrix"]]
    return np.array(matrix), read["omega_squared"][0]["re"]


def matrix(frame, state, fractions):
    """The peers' D(k) [2, 2]; `None` where the support is lost."""
    s = state[:, None]
    if frame == "lagrangian":
        rows = np.array(lagrangian.coefficients(np, with_numpy.diagonal(s)))[:, :, 0]
        d11, d12, d22 = rows @ lagrangian.zone_tensors(fractions[None])[:, 0]
        return np.array([[d11, d12], [d12, d22]])
    neighbors = eulerian.neighborhood((LOW, LOW))
    constants, seen = with_numpy.force_constants(neighbors, s)
    entries = eulerian.cosines(neighbors, fractions[None]) @ constants[:, :, 0]
    return entries.reshape(2, 2) if seen[0] else None


def difference(a, b):
    """The largest difference relative to the larger magnitude, if both are numbers; infinite if only one is a number."""
    if a is None or b is None:
        return 0.0 if a is None and b is None else np.inf
    a, b = np.asarray(a), np.asarray(b)
    if np.any(np.isnan(a) != np.isnan(b)):
        return np.inf
    scale = np.maximum(1.0, np.nanmax(np.abs(b)))
    return np.nanmax(np.abs(a - b)) / scale


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--onset", required=True)
    parser.add_argument("--states", type=int, default=40)
    arguments = parser.parse_args()
    some = states(arguments.states, seed=7)
    random = np.random.default_rng(7)
    found = {}
    for frame in FRAMES:
        worst = 0.0
        for state in some:
            fractions = random.uniform(-0.5, 0.5, 2)
            read = answer(arguments.onset, frame, state, lattice.wave_vectors(fractions))
            worst = max(worst, difference(matrix(frame, state, fractions), read and read[0]))
        found[f"{frame}: matrix of NumPy against the command"] = (worst, TOLERANCE)

        name = f"{frame.capitalize()}Map"
        few = {} if frame == "lagrangian" else {"bins": 2}
        numpy = getattr(with_numpy, name)(**few)(some)
        jax = getattr(with_jax, name)(**few)(some)
        if frame == "eulerian":
            plain = with_jax.PlainEulerianMap()(some)
            found["eulerian: extremes of JAX as first written against NumPy"] = (
                difference(plain[:, [0, 3]], numpy[:, [0, 3]]),
                TOLERANCE,
            )
        found[f"{frame}: extremes of JAX against NumPy"] = (
            difference(jax[:, [0, 3]], numpy[:, [0, 3]]),
            TOLERANCE,
        )
        found[f"{frame}: growth rate of JAX against NumPy"] = (
            difference(jax[:, 4], numpy[:, 4]),
            TOLERANCE_OF_GROWTH,
        )
        worst = 0.0
        for state, row in zip(some, jax):
            if np.isnan(row[0]):
                continue
            lowest = answer(arguments.onset, frame, state, row[1:3])[1]
            scale = material.speed_squared() * lattice.laplacian(row[1:3] @ lattice.VECTORS.T / (2 * np.pi))
            worst = max(worst, difference(row[0], lowest / scale))
        found[f"{frame}: minimum of JAX against the command"] = (worst, TOLERANCE)
    for name, (worst, tolerance) in found.items():
        print(f"{name}: {worst:.1e} {'' if worst <= tolerance else f'> {tolerance:.0e} DIFFERS'}")
    sys.exit(any(not worst <= tolerance for worst, tolerance in found.values()))


if __name__ == "__main__":
    main()
