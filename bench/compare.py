"""Runs the map of states and its peers in turns and writes the results to a README.

`python bench/compare.py --out bench/README.md [--quick]` from the root of the repository; `cargo xtask bench` does it.
"""

import os

# Set before NumPy is loaded, because the batches already occupy all cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import platform
import statistics
import subprocess
import sys
import time
from pathlib import Path

import jax
import numpy as np

from peers import with_jax, with_numpy
from peers.states import states
from peers.threads import CORES

CARGO = os.environ.get("CARGO", "cargo")
FRAMES = {
    "lagrangian": "Lagrangian kernel",
    "eulerian": "Eulerian kernel (convected lattice, fixed support, exact linearization)",
}
# Seeds of the states: those that are timed, and those whose minima are compared.
TIMED, COMPARED = 1, 2
# Rounding of the minimum, which is of order one for the stiff waves of the reference configuration.
ROUNDING = 1e-12


class Onset:
    """This program, timed by its own benchmark."""

    name = "onset"

    def __init__(self, frame):
        self.frame = frame

    def run(self, count, seed=TIMED, out=None):
        command = [CARGO, "bench", "--quiet", "--package", "onset-study", "--bench", "map", "--"]
        command += [self.frame, "--states", str(count), "--seed", str(seed), "--repetitions", "1"]
        command += ["--out", str(Path(out).absolute())] if out else []
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
        return json.loads(done.stdout.strip().splitlines()[-1])

    def rate(self, count):
        return self.run(count)["states_per_second"]


class Peer:
    """A map written in Python."""

    def __init__(self, name, map_of_states):
        self.name, self.map = name, map_of_states

    def rate(self, count):
        some = states(count, TIMED)
        start = time.perf_counter()
        self.map(some)
        return count / (time.perf_counter() - start)


def contestants(frame, quick):
    """This program first, then the peers, each with the number of states for full speed."""
    if frame == "lagrangian":
        return [
            (Onset(frame), 262144),
            (Peer("JAX", with_jax.LagrangianMap()), 65536),
            (Peer("JAX, mirror symmetry of the states too", with_jax.LagrangianMap(symmetry="mirror")), 65536),
            (Peer("JAX, all 48 x 48 points", with_jax.LagrangianMap(symmetry="none")), 65536),
            (Peer("JAX, plain arrays", with_jax.LagrangianMap(plain=True, batch=256)), 16384),
            (Peer("NumPy", with_numpy.LagrangianMap()), 4096),
        ]
    bins = 3 if quick else 8
    inversion = with_jax.EulerianMap(bins=bins)
    return [
        (Onset(frame), 4096),
        (Peer("JAX", inversion), 65536),
        (Peer("JAX, mirror symmetry of the states too", with_jax.EulerianMap(symmetry="mirror", of=inversion)), 65536),
        (Peer("JAX, all 48 x 48 points", with_jax.EulerianMap(symmetry="none", of=inversion)), 65536),
        (Peer("JAX, as first written", with_jax.PlainEulerianMap()), 64),
        (Peer("NumPy", with_numpy.EulerianMap(bins=bins)), 4096),
    ]


def timed(frame, rounds, seconds, quick):
    """States per second of each program in each round; every program runs once per round."""
    field = []
    for contestant, least in contestants(frame, quick):
        # The first call compiles; the second determines the number of states in a turn.
        contestant.rate(least)
        field.append((contestant, max(least, int(contestant.rate(least) * seconds))))
        print(f"{frame}: {contestant.name}: {field[-1][1]} states a turn", file=sys.stderr)
    rates = {contestant.name: [] for contestant, _ in field}
    for _ in range(rounds):
        for contestant, count in field:
            rates[contestant.name].append(contestant.rate(count))
    return rates


def table(rates):
    """Rows of the table: states per second, and the speed of this program relative to each peer, for each round."""
    own = rates["onset"]
    lines = ["| | states/s: median | min - max | onset is faster by: median | min - max |", "| --- | ---: | ---: | ---: | ---: |"]
    for name, values in rates.items():
        ratios = [a / b for a, b in zip(own, values)]
        ratio = lambda value: f"{value:.3g}"
        lines.append(
            f"| {name} | {statistics.median(values):,.0f} | {min(values):,.0f} - {max(values):,.0f} | "
            f"{ratio(statistics.median(ratios))} | {ratio(min(ratios))} - {ratio(max(ratios))} |"
        )
    return "\n".join(lines)


