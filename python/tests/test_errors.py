"""Every invalid call raises an onset exception or a TypeError."""

from __future__ import annotations

from collections.abc import Callable
import math
import os
from pathlib import Path
import pickle
import random
import signal
import subprocess
import sys
import textwrap
import time
from typing import Any
import warnings

import numpy as np
import onset
import pytest

from conftest import command

#: Number of random calls.
CALLS = int(os.environ.get("ONSET_PYTHON_CALLS", "2000"))


def test_exceptions_have_key_place_and_hint() -> None:
    with pytest.raises(onset.SettingError) as refused:
        onset.state(method=onset.Method(suport=2.0), stretch=(1, 1))
    error = refused.value
    assert isinstance(error, ValueError) and isinstance(error, onset.OnsetError)
    assert error.key == "discretization.suport" and error.place is None
    assert error.hint is not None and "discretization.support" in error.hint
    assert str(error).startswith("--set discretization.suport=2.0: ") and error.message in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.key, again.hint) == (str(error), error.key, error.hint)


@pytest.mark.parametrize(
    ("make", "assignments"),
    [
        (lambda: onset.Method("updated-sph", latice="square"), ["discretization.method=updated-sph", "discretization.latice=square"]),
        (lambda: onset.Method("updated-sph").replace(kernel="cubik"), ["discretization.method=updated-sph", "discretization.kernel=cubik"]),
        (lambda: onset.Method("finite-elements", kernel="cubic-spline"), ["discretization.method=finite-elements", "discretization.kernel=cubic-spline"]),
        (lambda: onset.Material("neo-hook"), ["material.model=neo-hook"]),
        (lambda: onset.Material("neo-hooke", nu=0.4), ["material.model=neo-hooke", "material.nu=0.4"]),
        (lambda: onset.Material("neo-hooke", mu="soft"), ["material.model=neo-hooke", "material.mu=soft"]),
    ],
)
def test_misspelled_settings_are_refused_at_construction_as_by_the_command(make: Callable[[], object], assignments: list[str]) -> None:
    with pytest.raises(onset.SettingError) as refused:
        make()
    settings = [argument for assignment in assignments for argument in ("--set", assignment)]
    assert str(refused.value) == command("state", "--stretch", "1,1", *settings).error
    assert refused.value.hint is not None


def test_settings_that_are_completed_later_can_be_constructed(tmp_path: Path) -> None:
    assert onset.Material("umat", library=str(tmp_path / "later.so")).assignments
    assert onset.Material("umat").replace(library="./later.so").assignments
    assert onset.Material("neo-hooke", young=2).replace(poisson=0.4).assignments
    assert onset.Method(spacing="1 mm").replace(density="1 g/cm^3").assignments
    assert onset.Material("mu*(I1 - 3)").replace(mu=1.0).assignments
    started = time.perf_counter()
    for n in range(100):
        onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.0 + n / 100)
    assert time.perf_counter() - started < 1.0


def test_answers_cannot_be_constructed_and_wrong_types_are_refused() -> None:
    answer: Any = onset.State
    with pytest.raises(TypeError, match="stretch="):
        answer((1.1, 0.9))
    deformation: Any = np.eye(3)[None]
    with pytest.raises(TypeError, match="F=..."):
        onset.verdicts(deformation)


AXES = "".join(f"[[axes]]\nquantity = 'stretch-{n}'\nrange = [1, 2]\nstates = 2\n" for n in (1, 2))


