"""Screening of runs given as arrays."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import onset

RUNS = Path(__file__).parents[2] / "runs"
LAW = onset.Material("hypoelastic-jaumann", young=1, poisson=0.3, n=1)
SPH = onset.Method(
    "updated-sph",
    lattice="square",
    kernel="cubic-spline",
    support=2.6,
    momentum="symmetric",
    density_evolution="continuity",
    corrected=False,
    viscosity=0.06,
    viscosity_switch="averaged",
)


class Lazy:
    """Frames that are read one at a time."""

    def __init__(self, array: Any) -> None:
        self.array = array
        self.read: list[int] = []

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, frame: int) -> Any:
        self.read.append(frame)
        return self.array[frame]


def tension() -> dict[str, Any]:
    with np.load(RUNS / "tension.npz") as run:
        return {name: run[name] for name in run}


def screened(run: dict[str, Any], **more: Any) -> onset.Screening:
    given = {"held": run["held"], "velocity": run["velocity"], "stress": run["stress"]}
    scheme = {"time_step": 0.02, "stepping": "late-acceleration"}
    return onset.screen(run["position"], run["reference"], run["time"], LAW, SPH, **{**given, **scheme, **more})


def test_arrays_and_lazy_frames_give_the_same_answer() -> None:
    run = tension()
    # The last two frames have the same time.
    run = {name: value[:20] if name in ("position", "velocity", "stress", "time") else value for name, value in run.items()}
    answer = screened(run)
    assert (answer.cause, answer.mechanism) == ("numerical", "tensile")
    assert 19 < answer.expected < 26
    assert "First cause: the discretization (tensile instability)" in str(answer)
    lazy = {name: Lazy(run[name]) for name in ("position", "velocity", "stress")}
    other = screened({**run, **lazy}, fields=True)
    assert other.json == answer.json
    assert sorted(set(lazy["position"].read)) == list(range(20))
    fields = other.fields()
    assert fields["noise"].sizes == {"time": 20, "node": 400}
    moments = answer.to_xarray()
    inside = fields["noise"].where(fields["noise"].max("time") < np.inf).max("node")
    assert np.all(inside >= moments["observed"] - 1e-15)
    with pytest.raises(onset.OnsetError, match="fields=True"):
        answer.fields()


def plate(side: int = 10) -> tuple[Any, Any]:
    X = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2).astype(float)
    return X, np.stack([X * [1 + 0.001 * n, 1] for n in range(6)])


def test_a_step_above_the_limit_of_the_body_is_reported() -> None:
    X, x = plate()
    method = onset.Method("total-lagrangian-sph", support=2.01, penalty=0.3)
    answer = onset.screen(x, X, None, None, method, time_step=3.0)
    assert answer.cause == "none"
    assert float(answer.to_xarray()["step_ratio"].min()) > 1


def test_modes_are_returned_as_arrays() -> None:
    X, x = plate()
    held = X[:, 0] == 0
    method = onset.Method("total-lagrangian-sph", support=2.01, penalty=0.3)
    answer = onset.screen(x, X, None, None, method, held=held, actual=1.2)
    assert (answer["actual"]["time"], answer["actual"]["frame"], answer["actual"]["unknowns"]) == (1, 1, 180)
    modes = answer.modes()
    assert modes["displacement"].shape == (6, 100, 3)
    assert np.all(modes["displacement"].values[:, held] == 0)
    length = np.linalg.norm(modes["displacement"], axis=-1).max(-1)
    assert np.allclose(length, 1)
    assert np.all(np.diff(modes["omega_squared"]) >= 0)
    assert float(modes["omega_squared"][0]) > 0
    assert list(modes["kind"][:2]) == ["structural"] * 2
    with pytest.raises(onset.OnsetError, match="there are no modes"):
        onset.screen(x, X, None, None, method).modes()


def test_errors_name_the_argument() -> None:
    X, x = plate()
    with pytest.raises(onset.InputError, match="particle 0 has no finite position below 1e100, at t = 0"):
        broken = x.copy()
        broken[0, 0, 0] = np.nan
        onset.screen(broken, X)
    for given, message in [
        ({"x": x[:, :, :1]}, r"x\[0\] has the shape \(100, 1\)"),
        ({"X": X[:50]}, r"x\[0\] has the shape \(100, 2\); expected \(50, 2\)"),
        ({"time": [0, 1]}, "time has the shape"),
        ({"time": [0, 2, 1, 3, 4, 5]}, r"time\[2\] is 1.0, before 2.0; expected"),
        ({"X": 3 * X}, "the spacing of the particles is 3"),
        ({"held": [True]}, "held has the shape"),
        ({"stress": np.zeros((6, 100, 5))}, r"stress\[0\] has the shape"),
        ({"elements": [[0, 1, 100]]}, "elements refers to missing particles"),
        ({"stepping": "euler"}, "expected one of velocity-verlet"),
        ({"region": ([0, 0], [-1])}, "is not a box"),
        ({"actual": 6}, "the frames are from t = 0 to 5"),
        ({"x": x[:1]}, "growth needs at least two"),
        ({"X": np.zeros((0, 2))}, "X has no particles"),
        ({"x": np.zeros((3, 0, 2)), "X": None}, r"x\[0\] has no particles"),
        ({"velocity": []}, r"velocity has 0 frame\(s\); expected 6"),
        ({"F": np.array(1.0)}, "F has no frames"),
        ({"F": {"a": 1}}, "F has no frames"),
        ({"X": np.full((100, 2), np.nan)}, "X has values that are not finite and below 1e100"),
        ({"region": ([90, 90], [91, 91])}, "no particle is in the box 90,90:91,91 of region"),
        ({"volumes": np.full(100, np.nan)}, "volumes has values that are not finite"),
        ({"volumes": np.zeros(100)}, "volumes has values that are not positive"),
        ({"held": np.ma.array(np.zeros(100), mask=np.arange(100) == 3)}, "held has 1 masked values"),
    ]:
        with pytest.raises(onset.InputError, match=message):
            onset.screen(**{"x": x, "X": X, **given})


def test_damaged_records_are_skipped_as_in_files() -> None:
    X, x = plate()
    for damage, note, frames in [
        (lambda x: x[3].__setitem__((0, 0), np.nan), "particle 0 has no finite position below 1e100, at t = 3: this and all later frames are skipped", 3),
        (lambda x: x[4].fill(0), r"more than half of the particles are at the same position, \(0, 0, 0\), at t = 4: this and all", 4),
        (lambda x: x[2, 57].fill(0), "particle 57 moves .* spacings between the frames t = 1 and t = 2 while its neighbors stay together", 5),
    ]:
        damaged = x.copy()
        damage(damaged)
        answer = onset.screen(damaged, X, None, "neo-hooke", onset.Method("total-lagrangian-sph", support=2.01, penalty=0.3))
        assert any(re.search(note, own) for own in answer["notes"]), answer["notes"]
        assert answer.to_xarray().sizes["time"] == frames
    # Gradients that are not numbers are noted, as in files.
    answer = onset.screen(x, X, F=np.full((6, 100, 2, 2), np.nan))
    assert any("gradients in the files are not numbers" in note for note in answer["notes"])


def test_a_frame_that_repeats_a_time_is_skipped_with_a_note() -> None:
    X, x = plate()
    for times, frames, note in [
        ([0, 1, 1, 2, 3, 4], [0, 1, 3, 4, 5], "a frame that repeats the time of another frame is skipped"),
        ([0, 1, 1, 1, 3, 3], [0, 1, 4], "3 frames that repeat the time of another frame are skipped"),
    ]:
        lazy = Lazy(x)
        answer = onset.screen(lazy, X, times)
        assert lazy.read[-len(frames) :] == frames
        assert answer["notes"][0] == note
        assert answer.to_xarray()["time"].values.tolist() == sorted({float(time) for time in times})


def test_exceptions_of_frames_are_raised_unchanged() -> None:
    X, x = plate()

    class Failing(Lazy):
        def __getitem__(self, frame: int) -> Any:
            if frame == 3:
                raise OSError("the disk is gone")
            return super().__getitem__(frame)

    with pytest.raises(OSError, match="the disk is gone"):
        onset.screen(Failing(x), X)


def test_frames_in_a_memory_view_are_read() -> None:
    X, x = plate()
    view = memoryview(np.ascontiguousarray(x))
    assert onset.screen(view, X).json == onset.screen(x, X).json