def minima(frame, count, resolution, folder, quick):
    """Minima of this program compared with the minima of the peer on a finer grid."""
    path = folder / f"minima-{frame}.txt"
    Onset(frame).run(count, COMPARED, path)
    ours = np.loadtxt(path)[:, 0]
    peer = with_jax.LagrangianMap(resolution) if frame == "lagrangian" else with_jax.EulerianMap(
        resolution, bins=3 if quick else 6
    )
    grid = peer(states(count, COMPARED))[:, 0]
    both = ~np.isnan(ours) & ~np.isnan(grid)
    excess = (ours - grid)[both]
    relative = excess / np.maximum(1.0, np.abs(grid[both]))
    return {
        "states": count,
        "compared": int(both.sum()),
        "lost by one only": int((np.isnan(ours) != np.isnan(grid)).sum()),
        "above": int((relative > ROUNDING).sum()),
        "excess": max(0.0, float(relative.max())),
        "below": int((relative < -ROUNDING).sum()),
        "improvement": max(0.0, float(-relative.min())),
        "median improvement": float(np.median(-relative)),
    }


def machine():
    """Processor and versions of the software."""
    processor = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        names = [line.split(":")[1].strip() for line in information.read_text().splitlines() if line.startswith("model name")]
        processor = names[0] if names else processor
    rustc = subprocess.run(["rustc", "--version"], stdout=subprocess.PIPE, text=True).stdout.split()
    return (
        f"{CORES} cores ({processor}), used by all programs; {platform.system()}; Python {platform.python_version()}, "
        f"NumPy {np.__version__}, JAX {jax.__version__} (CPU, double precision), Rust {rustc[1] if len(rustc) > 1 else '?'}."
    )


TEXT = """# The same work in user-level Python

Written by `cargo xtask bench`; do not edit. Other tables: [waiting times](waiting.md), [maps of newer methods](methods.md), [bodies](bodies.md).

**The work.** A map of states: at each state, two stretches drawn at random from [0.5, 2.5]^2 in plane strain, the softest mode
of the particles (min Re omega^2 / (c^2 |k|_h^2) over the zone, and its wave vector), the largest omega^2 (for the critical time
step) and the largest growth rate. Hexagonal lattice with stress points, Shepard functions with the quartic spline,
D_mx = 2, the law of equation (5). Two kernels: the Lagrangian kernel, and the Eulerian kernel on the convected lattice with fixed
support in its exact linearization. States at which a point has lost its neighbors count too.

**The peers** (`bench/peers/`) evaluate a grid of 48 x 48 wave vectors and keep its best point. onset minimizes over the continuous
zone, refines every local minimum, includes the long-wave limit, and assesses the material in addition.

**Fairness.** Quantities that do not depend on the state are computed once and not timed: H(k) of the Lagrangian kernel, neighbors
and cosines of the Eulerian kernel. Only one of k and -k is evaluated. Separate rows show the savings from mirror symmetry, which
holds only for stretches along the axes of the lattice, and the cost of all points. Eigenvalues are in closed form. Eulerian force
constants are built in real space once per state, with lists of neighbors for bins of stretches, and multiplied by cosines.
States are computed in batches of the fastest size, with one thread per core; only results are returned. Compilation is not timed.
Batching and loop order were chosen by measurement. "Plain arrays" leaves the loops to the compiler. "As first written" is
a straightforward version for the Eulerian kernel, compiled and vectorized over states with `vmap`: Fourier sums over a fixed list
of neighbors with complex exponentials. `peers/check.py`
compares the peers with the command at random states and wave vectors (differences below 1e-9); it passed before this run.

**Machine.** {machine}

**The run.** {rounds} rounds; in each of them every program runs for about {seconds:g} s; ratios are computed for each round.

{tables}

## Minima

{minima_states:,} random states; the minimum of onset compared with the minimum of the peer on a {resolution} x {resolution} grid. A
difference counts if it exceeds {rounding:g}, relative to the larger of one and the minimum (the stiff waves of the reference configuration
have the measure one).

| | compared | onset above the grid | largest excess | onset below | largest improvement | median |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |
{minima}

"Compared" omits the states at which the support is lost; on {disagreed} states the two disagree on the loss.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true", help="a fast trial: few rounds, states and bins")
    arguments = parser.parse_args()
    rounds, seconds = (2, 0.2) if arguments.quick else (7, 1.0)
    count, resolution = (200, 96) if arguments.quick else (10_000, 400)
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    folder = Path("target/bench")
    folder.mkdir(parents=True, exist_ok=True)
    sections, rows, disagreed = [], [], 0
    for frame, title in FRAMES.items():
        rates = timed(frame, rounds, seconds, arguments.quick)
        sections.append(f"## {title}\n\n{table(rates)}")
        found = minima(frame, count, resolution, folder, arguments.quick)
        disagreed += found["lost by one only"]
        rows.append(
            f"| {frame} | {found['compared']:,} | {found['above']:,} | {found['excess']:.1e} | {found['below']:,} | "
            f"{found['improvement']:.1e} | {found['median improvement']:.1e} |"
        )
    text = TEXT.format(
        machine=machine(),
        rounds=rounds,
        seconds=seconds,
        tables="\n\n".join(sections),
        minima_states=count,
        resolution=resolution,
        rounding=ROUNDING,
        minima="\n".join(rows),
        disagreed=disagreed,
    )
    arguments.out.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