def test_messages_of_files_have_line_and_column(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text("[discretization]\nkernel = 'cubik'\n" + AXES)
    with pytest.raises(onset.SettingError) as refused:
        onset.boundary(file)
    assert refused.value.place is not None and refused.value.place[1] == 2
    assert refused.value.key == "discretization.kernel"
    with pytest.raises(onset.InputError, match="cannot read"):
        onset.boundary(tmp_path / "none.toml")


def test_earlier_names_are_read_with_a_warning() -> None:
    with pytest.warns(UserWarning, match="lattice"):
        onset.state(method=onset.Method(arrangement="square"), stretch=(1, 1))


def test_warnings_point_to_the_line_of_the_caller() -> None:
    axes = {"stretch-1": (1.0, 1.2, 2), "stretch-2": (1.0, 1.2, 2)}
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        onset.Study.of("neo-hooke", onset.Method(arrangement="square"), axes)
    assert [(Path(one.filename).name, one.category) for one in warned] == [("test_errors.py", UserWarning)]


def test_warnings_turned_into_errors_do_not_replace_an_exception() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(onset.InputError, match="cannot be -1.5") as refused:
            onset.Method(arrangement="square", support=-1.5)
        assert any("lattice" in note for note in refused.value.__notes__)
        # The warning is not repeated by the next call.
        onset.state(stretch=(1, 1))


def test_a_library_named_in_a_study_is_loaded_only_if_it_is_allowed(tmp_path: Path) -> None:
    text = "[material]\nmodel = 'umat'\nlibrary = './no.so'\n" + AXES
    with pytest.raises(onset.SettingError):
        onset.Study(text)
    onset.Study(text, allow_library=["./no.so"])


def test_unwritable_files_raise_machine_errors() -> None:
    study = onset.Study("[material]\nmodel = 'neo-hooke'\n" + AXES)
    with pytest.raises(onset.MachineError, match=r"cannot write .*\n  hint: "):
        study.save("/dev/null/study.toml")
    with pytest.raises(onset.MachineError):
        onset.modes(onset.Method(quadrature="nodal")).save("/dev/null/modes")


def test_objects_are_immutable() -> None:
    answer = onset.state(stretch=(1.1, 1.0))
    for thing in (answer, answer.discretization, onset.Material(), onset.Method()):
        with pytest.raises(AttributeError):
            thing.verdict = "stable"
    with pytest.raises(AttributeError, match="verdict"):
        answer.no_such_name


class Raising:
    """Object that raises on every conversion."""

    def __init__(self, error: type[Exception]) -> None:
        self.error = error

    def _raise(self, *_: Any) -> Any:
        raise self.error("no")

    __array__ = __float__ = __index__ = __iter__ = __len__ = __getitem__ = __fspath__ = _raise


def thing(chance: random.Random, depth: int = 0) -> Any:
    """Random argument of a call, valid or invalid."""
    kinds = [
        lambda: chance.choice([0, 1, -1, 2, 7, 2**70, -(2**70), True, False, None]),
        lambda: chance.choice([0.0, 1.0, 1.1, -1.5, 1e300, 1e-300, math.nan, math.inf, -math.inf]),
        lambda: chance.uniform(0.5, 2.0),
        lambda: chance.choice(["", "stable", "square", "1.1,1", "NaN", "\ud800", "\x00", "é", "x" * 3000, "mu/2*(I1-3)", "j2", "uniaxial", "="]),
        lambda: chance.choice([b"bytes", object(), int, len, ..., 1j, {1, 2}, range(3), Path("no/such/file"), np.float32(1.5), np.bool_(True)]),
        lambda: Raising(chance.choice([RuntimeError, ValueError, KeyError, ZeroDivisionError, OSError])),
        lambda: np.random.default_rng(chance.randrange(99)).uniform(0.5, 1.5, [chance.randrange(4) for _ in range(chance.randrange(4))]),
        lambda: chance.choice([np.eye(2), np.eye(3), -np.eye(3), np.zeros((3, 3)), np.full((3, 3), np.nan), np.eye(3, dtype=complex), np.array(["a"])]),
        lambda: np.eye(3)[:, ::-1] + np.eye(3),
        lambda: (1.1, 1.0),
        lambda: onset.Material(),
        lambda: onset.Method("updated-sph", lattice="square"),
    ]
    if depth < 2:
        kinds += [
            lambda: [thing(chance, depth + 1) for _ in range(chance.randrange(4))],
            lambda: {chance.choice(["a", "support", 1]): thing(chance, depth + 1) for _ in range(2)},
        ]
    return chance.choice(kinds)()


#: Functions with arguments for which they return quickly; some of the arguments are replaced.
CALLS_OF: list[tuple[Any, dict[str, Any]]] = [
    (onset.state, {"material": "neo-hooke", "method": None, "stretch": (1.1, 1.0), "F": None, "certify": False, "tolerance": 1e-3, "weak": 0.1}),
    (onset.waves, {"material": None, "method": None, "wave_vector": (1.0, 0.5), "stretch": (1.1, 1.0), "F": None}),
    (onset.dispersion, {"material": None, "method": None, "k": (1.0, 0.5), "stretch": (1.1, 1.0), "F": None}),
    (onset.omega_squared, {"material": None, "method": None, "k": (1.0, 0.5), "stretch": (1.1, 1.0), "F": None}),
    (onset.dynamical_matrix, {"material": None, "method": None, "k": (1.0, 0.5), "stretch": (1.1, 1.0), "F": None}),
    (onset.verdicts, {"material": None, "method": None, "F": None, "stretch": (1.1, 1.0)}),
    (onset.path, {"material": None, "method": None, "from_": (1, 1), "to": (1.1, 1), "mode": None, "lateral": None}),
    (onset.audit, {"material": "neo-hooke", "strain": 0.1, "stretch": (), "F": (), "convention": None}),
    (onset.localize, {"model": "no-law", "path": "plane-strain", "load": None, "friction": 0.5}),
    (onset.modes, {"method": "no-method", "material": None, "weak": 0.5, "cells": 2, "amplitude": 0.2}),
    (onset.tune, {"method": "updated-sph", "key": "no-key", "material": None, "range": (0, 1), "stretches": (0.9, 1.1), "weak": 0.1}),
    (onset.limit, {"material": None, "method": None, "vary": "no-key", "time_step": 0.1, "stretch": (1.1, 1.0), "F": None, "range": (1, 2), "safety": 1.0}),
    (onset.compare, {"methods": [], "material": None, "set": (), "states": 4}),
    (onset.recommend, {"material": "no-law", "methods": None, "dimension": 1, "stretches": None, "weak": 0.1, "wavelength": 8}),
    (onset.criteria, {"material": "no-law", "range": (0.5, 2), "modes": ("uniaxial",), "incompressible": False}),
    (onset.card, {"material": "no-law", "range": (0.5, 2), "modes": ("uniaxial",), "incompressible": False}),
    (onset.boundary, {"study": "no/file.toml", "flutter": False}),
    (onset.map_into, {"out": "/dev/null/store", "study": "no/file.toml", "tiles": None, "resume": False, "overwrite": False}),
    (onset.simulate, {"material": None, "method": "no-method", "stretch": (1, 1), "cells": 2, "steps": 1, "amplitude": 1e-6, "turns": None, "seed": 1}),
    (onset.Material, {"model": None, "energy": None, "mu": 0.4}),
    (onset.Material.read, {"block": "*HYPERELASTIC", "program": "abaqus"}),
    (onset.Material("neo-hooke").stress, {"F": np.eye(3)}),
    (onset.Material("neo-hooke").gradient, {"x": [np.eye(3)]}),
    (onset.Material("neo-hooke").replace, {"mu": 1.0, "lambda_": 2.0}),
    (onset.Method, {"method": None, "support": 2.0, "kernel": "cubic-spline"}),
    (onset.Study, {"text": "[state]", "name": "s", "set": (), "allow_library": ()}),
    (onset.Study.of, {"material": None, "method": None, "axes": {"shear": (0, 1, 2)}, "title": "", "state": None, "map": None}),
    (onset.keys, {"section": ""}),
    (onset.open_map, {"store": "/dev/null/store"}),
]


def test_every_call_returns_an_answer_or_raises_an_onset_error() -> None:
    chance = random.Random(23)
    refused = 0
    for number in range(CALLS):
        function, arguments = CALLS_OF[number % len(CALLS_OF)]
        names = chance.sample(list(arguments), k=min(len(arguments), chance.choice([1, 1, 2])))
        given = arguments | {name: thing(chance) for name in names}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                function(**given)
        except (onset.OnsetError, TypeError) as error:
            refused += 1
            text = str(error)
            assert "panic" not in text and "internal error" not in text, (function, given, text)
        except Exception as error:
            raise AssertionError(f"{function} {given}: {error!r}") from error
    assert refused > 0.5 * CALLS


# Background jobs may inherit ignored interrupts; the child process restores the handler.


def test_an_interrupted_map_resumes_to_the_same_store(tmp_path: Path) -> None:
    study = onset.Study.of(
        "neo-hooke",
        onset.Method("updated-sph", lattice="square", support=2.6),
        {"stretch-1": (0.7, 1.5, 96), "stretch-2": (0.7, 1.5, 96)},
        map={"tile": 8},
    )
    study.save(tmp_path / "study.toml")
    program = textwrap.dedent(
        f"""
        import signal, onset
        signal.signal(signal.SIGINT, signal.default_int_handler)
        print("begun", flush=True)
        try:
            onset.map_into({str(tmp_path / "cut.zarr")!r}, {str(tmp_path / "study.toml")!r})
        except KeyboardInterrupt:
            print("ended", flush=True)
        """
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        running.stdout.readline()
        # Interrupts when the first tiles are stored, on machines of any speed.
        while running.poll() is None and len(list((tmp_path / "cut.zarr").glob("verdict/c/*/*"))) < 3:
            time.sleep(0.001)
        running.send_signal(signal.SIGINT)
        out, _ = running.communicate(timeout=60)
    assert out in ("ended\n", "")
    resumed = onset.map_into(tmp_path / "cut.zarr", study, resume=True)
    whole = onset.map_into(tmp_path / "whole.zarr", study)
    assert resumed.tiles_done == whole.tiles_done == resumed.tiles
    if out:
        assert 0 < resumed.tiles_computed < resumed.tiles

    def contents(folder: Path) -> dict[str, bytes]:
        return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    assert contents(tmp_path / "cut.zarr") == contents(tmp_path / "whole.zarr")


def test_noise_refuses_the_arguments_of_a_single_wave() -> None:
    for wave in ({"wave_vector": (1.0, 0.0)}, {"turns": (1, 0)}):
        with pytest.raises(onset.InputError, match='mode "noise" has no wave'):
            onset.simulate("neo-hooke", "total-lagrangian-sph", stretch=(1, 1), cells=4, steps=1, mode="noise", **wave)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: onset.verdicts(stretch=[[math.nan, 1.0]]), "stretch"),
        (lambda: onset.verdicts(F=np.full((2, 2), math.inf)), "F"),
        (lambda: onset.state(stretch=(math.nan, 1.0)), "stretch"),
        (lambda: onset.waves(wave_vector=(math.nan, 1.0), stretch=(1, 1)), "wave_vector"),
        (lambda: onset.waves(wave_vector=(1.0, 0.0, 0.0), stretch=(1, 1)), "wave_vector"),
        (lambda: onset.simulate(stretch=(1, 1), wave_vector=(math.inf, 0.0)), "wave_vector"),
        (lambda: onset.verdicts(stretch=np.array([["1.1", "1"]], dtype=object)), "stretch"),
        (lambda: onset.verdicts(stretch=np.array([[None, 1.0]], dtype=object)), "stretch"),
        (lambda: onset.Material("neo-hooke", mu=np.ma.array(1.0, mask=True), lambda_=1), "material.mu"),
        (lambda: onset.Material("neo-hooke", mu=np.ma.masked, lambda_=1), "material.mu"),
    ],
)
def test_wrong_values_are_refused_with_the_name_of_the_argument(call: Any, name: str) -> None:
    with pytest.raises((TypeError, ValueError)) as refused:
        call()
    assert str(refused.value).startswith(name) and "--" not in str(refused.value)
