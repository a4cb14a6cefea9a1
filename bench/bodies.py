"""Steps of a body here and in LAMMPS, in turns: particle-steps per CPU second, and memory.

`python bench/bodies.py --onset PROGRAM --lammps lmp --out bench/bodies.md [--quick]`; `cargo xtask bench` does it.

Both run a free cube of particles on a simple cubic lattice with a support of 2.01 spacings, total-Lagrangian SPH with hourglass control (LAMMPS: smd/tlsph).
Each turn runs a program twice, with few and with many steps; the difference of user and system time over that of the steps is the cost of a step, so that
setting up is not counted. Memory is the largest resident size over the particles, of the larger cube that only this program runs too.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import tempfile
from pathlib import Path

DECK = """
units si
dimension 3
boundary sm sm sm
atom_style smd
atom_modify map array
comm_modify vel yes
neigh_modify every 10 delay 0 check yes
newton off
lattice sc 1.0
region box block 0 {side} 0 {side} 0 {side} units box
create_box 1 box
create_atoms 1 region box
group tlsph type 1
neighbor 0.5 bin
set group all volume 1
set group all smd/mass/density 1
set group all diameter 2.01
pair_style smd/tlsph
pair_coeff 1 1 *COMMON 1 1.0 0.3 0.06 0.0 10.0 1.0 *STRENGTH_LINEAR *EOS_LINEAR *END
fix move tlsph smd/integrate_tlsph
timestep 0.05
velocity all create 1e-6 12345 dist gaussian
thermo 1000000
run {steps}
"""


def measured(command, folder):
    """User and system seconds, the largest resident size in bytes, and what was printed."""
    with open(Path(folder) / "out", "w+") as out:
        child = subprocess.Popen(command, stdout=out, cwd=folder)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise SystemExit(f"{command[0]} failed with {child.returncode}")
        out.seek(0)
        return usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss, out.read()


def onset(program, side, steps, folder):
    seconds, size, told = measured([program, str(side), str(steps)], folder)
    told = json.loads(told)
    return seconds, size, told["particles"], told["bytes_per_particle"]


def lammps(program, side, steps, folder):
    deck = Path(folder) / "in.cube"
    deck.write_text(DECK.format(side=side - 0.5, steps=steps))
    command = [program, "-in", str(deck), "-log", "none"]
    seconds, size, told = measured(command, folder)
    created = [line for line in told.splitlines() if line.startswith("Created") and "atoms" in line]
    return seconds, size, int(created[0].split()[1]), None


def rate(run, side, steps, folder):
    """Particle-steps per CPU second."""
    few, many = steps
    first, _, particles, _ = run(side, few, folder)
    second, *_ = run(side, many, folder)
    return particles * (many - few) / (second - first)


def bandwidth(program, folder):
    """Bytes a second that the memory delivers to all cores."""
    return json.loads(measured([program, "bandwidth"], folder)[2])["bytes_per_second"]


# What a step in space writes of a particle: deformation gradient, stress, displacement, velocity.
WRITTEN = 8 * (9 + 9 + 3 + 3)


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--onset", required=True)
    parser.add_argument("--lammps", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    side, large, rounds = (20, 40, 2) if arguments.quick else (40, 100, 5)
    ours = lambda *rest: onset(str(Path(arguments.onset).absolute()), *rest)
    theirs = lambda *rest: lammps(arguments.lammps, *rest)
    with tempfile.TemporaryDirectory() as folder:
        rates = [(rate(ours, side, (2, 82), folder), rate(theirs, side, (2, 18), folder)) for _ in range(rounds)]
        many = rate(ours, large, (2, 12), folder)
        _, own, count, kept = ours(large, 2, folder)
        _, other, atoms, _ = theirs(side, 2, folder)
        memory = bandwidth(str(Path(arguments.onset).absolute()), folder)
    ratios = [a / b for a, b in rates]
    told = lambda numbers: f"{statistics.median(numbers):,.3g} ({min(numbers):,.3g} - {max(numbers):,.3g})"
    lines = [
        "# Steps of a body",
        "",
        "Written by `cargo xtask bench`; do not edit. What is measured, and how: `bench/bodies.py`.",
        "",
        f"Machine: {processor()}, {os.cpu_count()} cores, shared. {rounds} rounds in turns; median (least - most).",
        "",
        "| | million particle-steps per CPU second | memory |",
        "|---|---:|---:|",
        f"| onset, {side}^3 particles, all cores | {told([a / 1e6 for a, _ in rates])} | |",
        f"| onset, {count:,} particles | {many / 1e6:.3g} | {own / count / 1000:.3g} kB a particle |",
        f"| LAMMPS `smd/tlsph`, {side}^3 particles, one process | {told([b / 1e6 for _, b in rates])} | {other / atoms / 1000:.3g} kB a particle |",
        f"| onset over LAMMPS, round by round | {told(ratios)} | |",
        "",
        f"The memory delivers {memory / 1e9:.3g} GB a second to all cores (triad of STREAM). A step reads at least the {kept:.0f} bytes that are kept for a particle, and writes "
        f"{WRITTEN} of them: with {count:,} particles that is a share of {many * os.cpu_count() * (kept + WRITTEN) / memory:.2g} of it. The rest of the time goes into arithmetic.",
        "",
    ]
    Path(arguments.out).write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
