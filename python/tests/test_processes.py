"""Answers in forked processes, in threads, within laws, and after an interrupt."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
import multiprocessing
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

import onset

STATES = np.linspace(0.8, 1.3, 1200).reshape(-1, 2)
SPH = onset.Method("updated-sph", lattice="square")


def _verdicts(_: int) -> list[int]:
    return [int(code) for code in np.asarray(onset.verdicts(method=SPH, stretch=STATES).codes).ravel()]


@pytest.mark.parametrize("start", ["fork", "forkserver", "spawn"])
def test_children_of_any_kind_answer_as_their_parent(start: str) -> None:
    expected = _verdicts(0)
    with multiprocessing.get_context(start).Pool(2) as pool:
        assert pool.map_async(_verdicts, range(4)).get(timeout=120) == [expected] * 4


def test_threads_answer_at_the_same_time() -> None:
    expected = _verdicts(0)
    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(_verdicts, range(8), timeout=120)) == [expected] * 8


def test_a_law_that_asks_questions_itself_is_answered() -> None:
    base = onset.Material("neo-hooke", mu=1.0, lambda_=2.0)

    def of(name: str) -> Callable[[Any], Any]:
        return lambda F: getattr(base, name)(F=F)

    law = onset.Material(energy=of("energy"), stress=of("stress"), tangent=of("tangent"))
    few = STATES[::10]
    own = onset.verdicts(law, SPH, stretch=few)
    assert list(own.codes.ravel()) == list(onset.verdicts(base, SPH, stretch=few).codes.ravel())


LONG = """
import onset, signal, sys, time
method = onset.Method("total-lagrangian-sph", lattice="hexagonal", cells=4, perturbation=0.1)
signal.setitimer(signal.ITIMER_REAL, 1.0)
asked = time.monotonic()
def ring(*_):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, ring)
try:
    onset.tune(method, "penalty", material=onset.Material("modified-mooney-rivlin"))
except KeyboardInterrupt:
    print(time.monotonic() - asked - 1.0)
"""


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="the system has no timers")
def test_an_interrupt_is_heard_inside_of_a_long_question(tmp_path: Path) -> None:
    begun = time.monotonic()
    done = subprocess.run([sys.executable, "-c", LONG], capture_output=True, text=True, cwd=tmp_path, check=False, timeout=120)
    assert done.stdout, done.stderr
    # The grace of 0.2 s, and what a loaded machine takes.
    assert float(done.stdout) < 2.0
    assert time.monotonic() - begun < 60.0


def test_masked_values_are_refused_and_other_layouts_are_read() -> None:
    plain = onset.verdicts(method=SPH, stretch=STATES[:6]).codes
    with pytest.raises(onset.InputError, match="stretch has 1 masked value"):
        onset.verdicts(method=SPH, stretch=np.ma.masked_greater(STATES[:6], STATES[5, 0]))
    unaligned = np.frombuffer(b"x" + STATES[:6].tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(6, 2)
    assert not unaligned.flags.aligned
    for other in [STATES[:6].astype(">f8"), np.asfortranarray(STATES[:6]), np.repeat(STATES[:6], 2, axis=0)[::2], unaligned]:
        assert np.array_equal(onset.verdicts(method=SPH, stretch=other).codes, plain)
    assert onset.verdicts(method=SPH, stretch=np.zeros((0, 2))).codes.shape == (0,)
