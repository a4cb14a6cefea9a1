"""Compiled part of the package: settings are assignments, answers documents, and arrays buffers of doubles."""

from collections.abc import Callable, Mapping, Sequence
import os
from typing import final

from numpy import float64
from numpy.typing import NDArray

__all__ = [
    "Answer",
    "Function",
    "Law",
    "Problem",
    "Study",
    "check",
    "compare",
    "fit",
    "keys",
    "localize",
    "models",
    "modes",
    "notes",
    "read_law",
    "recommend",
    "screen",
    "tune",
    "verdict_names",
    "version",
    "zoo",
]

_Path = str | os.PathLike[str]
_Source = tuple[str, str]
_Buffer = NDArray[float64]
_Settings = Sequence[str | Function]

@final
class Answer:
    @property
    def json(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def csv(self) -> str: ...
    def files(self) -> dict[str, bytes]: ...
    def save(self, folder: _Path, size: str | None, title: str | None, bare: bool, theme: str) -> list[str]: ...
    def figure(self) -> str | None: ...

@final
class Function:
    def __new__(cls, respond: Callable[[bytes, Mapping[str, float]], bytes], parameters: list[tuple[str, float]]) -> Function: ...

@final
class Problem:
    def __new__(cls, given: _Settings, file: _Source | None, libraries: list[str]) -> Problem: ...
    @property
    def dimension(self) -> int: ...
    @property
    def branches(self) -> int: ...
    @property
    def reciprocal(self) -> list[list[float]]: ...
    def cell(self, stretch: str | None, components: str | None) -> tuple[list[list[float]], list[float], float, list[float]]: ...
    def state(self, stretch: str | None, components: str | None, certify: float | None, weak: float) -> Answer: ...
    def keeps(self, key: str, stretches: tuple[float, float] | None, range: tuple[float, float] | None) -> Answer: ...
    def limit(
        self,
        key: str,
        time_step: str,
        state: tuple[str | None, str | None],
        range: tuple[float, float] | None,
        safety: float,
        integrator: str | None,
    ) -> Answer: ...
    def waves(self, stretch: str | None, components: str | None, wave_vector: str) -> Answer: ...
    def bands(self, stretch: str | None, components: str | None, path: str | None) -> Answer: ...
    def straight_path(self, from_: str, to: str) -> Answer: ...
    def loading_path(self, mode: str, lateral: str | None, from_: float, to: float) -> Answer: ...
    def verdicts(self, components: _Buffer) -> dict[str, bytes]: ...
    def omega_squared(self, components: _Buffer, wave_vectors: _Buffer) -> bytes: ...
    def continuum_omega_squared(self, components: _Buffer, wave_vectors: _Buffer) -> bytes: ...
    def dynamical_matrices(self, components: _Buffer, wave_vectors: _Buffer) -> bytes: ...
    def simulate(
        self,
        stretch: str | None,
        components: str | None,
        cells: list[int],
        mode: str,
        wave_vector: list[float] | None,
        turns: list[int] | None,
        branch: int,
        amplitude: float,
        seed: int,
        steps: int | None,
        time: float | None,
        fraction: float | None,
        time_step: float | None,
        supercritical: bool,
        integrator: str | None,
        tolerance: float,
        out: _Path | None,
        every: int | None,
        fields: int,
        checkpoint: int | None,
        resume: bool,
        overwrite: bool,
    ) -> Answer: ...

_Fields = tuple[float, bytes, bytes | None, bytes | None, bytes | None]

def screen(
    problem: Problem,
    asked: Mapping[str, object],
    count: int,
    give: Callable[[int], _Fields],
    take: Callable[[int, float, Mapping[str, bytes]], None] | None,
    modes: Callable[[bytes], None],
) -> Answer: ...
@final
class Law:
    def __new__(cls, settings: _Settings, file: _Source | None, libraries: list[str], notes: list[str]) -> Law: ...
    def criteria(self, range: tuple[float, float], modes: list[str], incompressible: bool) -> Answer: ...
    def card(self, range: tuple[float, float], modes: list[str], incompressible: bool) -> Answer: ...
    def audit(self, strain: float, stretches: list[str], components: list[str], convention: str | None) -> Answer: ...
    def responses(self, components: _Buffer, first: int) -> bytes: ...

@final
class Study:
    def __new__(cls, file: _Source, assignments: list[str], libraries: list[str]) -> Study: ...
    @property
    def text(self) -> str: ...
    @property
    def shape(self) -> list[int]: ...
    def boundary(self, flutter: bool) -> Answer: ...
    def begin(self, out: _Path, resume: bool, overwrite: bool) -> int: ...
    def map(self, out: _Path, tiles: str | None, resume: bool, overwrite: bool) -> Answer: ...

def read_law(program: str | None, name: str, text: str, material: str | None, assignments: list[str]) -> tuple[list[str], list[str]]: ...
def compare(file: _Source, given: _Settings, libraries: list[str], variations: list[str]) -> Answer: ...
def recommend(
    file: _Source | None,
    dimension: int,
    given: _Settings,
    libraries: list[str],
    limits: tuple[float, float, float, float],
) -> Answer: ...
def tune(
    key: str,
    given: _Settings,
    file: _Source | None,
    libraries: list[str],
    range: tuple[float, float],
    stretches: tuple[float, float],
    limits: tuple[float, float, float],
) -> Answer: ...
def modes(
    given: _Settings, file: _Source | None, libraries: list[str], weak: float, cells: int, amplitude: float
) -> Answer: ...
def fit(asked: Mapping[str, object]) -> Answer: ...
def localize(assignments: list[str]) -> Answer: ...
def check(assignments: list[str]) -> None: ...
def zoo(name: str | None) -> Answer: ...
def keys() -> list[tuple[str, str, str]]: ...
def models() -> list[str]: ...
def notes() -> list[str]: ...
def verdict_names() -> list[str]: ...
def version() -> str: ...
