"""Documents and messages agree with the command, byte for byte, for random settings."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import multiprocessing
import os
from pathlib import Path
import pickle
import random
import re
import signal
from threading import Thread
import time
from typing import cast
import warnings

import onset
import pytest

from conftest import Output, command

#: Number of random settings.
CASES = int(os.environ.get("ONSET_PYTHON_CASES", "200"))

#: Call in Python, and the arguments of the same command.
Call = tuple[Callable[[], onset.Answer], list[str]]

METHODS: list[tuple[dict[str, object], int]] = [
    ({}, 2),
    ({"frame": "eulerian"}, 2),
    ({"quadrature": "nodal"}, 2),
    ({"approximation": "mls", "support": 2.4}, 2),
    ({"lattice": "chain", "kernel": "cubic-spline"}, 1),
    ({"method": "total-lagrangian-sph", "lattice": "square", "penalty": 0.25}, 2),
    ({"method": "updated-sph", "lattice": "square", "artificial_stress": 0.3}, 2),
    ({"method": "finite-elements", "integration": "one-point"}, 2),
    ({"method": "material-points"}, 2),
    ({"spacing": "1 mm"}, 2),
]

MATERIALS: list[tuple[str | None, dict[str, object]]] = [
    (None, {}),
    ("neo-hooke", {"mu": 0.4, "lambda_": 2.0}),
    ("neo-hooke-isochoric", {"young": 2.0, "poisson": 0.49}),
    ("blatz-ko", {}),
    ("ogden", {}),
    ("yeoh", {}),
    ("hencky", {}),
    ("saint-venant-kirchhoff", {}),
    ("mu/2*(I1 - 3 - 2*ln(J)) + 2*(J - 1)^2", {"mu": 0.7}),
    ("mu/2*(I1 - 3", {"mu": 0.7}),
]


def material(chance: random.Random) -> tuple[onset.Material, list[str]]:
    """Random material, for Python and for the command line."""
    model, parameters = chance.choice(MATERIALS)
    here = onset.Material(model, **parameters)  # type: ignore[arg-type]
    sets = [f"material.{name.rstrip('_')}={value}" for name, value in parameters.items()]
    if model is not None and " " in model:
        sets = ["material.model=formula", f"material.energy={model}", *sets]
    elif model is not None:
        sets = [f"material.model={model}", *sets]
    return here, [word for one in sets for word in ("--set", one)]


def method(chance: random.Random) -> tuple[onset.Method, list[str], int]:
    """Random method, for Python and for the command line, and its number of dimensions."""
    choices, dimension = chance.choice(METHODS)
    sets = [f"discretization.{name.replace('_', '-')}={value}" for name, value in choices.items()]
    return onset.Method(**choices), [word for one in sets for word in ("--set", one)], dimension  # type: ignore[arg-type]


def state(chance: random.Random, dimension: int) -> tuple[dict[str, object], list[str]]:
    """Random state, for Python and for the command line; some states are invalid."""
    if chance.random() < 0.6:
        stretches = [chance.uniform(0.6, 1.8) for _ in range(chance.choice([dimension, 3]))]
        if chance.random() < 0.05:
            stretches[0] = chance.choice([-1.0, 0.0, float("nan"), float("inf")])
        return {"stretch": stretches}, ["--stretch", ",".join(map(repr, stretches))]
    side = chance.choice([dimension, 3])
    F = [[float(i == j) + chance.uniform(-0.25, 0.25) for j in range(side)] for i in range(side)]
    return {"F": F}, ["--deformation-gradient", ",".join(repr(x) for row in F for x in row)]


def of_state(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    given, words = state(chance, dimension)
    certify = chance.random() < 0.1
    proof = ["--certify"] if certify else []
    weak = chance.uniform(0.05, 0.9)
    typed = ["state", *law_words, *own_words, *words, *proof, "--weak", repr(weak)]
    return lambda: onset.state(law, own, certify=certify, weak=weak, **given), typed  # type: ignore[arg-type]


def of_waves(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    given, words = state(chance, dimension)
    k = [chance.uniform(-4.0, 4.0) for _ in range(dimension)]
    typed = ["--wave-vector", ",".join(map(repr, k))]
    return lambda: onset.waves(law, own, wave_vector=k, **given), ["dispersion", *law_words, *own_words, *words, *typed]  # type: ignore[arg-type]


def of_bands(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    given, words = state(chance, dimension)
    return lambda: onset.bands(law, own, **given), ["dispersion", *law_words, *own_words, *words, "--path"]  # type: ignore[arg-type]


def of_path(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    words = ["path", *law_words, *own_words]
    if chance.random() < 0.5:
        start, end = ([chance.uniform(0.7, 1.6) for _ in range(dimension)] for _ in range(2))
        typed = ["--from", ",".join(map(repr, start)), "--to", ",".join(map(repr, end))]
        return lambda: onset.path(law, own, from_=start, to=end), [*words, *typed]
    mode = chance.choice(["uniaxial", "equibiaxial", "planar", "simple-shear"])
    end_stretch = chance.uniform(1.1, 2.5)
    return lambda: onset.path(law, own, mode=mode, to=end_stretch), [*words, "--mode", mode, "--to", repr(end_stretch)]


def of_criteria(chance: random.Random) -> Call:
    law, words = material(chance)
    mode = chance.choice(["uniaxial", "planar", "equibiaxial"])
    incompressible = chance.random() < 0.3
    typed = ["--mode", mode, *(["--incompressible"] if incompressible else [])]
    return lambda: onset.criteria(law, modes=[mode], incompressible=incompressible), ["criteria", *words, *typed]


def of_card(chance: random.Random) -> Call:
    law, words = material(chance)
    return lambda: onset.card(law, range=(0.5, 2.0), modes=["uniaxial"]), ["card", *words, "--range", "0.5,2", "--mode", "uniaxial"]


def of_audit(chance: random.Random) -> Call:
    law, words = material(chance)
    strain = chance.uniform(0.02, 0.3)
    return lambda: onset.audit(law, strain=strain), ["audit", *words, "--strain", repr(strain)]


def of_localize(chance: random.Random) -> Call:
    model = chance.choice(["drucker-prager", "j2", "mohr-coulomb", "gurson", "no-such-law"])
    path = chance.choice(["plane-strain", "uniaxial-stress", "triaxial-compression"])
    return lambda: onset.localize(model, path), ["localize", "--model", model, "--path", path]


def of_modes(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, _ = method(chance)
    weak = chance.uniform(0.1, 0.9)
    return lambda: onset.modes(own, law, weak=weak), ["modes", *law_words, *own_words, "--weak", repr(weak)]


def of_tune(chance: random.Random) -> Call:
    key = chance.choice(["penalty", "support", "frame"])
    own = onset.Method("total-lagrangian-sph", lattice="square")
    words = ["--set", "discretization.method=total-lagrangian-sph", "--set", "discretization.lattice=square"]
    return lambda: onset.tune(own, key, range=(0.0, 2.0)), ["tune", f"discretization.{key}", *words, "--range", "0,2"]


def of_limit(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    given, words = state(chance, dimension)
    key = chance.choice(["discretization.spacing", "discretization.density", "discretization.lattice"])
    step = chance.choice(["0.01", "1e-3", "1 s"])
    typed = ["--vary", key, "--time-step", step]
    return lambda: onset.limit(law, own, vary=key, time_step=step, **given), ["limit", *law_words, *own_words, *words, *typed]  # type: ignore[arg-type]


def of_simulate(chance: random.Random) -> Call:
    law, law_words = material(chance)
    own, own_words, dimension = method(chance)
    given, words = state(chance, dimension)
    mode = chance.choice(["critical", "noise"])
    typed = ["--cells", "4", "--mode", mode, "--steps", "200"]
    return lambda: onset.simulate(law, own, cells=4, mode=mode, steps=200, **given), ["simulate", *law_words, *own_words, *words, *typed]  # type: ignore[arg-type]


#: Calls with their percentages.
PERCENTAGES: list[tuple[int, Callable[[random.Random], Call]]] = [
    (30, of_state),
    (14, of_waves),
    (4, of_bands),
    (8, of_path),
    (8, of_criteria),
    (4, of_card),
    (8, of_audit),
    (6, of_localize),
    (6, of_modes),
    (2, of_tune),
    (4, of_limit),
    (6, of_simulate),
]


def answered(ask: Callable[[], onset.Answer]) -> tuple[int, str]:
    """Exit code, and document or message as printed by the command."""
    try:
        return 0, ask().json
    except onset.InputError as error:
        return 2, str(error)
    except onset.MachineError as error:
        return 1, str(error)


def test_python_and_command_line_give_identical_documents_and_messages() -> None:
    chance = random.Random(17)
    weights = [weight for weight, _ in PERCENTAGES]
    # Each call is made at least once, further calls at random by percentage.
    makers = [make for _, make in PERCENTAGES] + chance.choices([make for _, make in PERCENTAGES], weights, k=CASES - len(PERCENTAGES))
    calls = [make(chance) for make in makers]
    with ThreadPoolExecutor(2) as pool:
        outputs: list[Output] = list(pool.map(lambda call: command(*call[1]), calls))
    codes = []
    for (ask, words), there in zip(calls, outputs, strict=True):
        code, here = answered(ask)
        codes.append(code)
        if code == 0:
            assert here == there.document, words
            # A simulation that disagrees with the prediction still prints a document.
            assert there.code in (0, 1, 3), words
        else:
            # Arguments have the names of options without hyphens; settings are quoted as for the command.
            told = there.error if here.startswith("--") else there.error.removeprefix("--")
            assert (code, here) == (there.code, told), words
    assert codes.count(0) > 0.4 * CASES and codes.count(2) > 0.05 * CASES


COMPARISON = """title = "Two"
[material]
model = "neo-hooke"
[compare]
states = 6
[[methods]]
name = "a"
lattice = "square"
method = "total-lagrangian-sph"
[[methods]]
name = "b"
lattice = "square"
frame = "eulerian"
"""


def test_comparisons_agree_with_the_command(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(COMPARISON)
    words = ["compare", str(file), "--set", "compare.states=5"]
    assert onset.compare(file, set=["compare.states=5"]).json == command(*words).document
    ours = onset.recommend(methods=file, weak=0.2, stretches=(0.8, 1.3))
    assert ours.json == command("recommend", str(file), "--weak", "0.2", "--stretches", "0.8,1.3").document
    own = onset.compare(
        {
            "a": onset.Method("total-lagrangian-sph", lattice="square"),
            "b": onset.Method(lattice="square", frame="eulerian"),
        },
        "neo-hooke",
        states=6,
    )
    document = own.to_dict()
    document["title"] = "Two"
    assert document == onset.compare(file).to_dict()


STUDY = """[material]
model = "neo-hooke"
[discretization]
frame = "eulerian"
support = 1.6
[map]
tile = 8
[[axes]]
quantity = "stretch-1"
range = [0.7, 1.4]
states = 12
[[axes]]
quantity = "stretch-2"
range = [0.7, 1.4]
states = 10
"""


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_boundaries_and_maps_agree_with_the_command(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    assert onset.boundary(file).json == command("boundary", str(file)).document
    there = command("map", str(file), "--out", str(tmp_path / "there.zarr"))
    here = onset.map_into(tmp_path / "here.zarr", file)

    def without_time(document: str) -> str:
        timeless = re.sub(r'"(seconds|states_per_second)": [^,\n]*', r'"\1": 0', document)
        return re.sub(r"(here|there)\.zarr", "zarr", timeless)

    assert without_time(here.json) == without_time(there.document)
    assert contents(tmp_path / "here.zarr") == contents(tmp_path / "there.zarr")


def test_a_study_built_from_objects_gives_the_same_store_as_its_file(tmp_path: Path) -> None:
    study = onset.Study.of(
        "neo-hooke",
        onset.Method(frame="eulerian", support=1.6),
        {"stretch_1": (0.7, 1.4, 12), "stretch-2": (0.7, 1.4, 10)},
        title='with "quotes" and \\',
        map={"tile": 8},
    )
    assert study.shape == (10, 12)
    study.save(tmp_path / "study.toml")
    command("map", str(tmp_path / "study.toml"), "--out", str(tmp_path / "there.zarr"))
    # Tiles are computed in parts, and the remaining tiles with `resume`.
    onset.map_into(tmp_path / "here.zarr", study, tiles=(1, 3))
    onset.map_into(tmp_path / "here.zarr", study, tiles="2/2")
    with pytest.raises(onset.InputError, match="for example 1/8"):
        onset.map_into(tmp_path / "here.zarr", study, tiles="3/2")
    dataset = onset.map(study, out=tmp_path / "here.zarr", resume=True)
    assert contents(tmp_path / "here.zarr") == contents(tmp_path / "there.zarr")
    assert dataset.verdict.dims == ("stretch-2", "stretch-1")
    assert dataset.growth_rate.attrs["units"]
    with pytest.raises(onset.InputError) as refused:
        onset.map(study, out=tmp_path / "here.zarr")
    assert refused.value.hint


def kill_when_begun(process: int, store: Path) -> None:
    """Kills a process when the first tile is done."""
    while not any((store / "verdict").glob("c/*/*")):
        time.sleep(0.002)
    os.kill(process, signal.SIGKILL)


def mapped(study: onset.Study, here: Path, workers: int, *, kill: bool) -> onset.Mapped:
    """Map whose tiles are computed by processes; `kill` ends one of them during the computation."""
    # Forked processes would not inherit the running threads.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as executor:
        if kill:
            executor.submit(os.getpid).result()
            victim = next(iter(executor._processes))
            Thread(target=kill_when_begun, args=(victim, here)).start()
        return onset.map_into(here, study, executor=executor)


@pytest.mark.parametrize("kill", [False, True])
def test_an_executor_writes_the_same_store(tmp_path: Path, kill: bool) -> None:
    study = onset.Study.of(
        "neo-hooke",
        onset.Method("updated-sph", lattice="square", support=2.6),
        {"stretch-1": (0.7, 1.5, 96), "stretch-2": (0.7, 1.5, 96)},
        map={"tile": 16},
    )
    assert pickle.loads(pickle.dumps(study)).text == study.text
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if kill else "error", RuntimeWarning)
        summary = mapped(study, tmp_path / "here.zarr", 2, kill=kill)
    assert summary.tiles_done == summary.tiles == 36
    # The tiles of the killed worker, and only these, were computed here.
    assert (0 < summary.tiles_computed < 36) if kill else summary.tiles_found == 36
    onset.map_into(tmp_path / "there.zarr", study)
    assert contents(tmp_path / "here.zarr") == contents(tmp_path / "there.zarr")


def test_a_dask_client_writes_the_same_store(tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    study = onset.Study.of("neo-hooke", None, {"stretch-1": (0.7, 1.5, 32), "stretch-2": (0.7, 1.5, 32)}, map={"tile": 16})
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        dataset = onset.map(study, out=tmp_path / "here.zarr", executor=client)
        assert dataset.sizes == {"stretch-1": 32, "stretch-2": 32, "component": 2}
    onset.map_into(tmp_path / "there.zarr", study)
    assert contents(tmp_path / "here.zarr") == contents(tmp_path / "there.zarr")


def test_the_integrator_of_a_method_sets_the_step_of_its_states() -> None:
    """The limit of RK4 on the imaginary axis is the square root of two times the limit of central differences."""
    law = onset.Material("neo-hooke", mu=1, lambda_=2)

    def step(**more: str) -> float:
        method = onset.Method("total-lagrangian-sph", lattice="square", penalty=0.3, **more)  # type: ignore[arg-type]
        return cast("float", onset.state(law, method, stretch=(1.05, 0.98)).critical_time_step)

    assert step(integrator="rk4") / step() == pytest.approx(2**0.5, rel=1e-9)
    rk4 = onset.Method("total-lagrangian-sph", lattice="square", integrator="rk4")
    set_by_method = onset.limit(law, rk4, vary="material.mu", time_step=0.5)
    given = onset.limit(law, rk4.replace(integrator="heun"), vary="material.mu", time_step=0.5, integrator="rk4")
    assert set_by_method.intervals == given.intervals
    with pytest.raises(onset.InputError, match="implicit"):
        onset.limit(law, rk4, vary="material.mu", time_step=0.5, integrator="newmark")
