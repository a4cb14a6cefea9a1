"""Answers as objects with named attributes: the documents that the command prints with ``--json``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
import html
import importlib
import io
import json
import os
from typing import TYPE_CHECKING, Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from . import _onset
from ._arrays import Complexes, Floats, place, received, whole, write
from ._errors import InputError, OnsetError, asks
from ._exports import Cell, Mode, band_yaml
from ._settings import Material, law_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase
    import pandas
    import xarray


def _frames() -> Any:
    """Returns the module pandas."""
    try:
        return importlib.import_module("pandas")
    except ImportError as error:
        raise OnsetError("a table requires pandas\n  hint: pip install pandas") from error


class Record(Mapping[str, Any]):
    """Part of an answer, immutable: ``part.growth_rate`` is ``part["growth_rate"]``.

    Lists of numbers are arrays, complex numbers are ``complex``, and lists of parts are tuples. Missing numbers are NaN in arrays, and ``None``
    otherwise. Names with hyphens or dots become attributes with underscores; names reserved by Python get an underscore at the end
    (``crossing.from_``). An unknown name is an `AttributeError`, which lists the names of the part.
    """

    __slots__ = ("_fields",)
    _fields: Mapping[str, Any]

    def __init__(self, fields: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_fields", fields)

    def __getitem__(self, name: str) -> Any:
        return _value(self._fields[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __getattr__(self, name: str) -> Any:
        # Special names, which notebooks and `copy` request, are not fields of the document.
        if name.startswith("_"):
            raise AttributeError(name)
        fields = self._fields
        if name in fields:
            return _value(fields[name])
        for own, value in fields.items():
            if _attribute(own) == name.rstrip("_"):
                return _value(value)
        raise AttributeError(f"this answer has no {name!r}; it has {', '.join(_attribute(own) for own in fields)}")

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("answers are immutable")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(_attribute(name) for name in self._fields)]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other._fields == self._fields

    def __hash__(self) -> int:
        return hash(json.dumps(self._fields, sort_keys=True))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(_attribute(name) for name in self._fields)})"

    def __reduce__(self) -> tuple[type[Record], tuple[Mapping[str, Any]]]:
        return Record, (self._fields,)

    def to_dict(self) -> dict[str, Any]:
        """Returns the part as plain dictionaries, lists and numbers, as in the document."""
        return cast("dict[str, Any]", json.loads(json.dumps(self._fields)))


def _attribute(name: str) -> str:
    return name.replace("-", "_").replace(".", "_")


def _is_complex(value: object) -> bool:
    return isinstance(value, dict) and value.keys() == {"re", "im"}


def _value(value: Any) -> Any:
    """Converts a value of a document to an array, a complex number or a part."""
    if isinstance(value, dict):
        return complex(value["re"], value["im"]) if _is_complex(value) else Record(value)
    if isinstance(value, list):
        array = _array(value)
        return tuple(_value(item) for item in value) if array is None else array
    return value


def _array(items: list[Any]) -> Any:
    """Returns an array if all items are numbers, or lists of numbers of equal length; otherwise ``None``."""
    flat: list[Any] = items
    shape = [len(items)]
    while flat and all(isinstance(item, list) for item in flat):
        lengths = {len(item) for item in flat}
        if len(lengths) != 1:
            return None
        shape.append(lengths.pop())
        flat = [inner for item in flat for inner in item]
    is_number = [isinstance(item, (int, float)) and not isinstance(item, bool) for item in flat]
    if any(is_number) and all(known or item is None for known, item in zip(is_number, flat, strict=True)):
        return np.array([np.nan if item is None else item for item in flat]).reshape(shape)
    if flat and all(_is_complex(item) for item in flat):
        return np.array([complex(item["re"], item["im"]) for item in flat]).reshape(shape)
    return None


class Answer(Record):
    """Answer of a command.

    ``str(answer)`` is the text that the command prints, ``answer.json`` the document of ``--json``, identical in every byte, and ``answer.csv`` the
    table. ``answer.save(folder)`` writes the files of ``--out``.
    """

    __slots__ = ("_answer", "_files")
    _answer: _onset.Answer
    _files: dict[str, bytes] | None

    def __init__(self, answer: _onset.Answer) -> None:
        if not isinstance(answer, _onset.Answer):
            raise TypeError(
                f"{type(self).__name__} is returned by functions such as onset.state(...) and is not called; "
                "a deformation is an argument of the function, stretch=(1.2, 0.9) or F=[[1, 0.1], [0, 1]]"
            )
        super().__init__(json.loads(answer.json))
        object.__setattr__(self, "_answer", answer)
        object.__setattr__(self, "_files", None)

    def __copy__(self) -> Answer:
        return self

    def __deepcopy__(self, _: object) -> Answer:
        return self

    @property
    def json(self) -> str:
        """Document that the command prints with ``--json``."""
        return self._answer.json

    @property
    def csv(self) -> str:
        """Table that the command prints with ``--format csv``."""
        return self._answer.csv

    @asks
    def to_frame(self) -> pandas.DataFrame:
        """Table of the answer as a data frame: the rows and columns of ``csv``, with the units in the names if settings have units.

        Returns
        -------
        pandas.DataFrame
            One row for each state, loading, method, mode or wave. ``attrs`` holds the command-line text of the answer as ``text``.
            ``to_frame().to_parquet(path)`` writes a Parquet file, and ``pyarrow.Table.from_pandas`` makes an Arrow table.

        Raises
        ------
        OnsetError
            If pandas is not installed.

        Examples
        --------
        >>> onset.state("neo-hooke", stretch=(1.1, 1)).to_frame().loc[0, "verdict"]
        'stable'
        """
        return self._frame(self.csv)

    def _frame(self, table: str) -> pandas.DataFrame:
        """Data frame of a table of the answer."""
        library = _frames()
        # Numbers are read exactly by default since pandas 3.1, which deprecates the option.
        is_exact = tuple(int(part) for part in library.__version__.split(".")[:2]) >= (3, 1)
        options: Any = {} if is_exact else {"float_precision": "round_trip"}
        frame = library.read_csv(io.StringIO(table), keep_default_na=False, na_values=[""], **options)
        frame.attrs["text"] = self._answer.text
        return cast("pandas.DataFrame", frame)

    def __str__(self) -> str:
        return self._answer.text

    def __repr__(self) -> str:
        return f"<onset.{type(self).__name__}: {self._answer.text.partition(chr(10))[0]}>"

    @asks
    def files(self) -> dict[str, bytes]:
        """Returns the contents of the files that the command writes with ``--out``, by name. They are computed once."""
        if self._files is None:
            object.__setattr__(self, "_files", self._answer.files())
        return dict(self._files or {})

    @asks
    def save(
        self,
        folder: str | os.PathLike[str],
        *,
        size: str | None = None,
        title: str | None = None,
        bare: bool = False,
        theme: Literal["light", "dark"] = "light",
    ) -> list[str]:
        """Writes the files of ``--out`` into a folder, with the figure as SVG, PNG and PDF, and returns their paths.

        Parameters
        ----------
        folder
            Folder, which is created if it is missing.
        size
            Width of the figure with a unit, ``"84mm"``, with letters of 8 pt; or width and height of a panel in pixels, ``"420,315"``.
        title
            Title of the figure.
        bare
            Omit title and caption from the figure; they are written into a separate text file.
        theme
            Colors of background, axes and words.

        Raises
        ------
        InputError
            If an argument is out of range.
        MachineError
            If the files cannot be written.
        """
        return self._answer.save(place(folder, "folder"), size, title, bare, theme)

    @asks
    def figure(self) -> dict[str, Any]:
        """Returns the description of the figure: ``title``, ``caption``, ``legend`` and ``panels``, each with two axes and layers of numbers.

        Raises
        ------
        OnsetError
            If the answer has no figure.
        """
        told = self._answer.figure()
        if told is None:
            raise OnsetError("this answer has no figure")
        return cast("dict[str, Any]", json.loads(told))

    def _picture(self) -> str | None:
        """Returns the figure as SVG, or ``None`` if the answer has no figure."""
        try:
            files = self.files()
        except Exception:
            return None
        pictures = [data for name, data in files.items() if name.endswith(".svg")]
        return pictures[0].decode() if pictures else None

    def _repr_html_(self) -> str:
        first, _, rest = self._answer.text.partition("\n")
        picture = self._picture() or ""
        return (
            f"<div><p><strong>{html.escape(first)}</strong></p>{picture}"
            f"<details{'' if picture else ' open'}><summary>full text</summary><pre>{html.escape(rest.strip())}</pre></details></div>"
        )

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws the figure of the command with matplotlib, in its current style, and returns the axes of the first panel.

        Parameters
        ----------
        ax
            Axes, one for each panel.
        fig
            Figure or subfigure in which the panels are laid out, instead of `ax`; by default a new figure.

        Raises
        ------
        OnsetError
            If the answer has no figure, or matplotlib is not installed.
        InputError
            If the number of axes is not the number of panels.
        """
        from . import _figure

        return _figure.draw(self.figure(), ax, fig)


