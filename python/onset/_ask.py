"""Questions of the command as functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
import os
from typing import TYPE_CHECKING, Any, Protocol
from uuid import uuid4
import warnings

import numpy as np
from numpy.typing import ArrayLike

from . import _onset
from ._answers import (
    Audit,
    Bands,
    Boundary,
    Card,
    Comparison,
    Criteria,
    Dispersion,
    Limit,
    Localization,
    Mapped,
    Modes,
    Path,
    Recommendation,
    Simulation,
    State,
    Tuning,
    Verdicts,
    Waves,
)
from ._arrays import Complexes, Floats, components, deformations, number, numbers, pair, positive, received, share, typed, whole
from ._arrays import between, listed, names, place, switch
from ._arrays import state as state_as_typed
from ._errors import InputError, OnsetError, asks
from ._exports import Cell
from ._settings import (
    MaterialLike,
    MethodLike,
    Study,
    Value,
    _key,
    _typed,
    material_of,
    method_of,
    problem_of,
    quoted,
    source,
    study_of,
    toml,
)

if TYPE_CHECKING:
    import xarray

#: Larger counts are no counts.
MOST = 2**53


@asks
def state(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
    certify: bool = False,
    tolerance: float = 1e-3,
    weak: float = 0.1,
) -> State:
    """Is a state stable, and if not, is the instability physical or numerical? ``onset state``.

    The discretization is stable where all ``omega^2`` of its dynamical matrix ``D(k)`` are real and nonnegative, for all ``k`` of the zone; the material where
    it is strongly elliptic, ``A_iJkL g_i N_J g_k N_L > 0`` for all ``g, N``.

    The state has principal stretches along the axes (`stretch`, shape (D,) to (3,)), or a deformation gradient `F` of shape (3, 3), or (D, D). With `certify`
    stability or instability is proved, with a bound or a witness, in ``answer.certificate``; `tolerance`, without dimension, is from where on the measure of
    an undecided state counts as away from zero. A stable state is told to be weakly controlled if a wave of the reference configuration, ``answer.discretization.weakest_mode``,
    has less than the share `weak` of the frequency of the material's slowest wave with the same wave vector.

    A state at which the law or the method is not defined is an `InputError`.
    """
    problem = problem_of(material, method)
    proof = between(tolerance, "tolerance", 0.0, np.nextafter(1.0, 0.0), "a number above 0 and below 1, for example 1e-3")
    given, gradient = state_as_typed(F, stretch)
    answer = State(problem.state(given, gradient, proof if switch(certify, "certify") else None, share(weak, "weak")))
    here = np.ascontiguousarray(answer.deformation_gradient, dtype=np.float64).reshape(1, 9)
    return answer._with_spectrum(lambda k: _waves_at(problem, here, k))._of(lambda: Cell.of(problem, given, gradient, here))


def _waves_at(problem: _onset.Problem, states: Floats, k: Floats) -> tuple[Complexes, Floats]:
    """Waves of particles and continuum of one state at wave vectors of shape (n, D)."""
    k = np.ascontiguousarray(k)
    particles = received(problem.omega_squared(states, k), (len(k), problem.branches * 2)).view(np.complex128)
    continuum = received(problem.continuum_omega_squared(states, k), (len(k), problem.dimension))
    return particles, continuum


def _wave_vectors(k: ArrayLike, dimension: int) -> tuple[Floats, tuple[int, ...]]:
    """Wave vectors as rows, and the shape of what is around them."""
    given = numbers(k, "k")
    if given.ndim == 0 or given.shape[-1] != dimension:
        raise InputError(f"k has the shape {given.shape}; expected (..., {dimension})")
    return given.reshape(-1, dimension), given.shape[:-1]


@asks
def dispersion(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    k: ArrayLike,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
) -> Dispersion:
    """Plane waves ``g exp(i omega t + i k.X)`` of one state at many wave vectors: ``omega^2 g = D(k) g`` of the particles, ``rho_0 omega^2 g = Q(k) g`` of the
    continuum.

    `k` are reference wave vectors of shape (..., D); 1/length. Many states are an `InputError`: ``onset.omega_squared`` takes them.
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    if shape:
        raise InputError(f"dispersion is of one state, not of {shape}\n  hint: onset.omega_squared takes many")
    vectors, around = _wave_vectors(k, problem.dimension)
    particles, continuum = _waves_at(problem, states, vectors)
    branches = problem.branches
    return Dispersion(
        vectors.reshape(*around, problem.dimension), particles.reshape(*around, branches), continuum.reshape(*around, problem.dimension)
    )


