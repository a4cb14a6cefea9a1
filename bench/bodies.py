"""Time steps of a body in this program and in LAMMPS, in turns: particle-steps per CPU second, and memory.

`python bench/bodies.py --onset PROGRAM --lammps lmp --out bench/bodies.md [--quick]`; `cargo xtask bench` does it.

Both run a free cube of particles on a simple cubic lattice with a support of 2.01 spacings: total-Lagrangian SPH with hourglass control (LAMMPS: smd/tlsph), and
updated SPH with densities by continuity and without corrected gradients (LAMMPS: smd/ulsph), which updates its neighbors; here the particles do not move far enough for an update.
Each turn runs a program twice, with few and with many steps; the difference of user and system time over the difference of steps is the cost of a step, without
the set-up. Memory is the largest resident size per particle, for this program in the larger cube.
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
group {method} type 1
neighbor 0.5 bin
set group all volume 1
set group all smd/mass/density 1
set group all diameter 2.01
{pair}
timestep 0.05
velocity all create 1e-6 12345 dist gaussian
thermo 1000000
run {steps}
"""

# Commands of LAMMPS for each method.
PAIRS = {
    "tlsph": """pair_style smd/tlsph
pair_coeff 1 1 *COMMON 1 1.0 0.3 0.06 0.0 10.0 1.0 *STRENGTH_LINEAR *EOS_LINEAR *END
fix move tlsph smd/integrate_tlsph""",
    "ulsph": """pair_style smd/ulsph *DENSITY_CONTINUITY *VELOCITY_GRADIENT *NO_GRADIENT_CORRECTION
pair_coeff 1 1 *COMMON 1.0 1.0 0.0 1.0 0.0 *EOS_TAIT 1.0 *STRENGTH_LINEAR 0.4 *END
fix move ulsph smd/integrate_ulsph""",
}


def measured(command, folder):
    """User and system seconds, the largest resident size in bytes, and the output."""
    with open(Path(folder) / "out", "w+") as out:
        child = subprocess.Popen(command, stdout=out, cwd=folder)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise SystemExit(f"{command[0]} failed with {child.returncode}")
        out.seek(0)
        return usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss, out.read()


def onset(program, method, side, steps, folder):
    words = ["updated"] if method == "ulsph" else []
    seconds, size, told = measured([program, *words, str(side), str(steps)], folder)
    told = json.loads(told)
    return seconds, size, told["particles"], told["bytes_per_particle"]


def lammps(program, method, side, steps, folder):
    deck = Path(folder) / "in.cube"
    deck.write_text(DECK.format(side=side - 0.5, steps=steps, method=method, pair=PAIRS[method]))
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
    """Memory bandwidth of all cores; bytes per second."""
    return json.loads(measured([program, "bandwidth"], folder)[2])["bytes_per_second"]


# Bytes that a step in 3D writes per particle: deformation gradient, stress, displacement, velocity.
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
    own = str(Path(arguments.onset).absolute())
    ours = lambda method: lambda *rest: onset(own, method, *rest)
    theirs = lambda method: lambda *rest: lammps(arguments.lammps, method, *rest)
    many = {"tlsph": 82, "ulsph": 42}
    lines = [
        "# Steps of a body",
        "",
        "Written by `cargo xtask bench`; do not edit. `bench/bodies.py` describes the measurements.",
        "",
        f"Machine: {processor()}, {os.cpu_count()} cores, shared. {rounds} rounds in turns; median (least - most).",
        "",
    ]
    told = lambda numbers: f"{statistics.median(numbers):,.3g} ({min(numbers):,.3g} - {max(numbers):,.3g})"
    with tempfile.TemporaryDirectory() as folder:
        for method, title in [("tlsph", "Total-Lagrangian SPH"), ("ulsph", "Updated SPH")]:
            turn = lambda: (rate(ours(method), side, (2, many[method]), folder), rate(theirs(method), side, (2, 18), folder))
            rates = [turn() for _ in range(rounds)]
            of_many = rate(ours(method), large, (2, 12), folder)
            _, size, count, kept = ours(method)(large, 2, folder)
            _, other, atoms, _ = theirs(method)(side, 2, folder)
            lines += [
                f"| {title} | million particle-steps per CPU second | memory |",
                "|---|---:|---:|",
                f"| onset, {side}^3 particles, all cores | {told([a / 1e6 for a, _ in rates])} | |",
                f"| onset, {count:,} particles | {of_many / 1e6:.3g} | {size / count / 1000:.3g} kB a particle, {kept / 1000:.3g} kept |",
                f"| LAMMPS `smd/{method}`, {side}^3 particles, one process | {told([b / 1e6 for _, b in rates])} | {other / atoms / 1000:.3g} kB a particle |",
                f"| onset over LAMMPS, round by round | {told([a / b for a, b in rates])} | |",
                "",
            ]
            if method == "tlsph":
                memory = bandwidth(own, folder)
                share = of_many * os.cpu_count() * (kept + WRITTEN) / memory
                bound = f"The memory delivers {memory / 1e9:.3g} GB a second to all cores (triad of STREAM). A step of total-Lagrangian SPH reads at least the {kept:.0f} bytes that are kept for a particle, and writes {WRITTEN} of them: with {count:,} particles that is a share of {share:.2g} of it. The rest of the time goes into arithmetic."
    lines += [bound, ""]
    Path(arguments.out).write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
