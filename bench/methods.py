"""Cost of a map for newer methods, relative to their nearest relatives.

`python bench/methods.py --onset PROGRAM --out bench/methods.md [--quick]`; `cargo xtask bench` does it.

Each pair of methods differs in the keys that are named. In a round both compute a map of the same states, one after the other, each with one thread; the
processor time of the start of the program is subtracted. Ratios are computed for each round, and the table has their medians.
"""

import argparse
import statistics
import tempfile
from pathlib import Path

from waiting import Program

# Law and states of all maps. The law is compressible and stays elliptic, so that all methods are defined in all states.
LAW = '[material]\nmodel = "neo-hooke"\nmu = 1.0\nlambda = 2.0\n'
AXES = '[[axes]]\nquantity = "stretch-{0}"\nrange = [0.8, 1.3]\nstates = {1}\n'
# Least number of processor seconds of a map, so that times are much longer than the resolution of the clock; most states along an axis.
SECONDS, MOST = 0.4, 96

SPH = {"method": "total-lagrangian-sph", "lattice": "square", "kernel": "wendland-c2", "support": 2.6}
UPDATED = {**SPH, "method": "updated-sph"}
BONDS = {"method": "peridynamics", "lattice": "square", "horizon": 3.015, "bonds": "correspondence"}
CONTROLLED = {**BONDS, "control": "hourglass", "control-coefficient": 0.02}
POINTS = {"method": "material-points", "grid-functions": "gimp"}
CARRIED = {**POINTS, "unknowns": "particles", "transfer": "flip"}
QUADS = {"method": "finite-elements", "mesh": "quadrilaterals"}
TRIANGLES = {"method": "finite-elements", "mesh": "triangles"}
QUADRATIC = {"element-order": "quadratic", "mass": "hrz"}

# Newer method, its keys, its nearest relative and the keys of the relative.
PAIRS = [
    ("total-Lagrangian SPH, shear forces of pairs", {**SPH, "shear-forces": "pairs"}, "stresses of particles", SPH),
    ("total-Lagrangian SPH, mean gradients over bonds", {**SPH, "gradient": "bonds"}, "bond-averaged peridynamics", {**BONDS, "bonds": "bond-averaged"}),
    ("total-Lagrangian SPH, upwinding", {**SPH, "upwinding": "linear"}, "artificial viscosity", {**SPH, "viscosity": 0.1}),
    ("updated SPH, shear forces of pairs", {**UPDATED, "shear-forces": "pairs"}, "stresses of particles", UPDATED),
    ("updated SPH, penalty", {**UPDATED, "penalty": 2.0}, "artificial stress", {**UPDATED, "artificial-stress": 0.3}),
    ("peridynamics, ordinary", {**BONDS, "bonds": "ordinary"}, "bond-based", {**BONDS, "bonds": "bond-based"}),
    ("peridynamics, bond-associated, form I", {**BONDS, "bonds": "bond-associated-form-i"}, "correspondence", CONTROLLED),
    ("peridynamics, bond-associated, form II", {**BONDS, "bonds": "bond-associated-form-ii"}, "correspondence", CONTROLLED),
    ("peridynamics, bond-averaged", {**BONDS, "bonds": "bond-averaged"}, "correspondence", CONTROLLED),
    ("peridynamics, control by the stiffness tensor", {**CONTROLLED, "control": "stiffness-tensor", "control-coefficient": 1.0}, "hourglass control", CONTROLLED),
    ("material points, CPDI", {**POINTS, "grid-functions": "cpdi"}, "GIMP", POINTS),
    ("material points, mean dilatation of a cell", {**POINTS, "dilatation": "cell"}, "dilatation of points", POINTS),
    ("material points, XPIC(2)", {**CARRIED, "transfer": "xpic"}, "FLIP", CARRIED),
    ("material points, FMPM(2)", {**CARRIED, "transfer": "fmpm"}, "FLIP", CARRIED),
    ("material points, FMPM(8)", {**CARRIED, "transfer": "fmpm", "transfer-order": 8}, "FLIP", CARRIED),
    ("quadrilaterals, mean dilatation", {**QUADS, "integration": "mean-dilatation"}, "full integration", QUADS),
    ("quadratic quadrilaterals", {**QUADS, **QUADRATIC}, "quadratic triangles", {**TRIANGLES, **QUADRATIC}),
]

# Why some ratios stay above 1.5.
REASONS = [
    "The ordinary solid couples particles up to two horizons apart: 113 force constants and not 29. Assembly, long waves and the search over wave vectors all sum over them.",
    "",
    "The stable step of upwinding has more minima over the zone: its search evaluates 650 wave vectors a state, the search with artificial viscosity 280. Each costs the same.",
]


def written(value):
    return f'"{value}"' if isinstance(value, str) else str(value)


def study(keys, states):
    """Study of a method with a square map of states."""
    method = "".join(f"{key} = {written(value)}\n" for key, value in keys.items())
    axes = "".join(AXES.format(axis, states) for axis in (1, 2))
    return f"{LAW}[discretization]\n{method}{axes}"


def seconds(program, keys, states):
    """Processor seconds of a map without those of the start."""
    return program.map(study(keys, states), threads=1)[1] - program.map(study(keys, 2), threads=1)[1]


def enough(program, keys):
    """Number of states along an axis of a map that takes long enough."""
    states = 6
    while states < MOST and seconds(program, keys, states) < SECONDS:
        states *= 2
    return states


def compared(program, rounds):
    lines = ["| method | ms a state | relative | ms a state | ratio (least - most) |", "|---|---:|---|---:|---:|"]
    for name, own, relative, other in PAIRS:
        states = enough(program, own)
        taken = [[seconds(program, keys, states) for keys in (own, other)] for _ in range(rounds)]
        ratios = [a / b for a, b in taken]
        mine, theirs = (1e3 * statistics.median(column) / states**2 for column in zip(*taken))
        told = f"{statistics.median(ratios):.2f} ({min(ratios):.2f} - {max(ratios):.2f})"
        lines.append(f"| {name} | {mine:.3g} | {relative} | {theirs:.3g} | {told} |")
        print(lines[-1], flush=True)
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--onset", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    rounds = 1 if asked.quick else 5
    with tempfile.TemporaryDirectory() as folder:
        table = compared(Program(str(Path(asked.onset).resolve()), Path(folder)), rounds)
    text = [
        "# Maps of newer methods",
        "",
        "Written by `cargo xtask bench`; do not edit. `bench/methods.py` describes the measurement and lists the keys of each method.",
        "",
        f"Maps in two dimensions, one thread, {rounds} round{'s' if rounds > 1 else ''}. Milliseconds of a processor; medians.",
        "",
        *table,
        "",
        *REASONS,
    ]
    Path(asked.out).write_text("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
