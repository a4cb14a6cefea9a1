"""Calls in child processes, in threads and within laws, and interrupted calls."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
import multiprocessing
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import onset

STATES = np.linspace(0.8, 1.3, 1200).reshape(-1, 2)
SPH = onset.Method("updated-sph", lattice="square")


def _verdicts(_: int) -> list[int]:
    return [int(code) for code in np.asarray(onset.verdicts(method=SPH, stretch=STATES).codes).ravel()]


@pytest.mark.parametrize("start", ["fork", "forkserver", "spawn"])
def test_forked_and_spawned_processes_give_the_same_answers(start: str) -> None:
    expected = _verdicts(0)
    with multiprocessing.get_context(start).Pool(2) as pool:
        assert pool.map_async(_verdicts, range(4)).get(timeout=120) == [expected] * 4


def test_concurrent_threads_give_the_same_answers() -> None:
    expected = _verdicts(0)
    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(_verdicts, range(8), timeout=120)) == [expected] * 8


def test_a_python_law_may_call_onset() -> None:
    base = onset.Material("neo-hooke", mu=1.0, lambda_=2.0)

    def of(name: str) -> Callable[[Any], Any]:
        return lambda F: getattr(base, name)(F=F)

    law = onset.Material(energy=of("energy"), stress=of("stress"), tangent=of("tangent"))
    few = STATES[::10]
    own = onset.verdicts(law, SPH, stretch=few)
    assert list(own.codes.ravel()) == list(onset.verdicts(base, SPH, stretch=few).codes.ravel())


LONG = """
import numpy, onset, signal, time
law = onset.Material("modified-mooney-rivlin")
cell = onset.Method("total-lagrangian-sph", lattice="hexagonal", cells=4, perturbation=0.1)
large = onset.Method("updated-sph", cells=12, perturbation=0.1)
study = onset.Study.of(law, large, {"stretch-1": (0.8, 1.2, 64), "stretch-2": (0.8, 1.2, 64)})
base = onset.Material("neo-hooke", mu=1.0, lambda_=2.0)
started = time.monotonic()
def stress(F):
    if time.monotonic() - started > 0.9:
        time.sleep(5.0)
    return base.stress(F=F)
slow = onset.Material(energy=lambda F: base.energy(F=F), stress=stress, tangent=lambda F: base.tangent(F=F))
def ring(*_):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, ring)
signal.setitimer(signal.ITIMER_REAL, 1.0)
started = time.monotonic()
try:
    %s
except KeyboardInterrupt:
    print(time.monotonic() - started - 1.0)
# The computation stops at its next checkpoint, before it is complete.
time.sleep(2.0)
used = time.process_time()
time.sleep(0.5)
print(time.process_time() - used)
"""

CALLS = {
    "tune": 'onset.tune(cell, "penalty", material=law)',
    "verdicts": 'onset.verdicts(law, onset.Method("updated-sph"), stretch=numpy.random.default_rng(1).uniform(0.7, 1.5, (500_000, 2)))',
    "energy": "[law.energy(F) for F in [numpy.repeat(1.01 * numpy.eye(3)[None], 6_000_000, 0)] for _ in range(20)]",
    "state": "onset.state(law, large, stretch=(1.1, 0.9))",
    "modes": "onset.modes(large)",
    "bands": "onset.bands(law, large, stretch=(1.1, 0.9))",
    "boundary": "onset.boundary(study)",
    "map": 'onset.map_into("map.zarr", study)',
    "path": "onset.path(law, large, from_=(1, 1), to=(1.3, 1))",
    "compare": "onset.compare([large], material=law)",
    "omega_squared": "onset.omega_squared(law, large, k=[[0.01 * i, 0.3] for i in range(2000)], stretch=(1.1, 0.9))",
    "simulate": 'onset.simulate(law, large, stretch=(1.1, 1), cells=(4, 4), steps=100000, out="run")',
    # A step takes longer than the documented time.
    "slow step": 'onset.simulate(slow, onset.Method("total-lagrangian-sph", lattice="square"), stretch=(1, 1), cells=4, steps=100000, checkpoint=1, out="run")',
}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="the system has no timers")
@pytest.mark.parametrize("call", CALLS)
def test_an_interrupt_stops_a_long_computation(call: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", LONG % CALLS[call]], capture_output=True, text=True, cwd=tmp_path, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    numbers = [float(line) for line in done.stdout.split()]
    assert len(numbers) == 2, "the call returned before it was interrupted"
    # Grace period of 0.2 s, with a margin for a loaded machine.
    assert numbers[0] < 2.0
    assert numbers[1] < 0.2


def test_masked_values_are_refused_and_other_layouts_are_read() -> None:
    plain = onset.verdicts(method=SPH, stretch=STATES[:6]).codes
    with pytest.raises(onset.InputError, match="stretch has 1 masked value"):
        onset.verdicts(method=SPH, stretch=np.ma.masked_greater(STATES[:6], STATES[5, 0]))
    unaligned = np.frombuffer(b"x" + STATES[:6].tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(6, 2)
    assert not unaligned.flags.aligned
    for other in [STATES[:6].astype(">f8"), np.asfortranarray(STATES[:6]), np.repeat(STATES[:6], 2, axis=0)[::2], unaligned]:
        assert np.array_equal(onset.verdicts(method=SPH, stretch=other).codes, plain)
    assert np.array_equal(onset.omega_squared(None, SPH, k=unaligned, stretch=(1.1, 1)), onset.omega_squared(None, SPH, k=STATES[:6], stretch=(1.1, 1)))
    assert onset.verdicts(method=SPH, stretch=np.zeros((0, 2))).codes.shape == (0,)


@pytest.mark.parametrize("value", [{"a": 1.0}, {1.0, 2.0}, (x for x in [1.0, 1.0]), [object()], ["1.1", 1.0], [None, 1.0], np.ones((1, 2), dtype=complex)])
def test_what_is_not_an_array_of_numbers_is_refused_with_the_name_of_the_argument(value: Any) -> None:
    with pytest.raises(TypeError, match="^stretch "):
        onset.verdicts(method=SPH, stretch=value)
