"""Long calls that a signal ends; the argument is a seed. Prints `done`, the number of ended calls, and the longest time from signal to end in seconds."""

import faulthandler
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import onset

RANDOM = random.Random(int(sys.argv[1]))
LAW = onset.Material("modified-mooney-rivlin")
ONE = onset.Method("updated-sph", lattice="square")
NINE = onset.Method("updated-sph", cells=3, perturbation=0.1)
MANY = onset.Method("updated-sph", cells=8, perturbation=0.1)
TOTAL = onset.Method("total-lagrangian-sph", lattice="hexagonal", cells=4, perturbation=0.1)
STATES = np.random.default_rng(1).uniform(0.7, 1.5, (20_000, 2))
FOLDER = Path(tempfile.mkdtemp())
STUDY = FOLDER / "study.toml"
AXES = "".join(f'[[axes]]\nquantity = "stretch-{n}"\nrange = [0.8, 1.6]\nstates = 40\n' for n in (1, 2))
STUDY.write_text(f'[discretization]\nmethod = "updated-sph"\ncells = 4\nperturbation = 0.1\n{AXES}')
GRID = np.stack(np.meshgrid(np.arange(60.0), np.arange(60.0)), -1).reshape(-1, 2)
FRAMES = np.stack([GRID * (1 + 0.002 * frame) for frame in range(60)])
CALLS = {
    "verdicts": lambda: onset.verdicts(LAW, NINE, stretch=STATES),
    "omega_squared": lambda: onset.omega_squared(LAW, MANY, k=STATES, stretch=(1.1, 1)),
    "dynamical_matrix": lambda: onset.dynamical_matrix(LAW, MANY, k=STATES[:2000], stretch=(1.1, 1)),
    "stress": lambda: LAW.stress(F=np.repeat(1.01 * np.eye(3)[None], 3_000_000, axis=0)),
    "state": lambda: onset.state(LAW, onset.Method("updated-sph", cells=12, perturbation=0.1), stretch=(1.1, 1)),
    "certified state": lambda: onset.state(LAW, onset.Method("kernel", lattice="cubic"), stretch=(1.1, 1, 1), certify=True),
    "compare": lambda: onset.compare({"a": MANY, "b": TOTAL}, LAW),
    "tune": lambda: onset.tune(TOTAL, "penalty", material=LAW),
    "dispersion": lambda: onset.dispersion(LAW, MANY, k=STATES, stretch=(1.1, 1)),
    "bands": lambda: onset.bands(LAW, MANY, stretch=(1.1, 1)),
    "modes": lambda: onset.modes(MANY),
    "path": lambda: onset.path(LAW, MANY, mode="uniaxial", to=3),
    "limit": lambda: onset.limit(LAW, MANY, vary="material.c1", time_step=1e-3, stretch=(1.1, 1)),
    "recommend": lambda: onset.recommend(LAW, stretches=(0.3, 3)),
    "map": lambda: onset.map_into(FOLDER / "map.zarr", STUDY, overwrite=True),
    "boundary": lambda: onset.boundary(STUDY),
    "simulate": lambda: onset.simulate(LAW, ONE, stretch=(1.1, 1), cells=100, steps=2000),
    "simulate into a folder": lambda: onset.simulate(LAW, ONE, stretch=(1.1, 1), cells=100, steps=2000, out=FOLDER / "run", overwrite=True),
    "screen": lambda: onset.screen(FRAMES, None, None, LAW, ONE),
    "fit": lambda: onset.fit({"uniaxial": (np.linspace(1.1, 3, 50), np.linspace(0.1, 2, 50))}, "ogden", starts=10_000),
    "card": lambda: onset.card(onset.Material("ogden")),
    "criteria": lambda: onset.criteria(onset.Material("ogden")),
    "localize": lambda: onset.localize("gurson"),
}


def rung(*_: object) -> None:
    raise KeyboardInterrupt


faulthandler.enable()
signal.signal(signal.SIGALRM, rung)
end = time.monotonic() + 3.0
count, slowest = 0, 0.0
while time.monotonic() < end:
    name = RANDOM.choice(list(CALLS))
    pause = 0.01 + 0.8 * RANDOM.random()
    due = time.monotonic() + pause
    signal.setitimer(signal.ITIMER_REAL, pause)
    try:
        try:
            CALLS[name]()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    except KeyboardInterrupt:
        count += 1
        if time.monotonic() - due > slowest:
            slowest = time.monotonic() - due
            print(f"{name}: {slowest:.2f} s")
print("done", count, round(slowest, 3))
