"""Waiting times: the commands of the README, refined maps, maps in 3D, and one map by several processes.

`python bench/waiting.py --onset PROGRAM --out bench/waiting.md [--quick]`; `cargo xtask bench` does it.

Run from the root of the repository. Commands are read from the README: all commands of its consoles, and the first one of each row of its table of questions, except pages that
stay open, placeholders, and other programs. Every command runs once per round, on all cores, in a separate folder with the studies and
comparisons; seconds are medians.
"""

import argparse
import math
import os
import platform
import re
import shlex
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

# Commands of the README that need other programs, or that stay open.
ELSEWHERE = ("explore", "verify", "audit", "plot")
# Longest time of a command of the README, except large studies and simulations; seconds.
BAR = 2.0

# Section on the discretization in a study, for refined maps: the kernel method of the study, and two others.
METHODS = {
    "Eulerian kernel": None,
    "updated SPH": 'method = "updated-sph"\nlattice = "hexagonal"\nartificial-stress = 0.2\n',
    "peridynamics": 'method = "peridynamics"\nlattice = "square"\n',
}


# Disordered supercells of 64 particles.
SUPERCELLS = {
    "2D, kernel in material coordinates": "cells=8 perturbation=0.05",
    "2D, kernel in current coordinates": "cells=8 perturbation=0.05 frame=eulerian",
    "3D, kernel in material coordinates": "lattice=simple-cubic cells=4 perturbation=0.05 quadrature=nodal",
}


def commands(readme):
    """Arguments of the commands of the README."""
    found = []
    for console in re.findall(r"```console\n(.*?)\n```", readme, re.DOTALL):
        for line in re.findall(r"^\$ (onset (?:[^\n]*\\\n)*[^\n]*)", console, re.MULTILINE):
            found.append(line.replace("\\\n", " ").split(";")[0])
    rows = re.findall(r"^\| [^|]*\? \| (.*) \|$", readme, re.MULTILINE)
    found += [first for row in rows for first in re.findall(r"`(onset [^`]*)`", row)[:2]]
    distinct = dict.fromkeys(shlex.join(shlex.split(line)[1:]) for line in found)
    is_own = lambda line: not line.startswith(ELSEWHERE) and "..." not in line and not re.search(r"\b[A-Z]{3,}\b|map\.zarr", line)
    return [shlex.split(line) for line in distinct if is_own(line)]


class Program:
    def __init__(self, path, folder):
        self.path, self.folder = path, folder

    def run(self, arguments, threads=None):
        """Wall and processor seconds, and the output."""
        environment = dict(os.environ)
        if threads:
            environment["RAYON_NUM_THREADS"] = str(threads)
        begin, before = time.perf_counter(), os.times()
        done = subprocess.run(
            [self.path, *arguments], cwd=self.folder, env=environment, capture_output=True, text=True
        )
        wall, after = time.perf_counter() - begin, os.times()
        # Exit code 3 reports a verdict listed in --fail-on.
        if done.returncode not in (0, 3):
            raise SystemExit(f"onset {shlex.join(arguments)}: exit code {done.returncode}\n{done.stderr}")
        used = after.children_user + after.children_system - before.children_user - before.children_system
        return wall, used, done.stdout

    def map(self, study, *more, threads=None):
        """Wall and processor seconds of a map, its number of states, and the number of computed states."""
        out = self.folder / "map.zarr"
        shutil.rmtree(out, ignore_errors=True)
        (self.folder / "study.toml").write_text(study)
        wall, used, printed = self.run(["map", "study.toml", "--out", out.name, *more], threads)
        states, computed = re.search(r"(\d+) states, (\d+) of them computed", printed).groups()
        shutil.rmtree(out)
        return wall, used, int(states), int(computed)


def short(command):
    line = "onset " + shlex.join(command)
    return line if len(line) <= 100 else line[:97] + "..."


def of_readme(program, readme, rounds):
    lines = ["| command | seconds | of all cores |", "|---|---:|---:|"]
    own = commands(readme)
    taken = {shlex.join(command): [] for command in own}
    for _ in range(rounds):
        for command in own:
            taken[shlex.join(command)].append(program.run(command)[:2])
    slow = []
    for command in own:
        wall, used = (statistics.median(column) for column in zip(*taken[shlex.join(command)]))
        lines.append(f"| `{short(command)}` | {wall:.2f} | {used:.2f} |")
        if wall > BAR and command[0] != "simulate":
            slow.append(f"`{short(command)}`")
    told = ", ".join(slow) if slow else "none"
    return lines + ["", f"More than {BAR:g} s, except simulations: {told}."]