class _Moving(Answer):
    """Answer with waves, which can be exported as moving particles."""

    __slots__ = ("_cell",)
    #: Cell of particles that the waves displace.
    _cell: Callable[[], Cell]

    def _of(self, cell: Callable[[], Cell]) -> Self:
        object.__setattr__(self, "_cell", cell)
        return self

    def _mode(self, k: Floats, matrix: Complexes, branch: int, cells: int | Sequence[int] | None, amplitude: float) -> Mode:
        """Returns a branch of a dynamical matrix, counted from 1."""
        cell = self._cell()
        values, vectors = cell.waves(matrix)
        own = whole(branch, "branch", 1, len(values)) - 1
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)


class State(_Moving):
    """Verdict on a state with its evidence, in the parts ``material``, ``material_3d`` (not in plane stress) and ``discretization``."""

    __slots__ = ("_spectrum",)
    _spectrum: Callable[[Floats], tuple[Complexes, Floats]]

    @property
    def verdict(self) -> str:
        """Verdict: ``stable``, ``physical``, ``numerical``, ``zero-energy`` or ``suppressed``."""
        return cast(str, self._fields["verdict"])

    @property
    def mechanism(self) -> str | None:
        """Mechanism of a numerical instability: ``tensile``, ``compressive``, ``flutter`` or ``long-wave``; ``None`` for other verdicts."""
        return cast("str | None", self._fields["mechanism"])

    @property
    def sentence(self) -> str:
        """Verdict as an English sentence."""
        return cast(str, self._fields["sentence"])

    @property
    def stable(self) -> bool:
        """Whether no wave of the particles grows: all ``omega^2`` are real and nonnegative."""
        return cast(bool, self._fields["discretization"]["stable"])

    @property
    def growth_rate(self) -> float:
        """Growth rate of the fastest growing wave, ``max |Im omega|``, 0 if no wave grows; 1/time."""
        return cast(float, self._fields["discretization"]["growth_rate"])

    @property
    def wave_vector(self) -> Floats:
        """Reference wave vector of the fastest growing wave, or of the softest wave of a stable state, shape (D,); 1/length."""
        return np.array(self._fields["discretization"]["wave_vector"], dtype=np.float64)

    @property
    def critical_time_step(self) -> float | None:
        """Critical time step of the infinite lattice, ``2/omega_max`` by default; time. ``None`` if no wave oscillates, and for implicit integrators.

        For a transfer of material points it is the largest stable step of the transfer. Stiffer increments of the state, which unload it or are faster than
        its relaxation, limit the step too. Free faces and distorted cells need a smaller step.
        """
        return cast("float | None", self._fields["discretization"]["critical_time_step"])

    @property
    def finite_bodies(self) -> dict[str, Any] | None:
        """Stable ``time_step`` for finite bodies of the lattice, whether it is ``proved``, and its ``ground``; ``None`` if no step is known."""
        return cast("dict[str, Any] | None", self._fields["discretization"]["finite_bodies"])

    @property
    def unloading(self) -> dict[str, Any] | None:
        """Verdict, growth rate and critical time step for disturbances that unload a state that flows; ``None`` for other states."""
        return cast("dict[str, Any] | None", self._fields.get("unloading"))

    @property
    def relaxation(self) -> dict[str, Any] | None:
        """The state of a viscoelastic law: ``fast`` before it relaxes, and the growth rate with its wave while it relaxes.

        None unless the material has a Prony series and states are reached slowly.
        """
        return cast("dict[str, Any] | None", self._fields.get("relaxation"))

    @property
    def cauchy(self) -> Floats:
        """Cauchy stress ``P F^T / det F``, shape (3, 3); stress."""
        return np.array(self._fields["material"]["cauchy"], dtype=np.float64)

    @property
    def minimum_acoustic_eigenvalue(self) -> float:
        """Smallest eigenvalue of the acoustic tensor ``Q_ik = A_iJkL N_J N_L`` over all directions ``N`` in the dimensions of the lattice; stress."""
        return cast(float, self._fields["material"]["minimum_acoustic_eigenvalue"])

    @property
    def elliptic(self) -> bool:
        """Whether the material is strongly elliptic for waves in the dimensions of the lattice."""
        return cast(bool, self._fields["material"]["elliptic"])

    @asks
    def mode(self, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """Returns the fastest growing wave, or the softest wave of a stable state, on a patch of particles.

        The parameters are described under `Waves.mode`.

        Raises
        ------
        InputError
            If the wave is the limit of long waves, which has no wavelength.
        """
        cell, k = self._cell(), self.wave_vector
        values, vectors = cell.waves(cell.dynamical_matrix(k))
        growth = np.abs(np.sqrt(values).imag)
        own = 0 if self.stable else int(np.argmax(growth))
        if not np.any(k) and (self.stable or growth[own] < 1e-6 * self._fields["discretization"]["maximum_omega"]):
            raise InputError(
                "the mode is the limit of long waves, which has no wavelength\n"
                "  hint: onset.waves(material, method, wave_vector=..., stretch=...).mode() is the mode of a wave vector"
            )
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)

    def _with_spectrum(self, spectrum: Callable[[Floats], tuple[Complexes, Floats]]) -> State:
        object.__setattr__(self, "_spectrum", spectrum)
        return self

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws ``omega^2`` (1/time^2) of particles and continuum along the wave vector of the softest wave, up to twice its length."""
        from . import _plots
        from ._figure import axes

        return _plots.along_wave(self.wave_vector, self._spectrum, axes(ax, fig))


class Waves(_Moving):
    """Waves of a state with one wave vector."""

    __slots__ = ()

    @asks
    def mode(self, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """Returns a wave on a patch of particles, for export: see `Mode`.

        Parameters
        ----------
        branch
            Number of the wave, counted from 1 by increasing real part of ``omega^2``.
        cells
            Number of cells along the primitive vectors, one number or D; by default the smallest number from 4 to 24 that contains whole wavelengths,
            or 12.
        amplitude
            Largest displacement in particle spacings, above 0 and at most 1.

        Raises
        ------
        InputError
            If an argument is out of range.
        """
        return self._mode(np.array(self._fields["wave_vector"], dtype=np.float64), self.dynamical_matrix, branch, cells, amplitude)

    @property
    def omega_squared(self) -> Complexes:
        """Squared frequencies of the particles, ``omega^2 g = D(k) g``, by increasing real part, shape (branches,); 1/time^2."""
        return np.asarray(_value(self._fields["omega_squared"]), dtype=np.complex128)

    @property
    def continuum_omega_squared(self) -> Floats:
        """Squared frequencies of the continuum, ``rho_0 omega^2 g = Q(k) g``, shape (D,); 1/time^2."""
        return np.array(self._fields["continuum_omega_squared"], dtype=np.float64)

    @property
    def dynamical_matrix(self) -> Complexes:
        """Dynamical matrix ``D(k)``, shape (branches, branches); 1/time^2."""
        return np.asarray(_value(self._fields["dynamical_matrix"]), dtype=np.complex128)

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws ``omega^2`` (1/time^2) of particles and continuum for comparison."""
        from . import _plots
        from ._figure import axes

        return _plots.levels(self.omega_squared, self.continuum_omega_squared, axes(ax, fig))


