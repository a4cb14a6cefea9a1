"""Calls with odd arrays. The arguments are a seed and, for the same in forked processes, the longest time of these in seconds.

Prints `done` and the number of calls, or of forked processes.
"""

import faulthandler
import multiprocessing
import os
import random
import signal
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import onset

RANDOM = random.Random(int(sys.argv[1]))
PLAIN = np.array([[1.1, 0.9], [1.0, 1.0], [0.8, 1.3], [1.2, 1.2]])
SPH = onset.Method("updated-sph", lattice="square")
LAW = onset.Material("neo-hooke", mu=1.0, lambda_=2.0)
TOTAL = onset.Method("total-lagrangian-sph", lattice="square", support=2.0)
GRID = np.stack(np.meshgrid(np.arange(8.0), np.arange(8.0)), -1).reshape(-1, 2)
X = np.stack([GRID * (1 + 0.01 * frame) for frame in range(3)])


def array() -> object:
    kinds = [
        lambda: PLAIN.astype(np.float16),
        lambda: PLAIN.astype(">f8"),
        lambda: PLAIN.astype(np.longdouble),
        lambda: np.asfortranarray(PLAIN),
        lambda: np.repeat(PLAIN, 2, axis=0)[::-2],
        lambda: np.broadcast_to(PLAIN[0], (600, 2)),
        lambda: np.ma.masked_less(PLAIN, 1.0),
        lambda: np.array(1.1),
        lambda: np.zeros((0, 2)),
        lambda: np.zeros((2, 0)),
        lambda: np.full((3, 2), np.nan),
        lambda: np.array([[np.inf, 1.0]]),
        lambda: np.array([[1e308, 1e-308]]),
        lambda: PLAIN.astype(complex),
        lambda: PLAIN.astype(object),
        lambda: PLAIN.astype(str),
        lambda: np.array([[True, False]]),
        lambda: PLAIN.astype(np.int8),
        lambda: np.array(["2026-01-01"], dtype="datetime64[D]"),
        lambda: np.frombuffer(b"x" + PLAIN.tobytes(), dtype=np.uint8)[1:].view(float).reshape(4, 2),
        lambda: np.random.default_rng(RANDOM.randrange(1000)).uniform(0.5, 2.0, (RANDOM.randrange(300), 2)),
        lambda: np.eye(3)[None].repeat(5, axis=0),
        lambda: np.eye(2),
        lambda: PLAIN[:, :1],
        lambda: memoryview(PLAIN),
        lambda: [[1.1, "a"], None],
        lambda: -PLAIN,
    ]
    return RANDOM.choice(kinds)()


CALLS = [
    lambda: onset.verdicts(LAW, SPH, stretch=array()),
    lambda: onset.verdicts(LAW, SPH, F=array()),
    lambda: onset.omega_squared(LAW, SPH, k=array(), stretch=array()),
    lambda: onset.dynamical_matrix(LAW, SPH, k=array(), F=array()),
    lambda: LAW.stress(F=array()),
    lambda: LAW.tangent(stretch=array()),
    lambda: LAW.energy(F=array()),
    lambda: onset.state(LAW, SPH, stretch=array()),
    lambda: onset.waves(LAW, SPH, wave_vector=array(), stretch=(1.1, 1)),
    lambda: onset.screen(X, array(), None, LAW, TOTAL),
    lambda: onset.screen(X, None, array(), LAW, TOTAL),
    lambda: onset.screen(array(), None, None, LAW, TOTAL),
    lambda: onset.screen(X, None, None, LAW, TOTAL, held=array()),
    lambda: onset.screen(X, None, None, LAW, TOTAL, velocity=array()),
    lambda: onset.screen(X, None, None, LAW, TOTAL, F=array()),
    lambda: onset.screen(X, None, None, LAW, TOTAL, stress=array()),
    lambda: onset.screen(X, None, None, LAW, TOTAL, volumes=array()),
    lambda: onset.screen(X, None, None, LAW, TOTAL, elements=array()),
    lambda: onset.fit({"uniaxial": (array(), array())}, "yeoh", starts=1),
    lambda: onset.audit(LAW, stretch=array()),
    lambda: onset.limit(LAW, SPH, vary="material.mu", time_step=1e-2, stretch=array()),
    lambda: onset.path(LAW, SPH, from_=array(), to=array()),
    lambda: onset.simulate(LAW, SPH, stretch=array(), steps=3),
    lambda: onset.Material("neo-hooke", mu=array(), lambda_=2.0),
]


def abused(count: int) -> None:
    for _ in range(count):
        call = RANDOM.choice(CALLS)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                call()
        except (onset.OnsetError, TypeError, ValueError):
            pass


def interrupted() -> None:
    def ring(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGALRM, ring)
    many = np.random.default_rng(1).uniform(0.7, 1.5, (50_000, 2))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.01 + 0.3 * RANDOM.random())
        onset.verdicts(LAW, SPH, stretch=many)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    except KeyboardInterrupt:
        pass


def starved(process: int) -> float:
    """Time for which the threads of a process have waited for a processor."""
    seconds = 0.0
    for stat in Path(f"/proc/{process}/task").glob("*/schedstat"):
        try:
            seconds += int(stat.read_text().split()[1]) / 1e9
        except OSError:
            pass
    return seconds


def forked(longest: float) -> None:
    child = multiprocessing.get_context("fork").Process(target=abused, args=(8,))
    child.start()
    begun = time.monotonic()
    while child.is_alive() and time.monotonic() - begun < longest + starved(child.pid):
        child.join(0.2)
    if child.is_alive():
        # Prints where it is.
        os.kill(child.pid, signal.SIGABRT)
        child.join(1.0)
        child.kill()
        sys.exit("a forked process hangs")
    if child.exitcode != 0:
        sys.exit(f"a forked process ended with {child.exitcode}")


if __name__ == "__main__":
    faulthandler.enable()
    if len(sys.argv) == 2:
        abused(80)
        print("done 80")
    else:
        abused(10)
        if RANDOM.random() < 0.5:
            interrupted()
        for _ in range(4):
            forked(float(sys.argv[2]))
        print("done 4")