def larger(program, root, rounds):
    studies = {name: (root / "studies" / f"{name}.toml").read_text() for name in ("fcc-eulerian", "three-axes")}
    jobs = {
        "`onset reproduce`": lambda: program.run(["reproduce", "--out", "reproduction"])[:2],
        "`onset compare comparisons/irregular.toml`": lambda: program.run(
            ["compare", "comparisons/irregular.toml", "--out", "irregular"]
        )[:2],
        "`onset map studies/three-axes.toml`, 36 x 36 x 12 states": lambda: program.map(studies["three-axes"])[:2],
        "`onset map studies/fcc-eulerian.toml`, 64 x 64 states in 3D": lambda: program.map(studies["fcc-eulerian"])[:2],
    }
    tests = [str(root / "rubber" / f"treloar-{mode}.csv") for mode in ("uniaxial", "equibiaxial", "planar")]
    jobs["`onset fit rubber/treloar-*.csv`, all laws"] = lambda: program.run(["fit", *tests])[:2]
    jobs["`onset fit rubber/treloar-uniaxial.csv --law polynomial-3`"] = lambda: program.run(
        ["fit", tests[0], "--law", "polynomial-3"]
    )[:2]
    for name, keys in SUPERCELLS.items():
        arguments = ["state", "--stretch", "1.02,1.01,1" if "space" in name else "1.1,1"]
        arguments += [part for key in keys.split() for part in ("--set", f"discretization.{key}")]
        jobs[f"`onset state`, 64 disordered particles, {name}"] = lambda arguments=arguments: program.run(arguments)[:2]
    lines = ["| job | seconds (least - most) | of all cores |", "|---|---:|---:|"]
    for name, job in jobs.items():
        walls, used = zip(*(job() for _ in range(rounds)))
        lines.append(f"| {name} | {statistics.median(walls):.1f} ({min(walls):.1f} - {max(walls):.1f}) | {statistics.median(used):.1f} |")
    return lines


def exponent(points):
    """Exponent of the power law through points, by least squares of logarithms."""
    xs, ys = zip(*((math.log(x), math.log(y)) for x, y in points))
    mx, my = statistics.mean(xs), statistics.mean(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def refined(program, root, sizes):
    """Maps of one window at increasing resolution; the edge of the coarsest cells is 1/32 of the window's edge."""
    adaptive = (root / "studies/adaptive.toml").read_text()
    before, rest = adaptive.split("[discretization]\n")
    kernel, axes = rest.split("\n[[axes]]", 1)
    head = "| method | " + " | ".join(f"{n}^2" for n in sizes) + " | exponent of states | of seconds |"
    lines = [head, "|---|" + "---:|" * (len(sizes) + 2)]
    for name, choices in METHODS.items():
        study = f"{before}[discretization]\n{choices or kernel}\n[[axes]]{axes}"
        cells, states, seconds = [], [], []
        for n in sizes:
            sized = study.replace("states = 4096", f"states = {n}")
            wall, _, _, computed = program.map(sized, "--set", f"map.refine-from={n // 32}")
            cells.append(f"{computed:,} in {wall:.1f} s")
            states.append((n, computed))
            seconds.append((n, wall))
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {exponent(states):.2f} | {exponent(seconds):.2f} |")
    return lines


def shared(program, root, rounds):
    """One map by one process and by as many as there are cores, each with one thread."""
    study = (root / "studies/three-axes.toml").read_text()
    cores = len(os.sched_getaffinity(0))
    (program.folder / "shared.toml").write_text(study)

    def seconds(processes):
        out = program.folder / "shared.zarr"
        shutil.rmtree(out, ignore_errors=True)
        environment = dict(os.environ, RAYON_NUM_THREADS="1")
        begin = time.perf_counter()
        running = [
            subprocess.Popen(
                [program.path, "map", "shared.toml", "--out", out.name, "--resume", "--quiet"],
                cwd=program.folder,
                env=environment,
            )
            for _ in range(processes)
        ]
        if any(process.wait() for process in running):
            raise SystemExit("a part of the shared map failed")
        return time.perf_counter() - begin

    counts = [1]
    while counts[-1] * 2 <= max(cores, 2):
        counts.append(counts[-1] * 2)
    taken = {count: [] for count in counts}
    for _ in range(rounds):
        for count in counts:
            taken[count].append(seconds(count))
    lines = ["| processes, one thread each | seconds | efficiency |", "|---:|---:|---:|"]
    alone = statistics.median(taken[1])
    for count in counts:
        own = statistics.median(taken[count])
        lines.append(f"| {count} | {own:.2f} | {alone / (count * own):.2f} |")
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--onset", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--quick", action="store_true")
    choices = parser.parse_args()
    root = Path.cwd()
    rounds = 1 if choices.quick else 3
    sizes = [256, 512] if choices.quick else [256, 512, 1024, 2048, 4096]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name in ("studies", "comparisons"):
            shutil.copytree(root / name, folder / name)
        program = Program(str(Path(choices.onset).resolve()), folder)
        readme = (root / "README.md").read_text()
        parts = [
            "# Waiting times",
            "Written by `cargo xtask bench`; do not edit. `bench/waiting.py` describes the measurements.",
            f"Machine: {platform.processor() or platform.machine()}, {len(os.sched_getaffinity(0))} cores, shared. {rounds} rounds; medians.",
            "## Commands of the README",
            "\n".join(of_readme(program, readme, rounds)),
            "## Larger work",
            "\n".join(larger(program, root, 1 if choices.quick else 2)),
            "## Maps refined along their boundaries",
            "Computed states, and seconds, for the window of `studies/adaptive.toml` at increasing resolution; the edge of the coarsest cells is 1/32 of the window's edge "
            "(`map.refine-from`). Boundaries grow with the first power. All states are stored, whether computed or filled in.",
            "\n".join(refined(program, root, sizes)),
            "## One map by several processes",
            "Simultaneous runs of `onset map studies/three-axes.toml --resume` into one store.",
            "\n".join(shared(program, root, rounds)),
        ]
    Path(choices.out).write_text("\n\n".join(parts) + "\n")


if __name__ == "__main__":
    main()