class Bands(_Moving):
    """Dispersion relation at ``n`` samples along a path through the zone, with the critical wave ``critical`` and the ``density_of_states``."""

    __slots__ = ()

    @asks
    def mode(self, at: int | str, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """Returns a wave of the path on a patch of particles.

        Parameters
        ----------
        at
            Index of a sample, or the name of a corner of the path; the first corner with this name is used.
        branch, cells, amplitude
            Parameters of `Waves.mode`.

        Raises
        ------
        InputError
            If the path has no such sample or corner, or an argument is out of range.
        """
        if isinstance(at, str):
            at = {"G": "Γ", "Gamma": "Γ"}.get(at, at.replace("'", "′"))
            if at not in self.labels:
                raise InputError(f"the path has no corner {at!r}\n  hint: it has {', '.join(self.labels)}")
            index = int(np.searchsorted(self.lengths, self.corners[self.labels.index(at)]))
        else:
            index = whole(at, "at", -len(self.lengths), len(self.lengths) - 1)
        return self._mode(self.k[index], self.dynamical_matrices[index], branch, cells, amplitude)

    @asks
    def to_yaml(self, path: str | os.PathLike[str] | None = None, *, symbol: str = "X") -> str:
        """Returns the bands in the layout of phonopy's ``band.yaml``, and writes them into a file if `path` is given.

        - ``frequency`` is ``sign(omega^2) sqrt(|omega^2|) / (2 pi)`` in 1/time. A negative frequency denotes a wave that grows without oscillation;
          its magnitude is the growth rate divided by ``2 pi``.
        - ``eigenvector`` has the real and imaginary parts of ``e = sqrt(m) u`` of length 1: three for each particle of the cell, zero beyond the
          dimensions of the lattice. Particles move by ``Re(e exp(i k.X)) / sqrt(m)``. The number of bands is the number of branches.
        - ``lattice``, ``reciprocal_lattice`` (without ``2 pi``) and ``distance`` refer to the current configuration. Each direction without waves has
          a vector with the length of the particle spacing.
        - ``q-position`` is in units of the reciprocal vectors, in which reference and current configuration agree. Each segment contains both of its
          ends.
        - ``mass`` is in 2D per unit thickness, in 1D per unit cross-section. All particles have one chemical `symbol`; the default denotes no element.

        Raises
        ------
        InputError
            If an ``omega^2`` is complex beyond rounding (flutter), which the layout cannot represent.
        MachineError
            If the file cannot be written.
        """
        text = band_yaml(self, self._cell(), symbol)
        if path is not None:
            write(text, path, "path")
        return text

    @property
    def k(self) -> Floats:
        """Reference wave vectors of the samples, shape (n, D); 1/length."""
        return np.array([sample["wave_vector"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def lengths(self) -> Floats:
        """Arc length of each sample along the path, shape (n,); 1/length."""
        return np.array(self._fields["lengths"], dtype=np.float64)

    @property
    def omega_squared(self) -> Complexes:
        """Squared frequencies of the particles by increasing real part, shape (n, branches); 1/time^2."""
        return np.asarray(_value([sample["omega_squared"] for sample in self._fields["samples"]]), dtype=np.complex128)

    @property
    def continuum_omega_squared(self) -> Floats:
        """Squared frequencies of the continuum, shape (n, D); 1/time^2."""
        return np.array([sample["continuum_omega_squared"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def dynamical_matrices(self) -> Complexes:
        """Dynamical matrices ``D(k)`` of the samples, shape (n, branches, branches); 1/time^2."""
        return np.asarray(_value([sample["dynamical_matrix"] for sample in self._fields["samples"]]), dtype=np.complex128)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the corners of the path, as in the diagram."""
        return tuple(corner["name"] for corner in self._fields["corners"])

    @property
    def corners(self) -> Floats:
        """Arc lengths of the corners along the path, shape (corners,); 1/length."""
        return np.array([corner["length"] for corner in self._fields["corners"]], dtype=np.float64)


class Path(Answer):
    """Loss and recovery of stability along a path.

    ``material_onset`` and ``discretization_onset`` are the first losses, with parameter, deformation gradient, Cauchy stress and wave, or ``None``.
    ``material_crossings`` and ``discretization_crossings`` contain all changes between stable and unstable.
    """

    __slots__ = ()


class Boundary(Answer):
    """Boundaries in the plane of a study where material and particles lose stability; ``fidelity`` contains the distance between them."""

    __slots__ = ()

    def geojson(self) -> dict[str, Any]:
        """Returns the curves in the coordinates of the axes as a FeatureCollection: the file ``boundary.geojson``."""
        return cast("dict[str, Any]", json.loads(self.files()["boundary.geojson"]))

    def curves(self) -> list[tuple[str, Floats]]:
        """Returns the owner of each curve, ``material`` or ``discretization``, and its points, shape (n, 2), in the units of the axes."""
        told = []
        for feature in self.geojson()["features"]:
            points = feature["geometry"]["coordinates"]
            points = points[0] if feature["geometry"]["type"] == "Polygon" else points
            told.append((cast(str, feature["properties"]["of"]), np.array(points, dtype=np.float64)))
        return told

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws the curves over the axes of the study."""
        from . import _plots
        from ._figure import axes

        return _plots.curves(self, axes(ax, fig))


class Modes(_Moving):
    """Zero-energy and weakly controlled modes of a method, in ``modes``.

    Each mode has ``wave_vector`` (1/length), ``fractional`` (in units of the reciprocal vectors) and ``relative_frequency``. ``fits`` states whether
    the mode fits into the patch that is drawn, and ``fit`` is a patch into which it fits. ``complete`` states that no mode can have been missed.
    """

    __slots__ = ()

    @asks
    def mode(self, number: int = 1, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """Returns a mode in the reference configuration on a patch of particles.

        Parameters
        ----------
        number
            Number of the mode in the list, counted from 1.
        branch
            Number of the wave with this wave vector, counted by increasing ``|omega^2|``. For a mode of nullity n, the first n waves have zero
            energy.
        cells, amplitude
            Parameters of `Waves.mode`.

        Raises
        ------
        InputError
            If the method has no spurious modes, or an argument is out of range.
        """
        listed = self._fields["modes"]
        if not listed:
            raise InputError("the method has no spurious modes")
        k = np.array(listed[whole(number, "number", 1, len(listed)) - 1]["wave_vector"], dtype=np.float64)
        cell = self._cell()
        # Uniform displacements also have zero energy.
        is_uniform = float(np.linalg.norm(k)) * cell.spacing < 1e-9
        # Scale of nonzero eigenvalues, to identify zero-energy modes.
        size = float(np.max(np.abs(cell.dynamical_matrix(k + 0.5 / cell.spacing))))
        values, vectors = cell.waves(cell.dynamical_matrix(k), size=size, without_translations=is_uniform)
        own = int(np.argsort(np.abs(values), kind="stable")[whole(branch, "branch", 1, len(values)) - 1])
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)


class Criteria(Answer):
    """First violation of each stability criterion along ``loadings``, and ``disagreements`` between the criteria."""

    __slots__ = ()


class Card(Answer):
    """Safe range of a law: ``symmetric_box`` and ``widest_box`` of principal stretches, each a box or ``None``, and limits along ``loadings``."""

    __slots__ = ()


class Fit(Answer):
    """Laws fitted to tests: ``laws``, by increasing error, and ``refused`` laws with the reasons.

    The properties describe the first law.
    """

    __slots__ = ()

    @property
    def law(self) -> str:
        """Name of the law."""
        return cast(str, self._best["law"])

    @property
    def constants(self) -> dict[str, float]:
        """Constants by name, without the bulk modulus ``kappa``; stress or dimensionless."""
        return {own["name"]: own["value"] for own in self._best["constants"]}

    @property
    def error(self) -> float:
        """Root mean square of the errors relative to the measured stresses, dimensionless."""
        return cast(float, self._best["error"])

    @property
    def settings(self) -> list[str]:
        """Assignments ``material.KEY=VALUE`` with the bulk modulus, as after ``--set`` of the command."""
        return list(self._best["settings"])

    @property
    def material(self) -> Material:
        """Law with the bulk modulus, for ``onset.criteria``, ``onset.card`` and others."""
        return law_of(self.settings)

    @property
    def _best(self) -> dict[str, Any]:
        return cast("dict[str, Any]", self._fields["laws"][0])

    def table(self) -> list[dict[str, Any]]:
        """Returns a row for each law, for example for ``pandas.DataFrame``.

        A row has the ``law``, the number of ``constants``, the ``error`` and the ``free_error`` without the stability constraint (dimensionless), the
        ``shear_modulus`` and the bulk modulus ``kappa`` (stress), and the ``proof`` of stability: ``proved``, ``sampled`` or ``None``.
        """
        return [
            {
                "law": own["law"],
                "constants": len(own["constants"]),
                **{name: own[name] for name in ("error", "free_error", "shear_modulus", "kappa")},
                "proof": own["proof"] and own["proof"]["kind"],
            }
            for own in self._fields["laws"]
        ]


class Localization(Answer):
    """Localization of a plastic material along a loading: ``first_yield``, ``strong_ellipticity_lost`` and ``localization`` with its band.

    Events that do not occur are ``None``. Moduli and stresses are in the unit of stress, angles in degrees.
    """

    __slots__ = ()


class Zoo(Answer):
    """Instabilities that users of particle codes reported: ``reports``, each with ``name``, ``title``, ``where``, ``verdict`` and ``remedy``."""

    __slots__ = ()


class Report(Answer):
    """Report of an instability: the ``answer`` for its state, the ``remedy``, the ``remedy_answer`` with it, and the ``study`` with its settings."""

    __slots__ = ()


class Comparison(Answer):
    """Comparison of methods: ``rows``, each with the ``measured`` values, or a ``note`` with the reason why the method could not be measured."""

    __slots__ = ()


class Recommendation(Answer):
    """Ranking of methods by ``rules``: in ``ranking``, recommended methods come first, starting with the best; the others have ``excluded``."""

    __slots__ = ()


class Tuning(Answer):
    """Smallest sufficient coefficient of a stabilization, and all values ``tried``."""

    __slots__ = ()

    @property
    def recommended(self) -> float | None:
        """Smallest value found that removes the spurious modes and masks no instability, in the unit of the key, or ``None``."""
        return cast("float | None", self._fields["recommended"])


class Limit(Answer):
    """Values of a setting that admit a time step or keep states stable, in ``admitted``, and all values ``tried``.

    Values tried have their ``critical_time_step`` and ``verdict``, or the ``stable_share`` of the states.
    """

    __slots__ = ()

    @property
    def intervals(self) -> list[tuple[float, float]]:
        """Smallest and largest value of each interval of admitted values, in the unit of the key."""
        return [(own["from"]["value"], own["to"]["value"]) for own in self.to_dict()["admitted"]]


class Audit(Answer):
    """Existence of an energy and consistency of the tangent: ``checks``, each with ``name``, ``outcome``, relative ``error`` and ``finding``."""

    __slots__ = ()

    @property
    def consistent(self) -> bool:
        """Whether no check fails."""
        return cast(bool, self._fields["consistent"])

    def raise_for_error(self) -> Audit:
        """Returns the audit if no check fails.

        Raises
        ------
        InputError
            If a check fails; the message is the text of the audit.
        """
        if not self.consistent:
            raise InputError(str(self))
        return self

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws the error of each check on a logarithmic axis."""
        from . import _plots
        from ._figure import axes

        return _plots.checks(self, axes(ax, fig))


class Simulation(Answer):
    """Simulation of a patch of particles, compared with its prediction.

    ``outcome`` is ``agrees``, ``differs`` or ``undecided``; the rates ``predicted`` and ``measured`` are in 1/time. ``csv`` has them in one row.
    """

    __slots__ = ()

    def to_frame(self) -> pandas.DataFrame:
        """Amplitude of the wave over time, with the units in the names if settings have units.

        Returns
        -------
        pandas.DataFrame
            One row for each sample of the run, with the columns ``time`` and ``amplitude``. ``attrs`` holds the command-line text of the answer as
            ``text``.

        Raises
        ------
        OnsetError
            If pandas is not installed.
        """
        return self._frame(self.files()["amplitude.csv"].decode())


class Screening(Answer):
    """First cause of an instability in a run, with evidence and remedy.

    ``cause`` is ``physical``, ``numerical``, ``time-step``, ``zero-energy``, ``forced`` or ``none``; ``sentence`` states it as a sentence. ``first`` and
    ``observed`` are the times and places at which the cause begins and at which short waves are observed.
    """

    __slots__ = ("_kept", "_modes")
    _kept: list[tuple[float, Mapping[str, bytes]]]
    _modes: list[bytes]

    def __init__(
        self,
        answer: _onset.Answer,
        kept: list[tuple[float, Mapping[str, bytes]]] | None = None,
        modes: list[bytes] | None = None,
    ) -> None:
        super().__init__(answer)
        object.__setattr__(self, "_kept", kept or [])
        object.__setattr__(self, "_modes", modes or [])

    def to_xarray(self) -> xarray.Dataset:
        """Predictions and measurements over ``time``: amplitudes in spacings, rates in 1/time, ratios of the limits. Requires xarray.

        Raises
        ------
        OnsetError
            If xarray is not installed.
        """
        from ._exports import dataset

        rows = self.to_dict()["moments"]
        time = [row["time"] for row in rows]
        columns = {name: np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float) for name in rows[0] if name != "time"}
        return dataset({name: ("time", values) for name, values in columns.items()}, {"time": time})

    def fields(self) -> xarray.Dataset:
        """Fields of all frames over ``time`` and ``point`` (``node`` for ``noise``), if ``onset.screen`` was called with ``fields=True``.

        ``cause`` has the numbers 0 physical, 1 numerical, 2 time step, 5 none. Requires xarray.

        Raises
        ------
        OnsetError
            If xarray is not installed, or the fields were not kept.
        """
        from ._exports import dataset

        if not self._kept:
            raise OnsetError("the fields were not kept\n  hint: call onset.screen with fields=True")
        names = self._kept[0][1]
        arrays = {name: np.stack([np.frombuffer(found[name]) for _, found in self._kept]) for name in names}
        axes = {name: ("time", "node" if name == "noise" else "point") for name in names}
        return dataset({name: (axes[name], arrays[name]) for name in names}, {"time": [now for now, _ in self._kept]})

    def modes(self) -> xarray.Dataset:
        """Lowest modes of the body over ``mode``, if ``onset.screen`` was called with ``actual``.

        ``displacement`` over ``mode``, ``node`` and ``axis`` has a largest vector of length 1. ``omega_squared`` is in 1/time^2, ``growth`` in 1/time. Requires
        xarray.

        Raises
        ------
        OnsetError
            If xarray is not installed, or ``actual`` was not given.
        """
        from ._exports import dataset

        actual = self.to_dict()["actual"]
        if actual is None:
            raise OnsetError("there are no modes\n  hint: call onset.screen with actual, the time of a frame")
        displacements = [np.frombuffer(mode).reshape(-1, 3) for mode in self._modes]
        arrays: dict[str, Any] = {"displacement": (("mode", "node", "axis"), np.stack(displacements))}
        for name in ("omega_squared", "growth", "kind", "short_waves", "strained", "particle"):
            arrays[name] = ("mode", np.array([mode[name] for mode in actual["modes"]]))
        return dataset(arrays, {"mode": np.arange(1, 1 + len(displacements)), "axis": ["x", "y", "z"]})


class Mapped(Answer):
    """Summary of a map: number and fraction of states for each verdict in ``verdicts``, and the store."""

    __slots__ = ()

    @property
    def store(self) -> str:
        """Folder of the store, as given."""
        return cast(str, self._fields["store"])

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws the number of states of the map for each verdict."""
        from . import _plots
        from ._figure import axes

        return _plots.shares(self, axes(ax, fig))


def _components(name: str, vectors: Floats) -> dict[str, Floats]:
    """Returns the components of vectors as columns ``name_1``, ``name_2``, ..."""
    rows = vectors.reshape(-1, vectors.shape[-1])
    return {f"{name}_{n + 1}": rows[:, n] for n in range(rows.shape[1])}


class Verdicts:
    """Verdicts on many states, as arrays of the shape (...) of the states; vectors have an additional axis. Missing numbers are NaN."""

    #: Names of the verdicts, in the order of `codes`.
    names: tuple[str, ...] = tuple(_onset.verdict_names())

    def __init__(
        self,
        columns: Mapping[str, bytes],
        shape: tuple[int, ...],
        dimension: int,
        steps: Callable[[], bytes] | None = None,
    ) -> None:
        def of(name: str) -> Floats:
            return received(columns[name], shape)

        #: Indices of the verdicts in `names`, shape (...).
        self.codes: NDArray[np.int8] = of("verdict").astype(np.int8)
        #: Smallest ``Re omega^2 / (c^2 |k|_h^2)`` over the zone, shape (...); dimensionless.
        self.scaled_minimum: Floats = of("scaled_minimum")
        #: Smallest ``Re omega^2`` over the zone, shape (...); 1/time^2.
        self.lowest_omega_squared: Floats = of("lowest_omega_squared")
        #: Growth rate of the fastest growing wave, zero if no wave grows, shape (...); 1/time.
        self.growth_rate: Floats = of("growth_rate")
        #: Mechanisms of numerical instabilities by name, empty for other verdicts, shape (...).
        self.mechanism: NDArray[np.str_] = np.array(_onset.mechanism_names())[of("mechanism").astype(np.int8)]
        self._steps: Floats | None = None if steps else of("critical_time_step")
        self._searched = steps
        #: Smallest acoustic eigenvalue of the continuum, shape (...); stress.
        self.acoustic_minimum: Floats = of("acoustic_minimum")
        #: Reference wave vector of `scaled_minimum`, shape (..., D); 1/length.
        self.wave_vector: Floats = received(columns["wave_vector"], (*shape, dimension))
        #: Reference direction of `acoustic_minimum`, a unit vector, shape (..., D).
        self.acoustic_direction: Floats = received(columns["acoustic_direction"], (*shape, dimension))

    @property
    def critical_time_step(self) -> Floats:
        """Critical time step of the infinite lattice, ``2/omega_max`` for central differences, shape (...); time.

        Free faces and distorted cells need a smaller step. With damping the steps are computed when they are first needed.
        """
        if self._steps is None:
            steps = cast("Callable[[], bytes]", self._searched)
            self._steps, self._searched = received(steps(), self.codes.shape), None
        return self._steps

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_steps": self.critical_time_step, "_searched": None}

    @property
    def verdict(self) -> NDArray[np.str_]:
        """Verdicts by name, shape (...)."""
        return np.array(self.names)[self.codes]

    def to_frame(self) -> pandas.DataFrame:
        """Table with one row for each state, in the order of the states.

        Returns
        -------
        pandas.DataFrame
            Columns are the arrays of the answer, with the components of vectors as ``wave_vector_1``, ``wave_vector_2``, ...

        Raises
        ------
        OnsetError
            If pandas is not installed.

        Examples
        --------
        >>> onset.verdicts("neo-hooke", stretch=[(1.1, 1), (1.2, 1)]).to_frame()["verdict"].tolist()
        ['stable', 'stable']
        """
        numbers = {
            name: getattr(self, name)
            for name in ("scaled_minimum", "lowest_omega_squared", "growth_rate", "critical_time_step", "acoustic_minimum")
        }
        vectors = _components("wave_vector", self.wave_vector) | _components("acoustic_direction", self.acoustic_direction)
        columns = {"verdict": self.verdict, "mechanism": self.mechanism, **numbers, **vectors}
        return cast("pandas.DataFrame", _frames().DataFrame({name: np.ravel(column) for name, column in columns.items()}))

    def count(self) -> dict[str, int]:
        """Returns the number of states for each verdict."""
        counts = np.bincount(self.codes.ravel(), minlength=len(self.names))
        return {name: int(count) for name, count in zip(self.names, counts, strict=True)}

    def __len__(self) -> int:
        return self.codes.size

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {name}" for name, count in self.count().items() if count)
        return f"<onset.Verdicts on {self.codes.size} states: {told}>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{html.escape(name)}</td><td>{count}</td></tr>" for name, count in self.count().items())
        return f"<table>{rows}</table>"

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws the number of states for each verdict."""
        from . import _plots
        from ._figure import axes

        return _plots.bars(list(self.count()), list(self.count().values()), "states", axes(ax, fig))


class Dispersion:
    """Waves of one state at many wave vectors."""

    def __init__(self, k: Floats, omega_squared: Complexes, continuum: Floats) -> None:
        #: Reference wave vectors, shape (..., D); 1/length.
        self.k: Floats = k
        #: Squared frequencies of the particles by increasing real part, shape (..., branches); 1/time^2.
        self.omega_squared: Complexes = omega_squared
        #: Squared frequencies of the continuum, shape (..., D); 1/time^2.
        self.continuum_omega_squared: Floats = continuum

    @property
    def frequencies(self) -> Floats:
        """Frequencies ``Re omega``, shape (..., branches); 1/time."""
        return np.asarray(np.sqrt(self.omega_squared).real, dtype=np.float64)

    @property
    def growth_rates(self) -> Floats:
        """Growth rates ``|Im omega|``, zero for waves that do not grow, shape (..., branches); 1/time."""
        return np.asarray(np.abs(np.sqrt(self.omega_squared).imag), dtype=np.float64)

    def to_frame(self) -> pandas.DataFrame:
        """Table with one row for each wave vector, in their order.

        Returns
        -------
        pandas.DataFrame
            Columns ``k_1``, ``omega_squared_re_1``, ``omega_squared_im_1``, ``continuum_omega_squared_1``, and so on for all components.

        Raises
        ------
        OnsetError
            If pandas is not installed.

        Examples
        --------
        >>> waves = onset.dispersion("neo-hooke", k=[(1, 0), (2, 0)], stretch=(1, 1))
        >>> waves.to_frame()["k_1"].tolist()
        [1.0, 2.0]
        """
        columns = (
            _components("k", self.k)
            | _components("omega_squared_re", self.omega_squared.real)
            | _components("omega_squared_im", self.omega_squared.imag)
            | _components("continuum_omega_squared", self.continuum_omega_squared)
        )
        return cast("pandas.DataFrame", _frames().DataFrame(columns))

    def __repr__(self) -> str:
        return f"<onset.Dispersion of {self.k[..., 0].size} wave vectors, {self.omega_squared.shape[-1]} branches>"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>"

    def plot(self, ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
        """Draws ``omega^2`` (1/time^2) against the length of the wave vector (1/length)."""
        from . import _plots
        from ._figure import axes

        return _plots.scatter(self, axes(ax, fig))