@asks
def omega_squared(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    k: ArrayLike,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
) -> Complexes:
    """The ``omega^2`` of the particles, ``omega^2 g = D(k) g``, by increasing real part, of many states at many wave vectors.

    States are `F` of shape (..., 3, 3) or (..., D, D), or `stretch` of shape (..., D) to (..., 3); reference wave vectors `k` of shape (n, D) or (D,) in
    1/length. The result has the shape (..., n, branches), or (..., branches) with one wave vector; 1/time^2.
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    vectors, around = _wave_vectors(k, problem.dimension)
    all_waves = received(problem.omega_squared(states, vectors), (*shape, *around, problem.branches * 2))
    return all_waves.view(np.complex128)


@asks
def dynamical_matrix(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    k: ArrayLike,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
) -> Complexes:
    """The dynamical matrix ``D(k)``, whose eigenvalues are ``omega^2`` and whose eigenvectors are the polarizations of the particles of a cell.

    States and wave vectors as of ``onset.omega_squared``. The result has the shape (..., n, branches, branches), or (..., branches, branches) with one wave
    vector; 1/time^2.
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    vectors, around = _wave_vectors(k, problem.dimension)
    branches = problem.branches
    matrices = received(problem.dynamical_matrices(states, vectors), (*shape, *around, branches, branches * 2))
    return matrices.view(np.complex128)


@asks
def waves(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    wave_vector: ArrayLike,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
) -> Waves:
    """The waves with one wave vector, ``omega^2 g = D(k) g``: ``onset dispersion --wave-vector``.

    `wave_vector` is the reference wave vector, shape (D,); 1/length.
    """
    problem = problem_of(material, method)
    given, gradient = state_as_typed(F, stretch)
    answer = Waves(problem.waves(given, gradient, typed(numbers(wave_vector, "wave_vector"))))
    return answer._of(lambda: Cell.of(problem, given, gradient))


@asks
def bands(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
    path: str | None = None,
) -> Bands:
    """The dispersion relation ``omega(k)`` along a path through the zone, with the density of states: ``onset dispersion --path``.

    `path` are names of points of high symmetry (``"G-M-K-G"``), or points in units of the reciprocal vectors (``"0,0; 0.5,0; K"``); along
    all that the state tells apart when left out. A name that the zone does not have is an `InputError` that tells those it has.
    """
    problem = problem_of(material, method)
    given, gradient = state_as_typed(F, stretch)
    return Bands(problem.bands(given, gradient, path))._of(lambda: Cell.of(problem, given, gradient))


@asks
def path(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    to: ArrayLike,
    from_: ArrayLike | None = None,
    mode: str | None = None,
    lateral: str | None = None,
) -> Path:
    """Where along a path of deformations is stability lost, and regained? ``onset path``.

    `from_` and `to` are stretches, or deformation gradients of shape (D, D) or (3, 3). With `mode` (``uniaxial``, ``equibiaxial``, ``planar``,
    ``simple-shear``, ``hydrostatic``) they are its imposed stretches, `from_` being 1 when left out; in simple shear they are amounts of shear, `from_`
    being 0. `lateral` is what holds the other directions: ``free``, ``plane-stress``, ``plane-strain`` or ``held``, when left out the freest that the mode
    has. `lateral` without `mode` is an `InputError`.
    """
    problem = problem_of(material, method)
    if mode is not None:
        rest = 0.0 if isinstance(mode, str) and mode == "simple-shear" else 1.0
        start = rest if from_ is None else number(from_, "from_")
        return Path(problem.loading_path(mode, lateral, start, number(to, "to")))
    if lateral is not None:
        raise InputError("`lateral` is read with `mode`")
    if from_ is None:
        raise InputError("a path has `from_` and `to`; with `mode` `from_` may be left out")
    return Path(problem.straight_path(_end(from_, "from_"), _end(to, "to")))


