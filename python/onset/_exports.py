"""Modes and bands for other tools: moving particles for ASE and ParaView, and bands in the layout of phonopy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
import importlib
import re
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _onset
from ._arrays import Complexes, Floats, between, numbers, positive, received, share, whole
from ._errors import InputError, OnsetError, asks

if TYPE_CHECKING:
    from ase import Atoms
    import meshio  # type: ignore[import-untyped]
    import xarray

    from ._answers import Bands


def dataset(arrays: Mapping[str, tuple[Any, Any]], coordinates: Mapping[str, Any]) -> xarray.Dataset:
    """Returns arrays with their dimensions as a dataset."""
    try:
        import xarray
    except ImportError as error:
        raise OnsetError("a dataset requires xarray\n  hint: pip install xarray") from error
    return xarray.Dataset(dict(arrays), dict(coordinates))


#: Cells along a side of a patch: smallest and largest number tested for whole wavelengths, and the number used if none contains them.
FEWEST, SOUGHT, ELSE = 4, 24, 12
#: Tolerance for a whole number of wavelengths.
WHOLE = 1e-6
#: Largest number of particles of a patch, and of all its frames.
LARGEST, MOVING = 1_000_000, 50_000_000
#: Largest phase; radians.
LATEST = 1e9
#: Rounding error of ``omega^2``, relative to the largest entry of the matrix.
ROUNDING = 1e-12


@dataclass(frozen=True)
class Cell:
    """Cell of particles at a state, in D dimensions."""

    #: Primitive vectors of the reference lattice as rows, shape (D, D); length.
    vectors: Floats
    #: Reference positions of the particles, shape (n, D); length.
    sites: Floats
    #: Masses of the particles, shape (n,); mass.
    masses: Floats
    #: Particle spacing; length.
    spacing: float
    #: Map from reference to current positions, shape (3, 3).
    F: Floats
    #: Function that returns the dynamical matrix at a reference wave vector; 1/time^2.
    dynamical_matrix: Callable[[Floats], Complexes]

    @staticmethod
    def of(problem: _onset.Problem, stretch: str | None, components: str | None, states: Floats | None = None) -> Cell:
        """Returns the cell of a problem.

        ``stretch`` or ``components`` give the state as text, as on the command line. Dynamical matrices also need ``states``, the nine
        components of ``F`` of this state.
        """
        sites, masses, spacing, F = problem.cell(stretch, components)

        def matrix(k: Floats) -> Complexes:
            assert states is not None
            data = problem.dynamical_matrices(states, np.ascontiguousarray(k[None]))
            return received(data, (problem.branches, 2 * problem.branches)).view(np.complex128)

        vectors = 2.0 * np.pi * np.linalg.inv(np.array(problem.reciprocal)).T
        return Cell(vectors, np.array(sites), np.array(masses), spacing, np.array(F).reshape(3, 3), matrix)

    @property
    def dimension(self) -> int:
        """Number of dimensions D."""
        return len(self.vectors)

    def current(self, X: Floats) -> Floats:
        """Maps reference vectors to the current configuration, shape (..., 3)."""
        return np.asarray(X @ self.F[:, : self.dimension].T, dtype=np.float64)

    def turns(self, k: Floats) -> Floats:
        """Returns a wave vector in units of the reciprocal vectors: the number of wavelengths of a cell along each primitive vector."""
        return np.asarray(k @ self.vectors.T / (2.0 * np.pi), dtype=np.float64)

    def waves(self, matrix: Complexes, *, size: float = 0.0, without_translations: bool = False) -> tuple[Complexes, Complexes]:
        """Returns ``omega^2`` by increasing real part, and eigenvectors ``e = sqrt(m) u`` of length 1 as columns, of a dynamical matrix ``M^-1 K``.

        `size` is the magnitude of the matrices of other waves, because a zero-energy matrix contains only rounding. `without_translations` excludes
        uniform displacements, which would mix with other zero-energy modes.
        """
        root = np.sqrt(np.repeat(self.masses, self.dimension))
        weighted = root[:, None] * matrix / root
        basis = np.eye(len(root))
        if without_translations:
            uniform = np.kron(np.sqrt(self.masses)[:, None], np.eye(self.dimension))
            basis = np.linalg.qr(uniform, mode="complete")[0][:, self.dimension :]
            weighted = basis.T @ weighted @ basis
        if np.max(np.abs(weighted - weighted.conj().T), initial=0.0) <= 1e-9 * np.max(np.abs(weighted), initial=size):
            values, vectors = np.linalg.eigh(0.5 * (weighted + weighted.conj().T))
        else:
            values, vectors = np.linalg.eig(weighted)
        values = np.where(np.abs(values) <= ROUNDING * np.max(np.abs(weighted), initial=size), 0.0, values)
        order = np.argsort(values.real, kind="stable")
        return values[order].astype(np.complex128), (basis @ vectors[:, order]).astype(np.complex128)


class Mode:
    """Wave on a patch of particles, about the current configuration.

    At the phase ``p`` (``omega t``) a particle is at ``x + Re(u exp(-i p))`` with the amplitude ``u = e exp(i k.X)``. ``e`` is the eigenvector of
    ``D(k)`` for its site in the cell, ``k`` the reference wave vector and ``X`` its reference position. Growth and decay are omitted. Vectors have
    three components, zero beyond the dimensions of the lattice.
    """

    def __init__(self, cell: Cell, k: Floats, omega_squared: complex, eigenvector: Complexes, cells: int | Sequence[int] | None, amplitude: float) -> None:
        dimension = cell.dimension
        turns = cell.turns(k)
        sides = _sides(turns, cells)
        count = int(np.prod(sides, dtype=np.float64)) * len(cell.sites)
        if count > LARGEST:
            raise InputError(f"the patch has {count} particles; expected at most {LARGEST}\n  hint: give fewer `cells`")
        u = (eigenvector / np.sqrt(np.repeat(cell.masses, dimension))).reshape(-1, dimension)
        # Largest displacement of a particle in a period: the longer semi-axis of its ellipse.
        reach = np.sqrt(0.5 * (np.sum(np.abs(u) ** 2, axis=-1) + np.abs(np.sum(u**2, axis=-1))))
        most = int(np.argmax(reach))
        # The particle with the largest amplitude has its largest displacement at the phase 0.
        turned = u[most] * np.exp(1j * cell.sites[most] @ k)
        u = u * (share(amplitude, "amplitude") * cell.spacing / reach[most] * np.exp(-0.5j * np.angle(np.sum(turned**2))))
        corners = np.stack(np.meshgrid(*(np.arange(side) for side in sides), indexing="ij"), axis=-1).reshape(-1, dimension)
        X = ((corners @ cell.vectors)[:, None] + cell.sites).reshape(-1, dimension)
        embedded = np.zeros((count, 3), dtype=np.complex128)
        embedded[:, :dimension] = np.tile(u, (len(corners), 1)) * np.exp(1j * X @ k)[:, None]
        #: Reference wave vector, shape (D,); 1/length.
        self.wave_vector: Floats = k
        #: Squared frequency ``omega^2``; 1/time^2.
        self.omega_squared: complex = complex(omega_squared)
        #: Positions without the wave, in the current configuration, shape (n, 3); length.
        self.positions: Floats = cell.current(X)
        #: Reference positions, shape (n, D); length.
        self.reference_positions: Floats = X
        #: Complex amplitudes ``u``, shape (n, 3); length.
        self.displacements: Complexes = embedded
        #: Site of each particle in its cell, shape (n,).
        self.sites: NDArray[np.intp] = np.tile(np.arange(len(cell.sites)), len(corners))
        #: Masses, shape (n,); mass.
        self.masses: Floats = np.tile(cell.masses, len(corners))
        #: Edges of the patch as rows, zero beyond the dimensions of the lattice, shape (3, 3); length.
        self.edges: Floats = np.zeros((3, 3))
        self.edges[:dimension] = cell.current(np.array(sides)[:, None] * cell.vectors)
        #: Whether the wave is periodic along each edge: the edge contains whole wavelengths, shape (3,).
        self.periodic: NDArray[np.bool_] = np.zeros(3, dtype=np.bool_)
        self.periodic[:dimension] = _is_whole(np.array(sides) * turns)

    def __repr__(self) -> str:
        return f"<onset.Mode of {len(self.positions)} particles, k = {self.wave_vector.tolist()}, omega^2 = {self.omega_squared:.6g}>"

    @asks
    def at(self, phase: float) -> Floats:
        """Returns the displacements ``Re(u exp(-i p))`` at a phase in radians, shape (n, 3); length."""
        turned = np.exp(-1j * between(phase, "phase", -np.inf, LATEST, f"a finite number of radians up to {LATEST:g}"))
        return np.asarray((self.displacements * turned).real, dtype=np.float64)

    @asks
    def to_ase(self, *, frames: int = 24, unit: float = 1.0, symbol: str = "X") -> list[Atoms]:
        """Returns one period as a list of ``ase.Atoms``, for ``ase.io.write("mode.xyz", frames)`` and ``ase.visualize.view(frames)``.

        Each frame has displaced positions, the displacements as ``atoms.arrays["displacement"]`` of shape (n, 3), the sites in the cell as tags, and
        the edges of the patch as cell. Boundaries are periodic along edges that contain whole wavelengths. ``atoms.info`` has ``phase``, the
        reference ``wave_vector``, ``omega`` (its real part) and ``growth_rate``.

        Parameters
        ----------
        frames
            Number of frames of the period.
        unit
            Unit of length of the result; length. ASE interprets lengths as angstroms, and its files have about eight decimals. ``unit=1e-3`` converts
            an answer in meters to millimeters.
        symbol
            Chemical symbol of all particles; the default denotes no element.

        Raises
        ------
        OnsetError
            If ASE is not installed.
        InputError
            If an argument is out of range.
        """
        ase = _package("ase")
        count, length = whole(frames, "frames", 1, 10_000), positive(unit, "unit")
        if count * len(self.positions) > MOVING:
            raise InputError(f"{count} frames of {len(self.positions)} particles are too many; expected at most {MOVING} positions in all frames")
        reach = float(np.max(np.abs(self.edges)))
        if not 1e-300 < reach / length < 1e300:
            raise InputError(f"unit is {length!r}, and the patch is {reach!r} long; expected a unit in which the length is finite and not zero")
        if symbol_of(symbol) not in importlib.import_module("ase.data").atomic_numbers:
            raise InputError(f"symbol is {symbol!r}; expected the symbol of a chemical element, or X")
        omega = np.sqrt(self.omega_squared)
        known = {"wave_vector": self.wave_vector * length, "omega": abs(omega.real), "growth_rate": abs(omega.imag)}
        made: list[Atoms] = []
        for phase in 2.0 * np.pi * np.arange(count) / count:
            displacement = self.at(phase) / length
            atoms = ase.Atoms(
                symbols=[symbol] * len(self.positions),
                positions=self.positions / length + displacement,
                cell=self.edges / length,
                pbc=self.periodic,
                tags=self.sites,
                masses=self.masses,
                info=known | {"phase": float(phase)},
            )
            atoms.set_array("displacement", displacement)
            made.append(atoms)
        return made

    @asks
    def to_meshio(self) -> meshio.Mesh:
        """Returns the patch as a ``meshio.Mesh`` of vertices, for ParaView: ``mode.to_meshio().write("mode.vtu")``.

        Points are positions without the wave. Point data are ``displacement`` at the phase 0 and ``quarter`` a quarter of a period later, both of
        shape (n, 3) in the unit of length of the answer, and the ``site`` in the cell. A particle is at ``points + displacement cos p + quarter sin
        p``.

        Raises
        ------
        OnsetError
            If meshio is not installed.
        """
        data = {"displacement": self.at(0.0), "quarter": self.at(0.5 * np.pi), "site": self.sites}
        return _package("meshio").Mesh(self.positions, [("vertex", np.arange(len(self.positions))[:, None])], point_data=data)


def symbol_of(symbol: object) -> str:
    """Checks the chemical symbol of particles."""
    if not isinstance(symbol, str):
        raise TypeError(f"symbol is {type(symbol).__name__}; expected a string")
    if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", symbol):
        raise InputError(f"symbol is {symbol!r}; expected a capital with letters and digits, such as Cu or X")
    return symbol


def _package(name: str) -> Any:
    """Imports an optional package."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise OnsetError(f"this function requires {name}\n  hint: pip install {name}") from error