def _end(given: ArrayLike, what: str) -> str:
    """The end of a path as it is typed."""
    array = numbers(given, what)
    return components(array) if array.ndim == 2 else typed(array)


@asks
def verdicts(
    material: MaterialLike = None,
    method: MethodLike = None,
    F: ArrayLike | None = None,
    *,
    stretch: ArrayLike | None = None,
) -> Verdicts:
    """Verdicts on many states: `F` of shape (..., 3, 3) or (..., D, D), or `stretch` of shape (..., D) to (..., 3).

    Each state is what a map has of it, computed on all cores without the interpreter's lock. A state at which the law or the method is not defined has the
    verdict ``undefined``; one that is no deformation, ``det F <= 0``, is an `InputError`.
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    return Verdicts(problem.verdicts(states), shape, problem.dimension)


@asks
def simulate(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
    cells: int | Sequence[int] = 8,
    mode: str = "critical",
    wave_vector: ArrayLike | None = None,
    turns: Sequence[int] | None = None,
    branch: int = 1,
    amplitude: float = 1e-6,
    seed: int = 1,
    steps: int | None = None,
    time: float | None = None,
    fraction: float | None = None,
    time_step: float | None = None,
    supercritical: bool = False,
    integrator: str | None = None,
    tolerance: float = 1e-6,
    out: str | os.PathLike[str] | None = None,
    every: int | None = None,
    fields: int = 11,
    checkpoint: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> Simulation:
    """A prediction in motion: the particles of a periodic patch, step by step, and the measured rate of a wave: ``onset simulate``.

    - The patch has `cells` along each primitive vector. What moves at the start is its critical wave, with ``mode="noise"`` all particles at random by `seed`, or
      the wave with the reference `wave_vector` (shape (D,); 1/length) or with so many `turns` along each side, of which `branch` counts from 1 by increasing
      ``omega^2``. `amplitude` is the largest displacement at the start, in particle spacings.
    - It takes `steps`, or the `time`; when left out about a period, four e-folding times of growth or one of decay. A step is the `fraction` of the largest
      stable one, 0.5 or less when left out, or the `time_step` (time) itself, of a transfer ``discretization.time-step`` where that is set; above the largest stable one only if `supercritical`. The `integrator` is ``kick-drift-kick``
      (when left out), ``central-differences``, ``predictor-corrector``, ``sixth-order`` or a Runge-Kutta method as in `limit`; a transfer of material points has a step of its own, and takes none.
    - Rates that differ by less than the share `tolerance` agree.
    - With `out`, a folder, the history is written `every` so many steps, so many `fields`, and a checkpoint each `checkpoint` steps (five seconds when left
      out), from which `resume` goes on; `overwrite` begins anew.

    A wave that does not fit into the patch is an `InputError` that names the nearest one that does, a motion that breaks down a `MachineError`.
    """
    problem = problem_of(material, method)
    given, gradient = state_as_typed(F, stretch)
    sides = np.atleast_1d(numbers(cells, "cells"))
    around = None if turns is None else np.atleast_1d(numbers(turns, "turns"))
    if fraction is not None and time_step is not None:
        raise InputError("a step is `fraction` or `time_step`, not both")
    return Simulation(
        problem.simulate(
            given,
            gradient,
            [whole(side, "cells", 0, MOST) for side in sides.ravel()],
            mode,
            None if wave_vector is None else [float(x) for x in numbers(wave_vector, "wave_vector").ravel()],
            None if around is None else [whole(turn, "turns", -MOST, MOST) for turn in around.ravel()],
            whole(branch, "branch", 0, MOST),
            share(amplitude, "amplitude"),
            whole(seed, "seed", 0, MOST),
            None if steps is None else whole(steps, "steps", 1, MOST),
            None if time is None else positive(time, "time"),
            None if fraction is None else positive(fraction, "fraction"),
            None if time_step is None else positive(time_step, "time_step"),
            switch(supercritical, "supercritical"),
            integrator,
            share(tolerance, "tolerance"),
            None if out is None else place(out, "out"),
            None if every is None else whole(every, "every", 1, MOST),
            whole(fields, "fields", 0, 10_000),
            None if checkpoint is None else whole(checkpoint, "checkpoint", 1, MOST),
            switch(resume, "resume"),
            switch(overwrite, "overwrite"),
        )
    )


@asks
def criteria(
    material: MaterialLike = None,
    *,
    range: tuple[float, float] = (0.1, 10.0),
    modes: Iterable[str] = (),
    incompressible: bool = False,
) -> Criteria:
    """Where along standard loadings is each stability criterion of a law lost? ``onset criteria``.

    `range` are the smallest and the largest stretch, `modes` the modes of loading (``uniaxial``, ``equibiaxial``, ``planar``, ``simple-shear``,
    ``hydrostatic``), all when left out. `incompressible` asks the incompressible response of an isotropic law.
    """
    return Criteria(material_of(material)._law().criteria(_two(range, "range"), names(modes, "modes"), switch(incompressible, "incompressible")))


@asks
def card(
    material: MaterialLike = None,
    *,
    range: tuple[float, float] = (0.1, 10.0),
    modes: Iterable[str] = (),
    incompressible: bool = False,
) -> Card:
    """The safe range of a law: stretches within which it is strongly elliptic, for all loadings and for standard ones: ``onset card``.

    Arguments as of ``onset.criteria``.
    """
    return Card(material_of(material)._law().card(_two(range, "range"), names(modes, "modes"), switch(incompressible, "incompressible")))


def _two(given: ArrayLike, what: str) -> tuple[float, float]:
    array = numbers(given, what)
    if array.shape != (2,):
        raise InputError(f"{what} has the shape {array.shape}; expected two numbers")
    return float(array[0]), float(array[1])


@asks
def audit(
    material: MaterialLike = None,
    *,
    strain: float = 0.1,
    stretch: Sequence[ArrayLike] = (),
    F: Sequence[ArrayLike] = (),
    convention: str | None = None,
) -> Audit:
    """Does a law have an energy, and is its tangent consistent? ``onset audit``.

    It checks ``P_iJ = dW/dF_iJ``, ``A_iJkL = dP_iJ/dF_kL``, objectivity, the work around closed loops and more, by finite differences. `strain` is how large the
    strains of the states are, above 0 and at most 0.8, unless states are given: a list `stretch` of stretches, or `F` of deformation gradients. `convention`
    takes the tangent of a law of onset's own as if delivered in it: ``first-piola``, ``jaumann-kirchhoff``, ``truesdell``, ...; another word is an
    `InputError` that tells all.
    """
    size = between(strain, "strain", 0.0, 0.8, "a number above 0 and at most 0.8, for example 0.05")
    stretches = [typed(numbers(one, "stretch")) for one in listed(stretch, "stretch")]
    return Audit(material_of(material)._law().audit(size, stretches, [components(one) for one in listed(F, "F")], convention))


@asks
def localize(model: str | None = None, path: str | None = None, load: str | None = None, **parameters: Value) -> Localization:
    """When does a plastic material localize, in which band, at which angle? ``onset localize``.

    A band with the normal ``n`` can form where ``det(n.L.n) = 0`` with the tangent ``L`` of continued flow.

    Keywords are the keys of ``[plasticity]``: ``onset.localize("drucker-prager", "plane-strain", friction=0.7)``. Stresses are in any unit, or have one.
    With the model ``"umat"`` those of the routine are ``library``, ``properties``, ``state_variables``, ``time_limit`` and ``memory_limit``.
    """
    named = {"model": model, "path": path, "load": load} | parameters
    routine = {"library", "properties", "state_variables", "time_limit", "memory_limit"}
    keys = {_key("material" if name in routine else "plasticity", name): value for name, value in named.items() if value is not None}
    return Localization(_onset.localize([f"{key}={_typed(value, key)}" for key, value in keys.items()]))


@asks
def modes(
    method: MethodLike = None,
    material: MaterialLike = None,
    *,
    weak: float = 0.1,
    cells: int = 8,
    amplitude: float = 0.2,
) -> Modes:
    """Zero-energy and weakly controlled modes of a method in the reference configuration: ``onset modes``.

    Waves slower than the share `weak` of the material's slowest wave with the same wave vector are listed. `cells` along each primitive vector and
    `amplitude`, the largest displacement in particle spacings, are those of the patch that is drawn and exported by ``save``.
    """
    settings = [*material_of(material)._assigned(), *method_of(method).assignments]
    answer = Modes(_onset.modes(settings, None, [], share(weak, "weak"), whole(cells, "cells", 1, 512), share(amplitude, "amplitude")))

    def cell() -> Cell:
        problem = problem_of(material, method)
        return Cell.of(problem, None, typed(np.eye(3)), np.eye(3).reshape(1, 9))

    return answer._of(cell)


@asks
def tune(
    method: MethodLike,
    key: str,
    *,
    material: MaterialLike = None,
    range: tuple[float, float] = (0.0, 1.0),
    stretches: tuple[float, float] = (0.7, 1.5),
    weak: float = 0.1,
    wrong: float = 0.005,
    later: float = 0.02,
) -> Tuning:
    """The smallest coefficient of a stabilization that removes the spurious modes and does not mask the material's instability: ``onset tune``.

    `key` is one of ``[discretization]`` that takes a number: ``onset.tune(method, "penalty")``; it is sought in `range`, in the unit of the key. The limits are
    `weak`, the share of the frequency of the material's slowest wave below which a wave is weakly controlled, `wrong`, the share of the window of `stretches`
    on which verdicts may be wrong, and `later`, by which share of its strain the method's onset may come later than the material's.
    """
    if not isinstance(key, str):
        raise TypeError(f"key is {type(key).__name__}; expected the name of a key")
    full = key if "." in key else _key("discretization", key)
    settings = [*material_of(material)._assigned(), *method_of(method).assignments]
    limits = (share(weak, "weak"), share(wrong, "wrong"), share(later, "later"))
    return Tuning(_onset.tune(full, settings, None, [], pair(range, "range"), pair(stretches, "stretches"), limits))


@asks
def limit(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    vary: str,
    time_step: float | str,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
    range: tuple[float, float] | None = None,
    safety: float = 1.0,
    integrator: str = "kick-drift-kick",
) -> Limit:
    """Which modulus, spacing or coefficient does a time step admit? ``onset limit``.

    `vary` is a key that takes a number, ``"material.young"`` or ``"discretization.spacing"``. Sought are its values with which `time_step` (time; a text has a
    unit, ``"1 us"``) is at most `safety` times the critical step of the state, at ``F = 1`` unless `stretch` or `F` is given. Values are looked at from 1e-6 to
    1e6 times the present one, or in `range`, in the unit of the key. The integrators ``central-differences``, ``kick-drift-kick`` and ``predictor-corrector``
    differ with damping only; the Runge-Kutta methods are ``forward-euler``, ``heun``, ``rk3``, ``rk4``, ``carpenter-kennedy``, ``rdpk3-35`` and ``rdpk3-49``.

    A key that is not read, or of which no value can be evaluated, is an `InputError`.
    """
    if not isinstance(vary, str):
        raise TypeError(f"vary is {type(vary).__name__}; expected the name of a key")
    if not isinstance(integrator, str):
        raise TypeError(f"integrator is {type(integrator).__name__}; expected a name")
    problem = problem_of(material, method)
    given = (None, None) if stretch is None and F is None else state_as_typed(F, stretch)
    step = time_step if isinstance(time_step, str) else repr(positive(time_step, "time_step"))
    ends = None if range is None else pair(range, "range")
    return Limit(problem.limit(vary, step, given, ends, share(safety, "safety"), integrator))


#: Methods that are compared: a list, a dictionary with names, or a file.
Methods = Sequence[MethodLike] | Mapping[str, MethodLike] | os.PathLike[str] | str


def _comparison(methods: Methods, material: MaterialLike, options: Mapping[str, Value]) -> tuple[tuple[str, str], list[_onset.Function]]:
    """A comparison as a file, and the law beside it that no file can hold."""
    if isinstance(methods, (str, os.PathLike)):
        if material is not None or options:
            raise InputError("a file says all of a comparison\n  hint: use `set` to change it")
        return source(methods), []
    named = list(methods.items()) if isinstance(methods, Mapping) else [(None, method) for method in listed(methods, "methods")]
    law = material_of(material)
    beside = [setting for setting in law._assigned() if isinstance(setting, _onset.Function)]
    text = "" if beside else f"[material]\n{law._section_text()}"
    if options:
        keys = {_key("compare", name): value for name, value in options.items()}
        text += "\n[compare]\n" + "".join(f"{key.partition('.')[2]} = {toml(value, key)}\n" for key, value in keys.items())
    for name, method in named:
        own = method_of(method)
        text += f"\n[[methods]]\nname = {quoted(repr(own) if name is None else name, 'name')}\n{own._section_text()}"
    return ("comparison", text), beside


@asks
def compare(
    methods: Methods,
    material: MaterialLike = None,
    *,
    set: Iterable[str] = (),
    allow_library: Iterable[str | os.PathLike[str]] = (),
    **options: Value,
) -> Comparison:
    """Several methods side by side for one material: ``onset compare``.

    `methods` are a list, a dictionary with names, or a file. Options are the keys of ``[compare]``, ``stretches=(0.7, 1.5)``; `set` are assignments as
    after ``--set``. A file says all of a comparison: material or options beside it are an `InputError`. Libraries that it names are loaded only if they are
    in `allow_library`.
    """
    libraries = [place(path, "allow_library") for path in listed(allow_library, "allow_library")]
    file, law = _comparison(methods, material, options)
    return Comparison(_onset.compare(file, [*law, *names(set, "set")], libraries))


@asks
def recommend(
    material: MaterialLike = None,
    *,
    methods: Methods | None = None,
    dimension: int = 2,
    stretches: tuple[float, float] | None = None,
    weak: float = 0.1,
    wrong: float = 0.005,
    long_waves: float = 0.05,
    wavelength: float = 8.0,
    set: Iterable[str] = (),
    allow_library: Iterable[str | os.PathLike[str]] = (),
) -> Recommendation:
    """Which method for this material and these stretches? ``onset recommend``.

    Of `methods`, as ``onset.compare`` takes them, or of those that the program knows for the `dimension`; `stretches` are the smallest and the largest of
    interest. Limits are those of ``onset.tune``; `long_waves` is by which share the long-wavelength moduli may be wrong, `wavelength` at which frequencies are
    compared: 4, 8 or 16 particle spacings.
    """
    settings: list[str | _onset.Function] = [*names(set, "set")]
    if stretches is not None:
        settings.append("compare.stretches={!r},{!r}".format(*pair(stretches, "stretches")))
    length = number(wavelength, "wavelength")
    if length not in (4.0, 8.0, 16.0):
        raise InputError(f"wavelength is {length!r}; expected 4, 8 or 16")
    limits = (share(weak, "weak"), share(wrong, "wrong"), share(long_waves, "long_waves"), length)
    file = None
    if methods is not None:
        file, law = _comparison(methods, material, {})
        settings += law
    else:
        settings = [*material_of(material)._assigned(), *settings]
    libraries = [place(path, "allow_library") for path in listed(allow_library, "allow_library")]
    return Recommendation(_onset.recommend(file, whole(dimension, "dimension", 1, 3), settings, libraries, limits))


@asks
def boundary(study: Study | str | os.PathLike[str], *, flutter: bool = False) -> Boundary:
    """Where in the plane of a study do material and particles lose stability? ``onset boundary``.

    The `study`, or its file, has two axes. `flutter` tells flutter (``omega^2`` complex) from divergence (``omega^2 < 0``), and traces the boundary between
    them too.
    """
    return Boundary(study_of(study)._study.boundary(switch(flutter, "flutter")))


class Future(Protocol):
    """What an executor returns."""

    def result(self) -> Any:
        """Waits for the end."""

    def cancel(self) -> Any:
        """Does not begin what has not begun."""


class Executor(Protocol):
    """Whatever begins a function with arguments elsewhere, by ``submit(function, *arguments)``: an executor of ``concurrent.futures`` with processes, a Dask
    client.
    """

    def submit(self, function: Callable[..., int], /, *arguments: Any) -> Future:
        """Begins it."""


@asks
def map_into(
    out: str | os.PathLike[str],
    study: Study | str | os.PathLike[str],
    *,
    tiles: tuple[int, int] | str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    executor: Executor | None = None,
) -> Mapped:
    """Computes the map of a study into the store `out`, and tells what came of it: ``onset map``.

    `tiles` are the first and the one after the last of those that are computed, or a share of all, ``"1/8"`` to ``"8/8"``, whose tiles lie evenly among them;
    several processes may do parts of one store at the same time.
    Ctrl-C ends the map; tiles that are stored stay, and `resume` computes the rest. With an `executor`, anything with a ``submit`` whose workers see `out`, each tile is a task; what lost workers leave is
    computed here in the end. A store that exists is refused, unless `resume` or `tiles` go on with it or
    `overwrite` replaces it.
    """
    part = None
    if isinstance(tiles, str):
        part = tiles
    elif tiles is not None:
        first, last = _two(tiles, "tiles")
        part = f"{whole(first, 'tiles', 0, MOST)}..{whole(last, 'tiles', 0, MOST)}"
    anew, again = switch(overwrite, "overwrite"), switch(resume, "resume")
    if anew and (again or part is not None):
        raise InputError("`overwrite` begins a store anew; leave out `resume` and `tiles`")
    folder, own = place(out, "out"), study_of(study)
    if executor is None:
        return Mapped(own._study.map(folder, part, again, anew))
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor is {type(executor).__name__}; expected something with `submit`")
    if part is not None:
        raise InputError("an executor computes all tiles; leave out `tiles`")
    _elsewhere(executor, own, os.path.abspath(folder), own._study.begin(folder, again, anew))
    return Mapped(own._study.map(folder, None, True, False))


def _elsewhere(executor: Executor, study: Study, folder: str, tiles: int) -> None:
    """Lets an executor compute all tiles."""
    # Of one run: a scheduler that remembers results must not take those of an earlier store.
    run = uuid4().hex
    futures = [executor.submit(_tile, study, folder, tile, run) for tile in range(tiles)]
    try:
        for future in futures:
            try:
                future.result()
            except OnsetError:
                raise
            except Exception as error:
                warnings.warn(f"a worker was lost ({type(error).__name__}); its tiles are computed here", RuntimeWarning, stacklevel=4)
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _tile(study: Study, folder: str, tile: int, run: str) -> int:
    """Computes one tile of a store, in a process of an executor; it may be repeated. `run` tells tasks of different runs apart."""
    study._study.map(folder, f"{tile}..{tile + 1}", True, False)
    return tile


@asks
def map(
    study: Study | str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    tiles: tuple[int, int] | str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    executor: Executor | None = None,
) -> xarray.Dataset:
    """Computes the map of a study into the store `out`, and opens it: the dataset of ``xarray.open_zarr(out)``, with coordinates, units and
    attributes. Arguments as of ``onset.map_into``. Needs xarray and zarr.
    """
    map_into(out, study, tiles=tiles, resume=resume, overwrite=overwrite, executor=executor)
    return open_map(out)


@asks
def open_map(store: str | os.PathLike[str]) -> xarray.Dataset:
    """The dataset of a store that ``onset map`` has written: fields over the axes of the study, with coordinates, units and attributes.

    Needs xarray and zarr; without them it is an `OnsetError`, and an `InputError` where there is no such store.
    """
    folder = place(store, "store")
    try:
        import xarray
        import zarr  # noqa: F401
    except ImportError as error:
        raise OnsetError("maps are opened by xarray and zarr\n  hint: pip install xarray zarr") from error
    try:
        dataset: xarray.Dataset = xarray.open_zarr(folder)
    except Exception as error:
        raise InputError(f"cannot open {folder}: {error}\n  hint: expected a store that `onset map` has written") from error
    return dataset


@asks
def keys(section: str = "") -> dict[str, str]:
    """The keys of settings by name, each with what it means and expects; those of one section, ``material``, ``discretization``, ``state`` or ``map``."""
    if not isinstance(section, str):
        raise TypeError(f"section is {type(section).__name__}; expected a name")
    return {name: f"{meaning}: {expects}" for name, expects, meaning in _onset.keys() if name.startswith(section)}


def models() -> list[str]:
    """The names of the laws of the library, as ``onset list materials`` has them."""
    return _onset.models()