def _is_whole(turns: Floats) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return np.asarray(np.abs(turns - np.round(turns)) < WHOLE)


def _sides(turns: Floats, cells: int | Sequence[int] | None) -> list[int]:
    """Returns the number of cells along each primitive vector: the given numbers, or the smallest that contain whole wavelengths."""
    if cells is not None:
        given = np.atleast_1d(numbers(cells, "cells")).ravel()
        if given.size not in (1, turns.size):
            raise InputError(f"cells has {given.size} numbers; expected one, or one for each of {turns.size} dimensions")
        return [whole(side, "cells", 1, LARGEST) for side in np.broadcast_to(given, turns.shape)]
    sought = np.arange(FEWEST, SOUGHT + 1)
    fitting = [sought[_is_whole(sought * own)] for own in turns]
    return [int(fit[0]) if fit.size else ELSE for fit in fitting]


def band_yaml(answer: Bands, cell: Cell, symbol: str) -> str:
    """Returns bands in the layout of phonopy's ``band.yaml``, as described under `Bands.to_yaml`."""
    # Flutter has neither a real nor an imaginary frequency.
    flutters = [n for n, heights in enumerate(answer._fields["heights"]) if heights["flutter"] is not None]
    if flutters:
        raise InputError(
            f"at {len(flutters)} of {len(answer.lengths)} wave vectors omega^2 is complex (flutter), and the layout of phonopy has real omega^2 only\n"
            "  hint: use omega_squared and dynamical_matrices of the answer"
        )
    dimension = cell.dimension
    # The spacing completes the lattice in directions without waves.
    lattice = np.eye(3) * cell.spacing
    lattice[:dimension] = cell.current(cell.vectors)
    reciprocal = np.linalg.inv(lattice).T
    corners = answer._fields["corners"]
    turns = np.array([cell.turns(np.array(corner["wave_vector"])) for corner in corners])
    spatial = turns @ reciprocal[:dimension]
    along = answer.corners
    jumps = np.diff(along) == 0.0
    steps = np.where(jumps, 0.0, np.linalg.norm(np.diff(spatial, axis=0), axis=1))
    distances = np.interp(answer.lengths, along, np.concatenate([[0.0], np.cumsum(steps)]))
    ends = np.searchsorted(answer.lengths, along) + np.concatenate([[False], jumps])
    # Each segment contains both of its ends.
    legs = [(n, range(int(ends[n]), int(ends[n + 1]) + 1)) for n in range(len(along) - 1) if not jumps[n]]

    def row(numbers: Floats | Sequence[float]) -> str:
        return f"[ {', '.join(repr(float(x)) for x in numbers)} ]"

    def quoted(name: str) -> str:
        return "'" + name.replace("'", "''") + "'"

    lines = [f"nqpoint: {sum(len(leg) for _, leg in legs)}", f"npath: {len(legs)}", "segment_nqpoint:"]
    lines += [f"- {len(leg)}" for _, leg in legs]
    lines += ["labels:", *(f"- [ {quoted(answer.labels[n])}, {quoted(answer.labels[n + 1])} ]" for n, _ in legs)]
    lines += ["reciprocal_lattice:", *(f"- {row(vector)} # {name}*" for vector, name in zip(reciprocal, "abc", strict=True))]
    lines += [f"natom: {len(cell.masses)}", "lattice:", *(f"- {row(vector)} # {name}" for vector, name in zip(lattice, "abc", strict=True))]
    lines.append("points:")
    for n, (site, mass) in enumerate(zip(cell.sites, cell.masses, strict=True)):
        coordinates = np.zeros(3)
        coordinates[:dimension] = site @ np.linalg.inv(cell.vectors)
        lines += [f"- symbol: {quoted(symbol_of(symbol))} # {n + 1}", f"  coordinates: {row(coordinates)}", f"  mass: {float(mass)!r}"]
    lines += ["", "phonon:"]
    matrices, k = answer.dynamical_matrices, answer.k
    # Corners between segments are listed in both.
    size = float(np.max(np.abs(matrices)))
    blocks = [_point(cell, k[n], cell.waves(matrices[n], size=size), distances[n], row) for n in range(len(k))]
    for _, leg in legs:
        for n in leg:
            lines += blocks[n]
    return "\n".join(lines) + "\n"


def _point(cell: Cell, k: Floats, waves: tuple[Complexes, Complexes], distance: float, row: Callable[[Sequence[float]], str]) -> list[str]:
    """Returns the lines of a wave vector with its bands."""
    values, vectors = waves
    missing = 3 - cell.dimension
    lines = [f"- q-position: {row([*cell.turns(k), *[0.0] * missing])}", f"  distance: {float(distance)!r}", "  band:"]
    for branch, (value, vector) in enumerate(zip(values.real, vectors.T, strict=True)):
        frequency = float(np.copysign(np.sqrt(abs(value)), value) / (2.0 * np.pi))
        lines += [f"  - # {branch + 1}", f"    frequency: {frequency!r}", "    eigenvector:"]
        for site, own in enumerate(vector.reshape(-1, cell.dimension)):
            lines.append(f"    - # atom {site + 1}")
            lines += [f"      - {row([e.real, e.imag])}" for e in [*own, *[0j] * missing]]
    return [*lines, ""]
