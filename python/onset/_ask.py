"""Functions that correspond to the commands of ``onset``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
import os
from typing import TYPE_CHECKING, Any, Literal, Protocol
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
    Fit,
    Limit,
    Localization,
    Mapped,
    Modes,
    Path,
    Recommendation,
    Report,
    Screening,
    Simulation,
    State,
    Tuning,
    Verdicts,
    Waves,
    Zoo,
)
from ._arrays import Complexes, Floats, components, deformations, finite, number, numbers, pair, positive, received, share, typed, whole
from ._arrays import between, frames_of, listed, names, place, switch
from ._arrays import state as state_as_typed
from ._errors import InputError, OnsetError, asks
from ._exports import Cell
from ._settings import (
    Material,
    MaterialLike,
    Method,
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

#: Largest count; doubles represent all integers up to it exactly.
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
    """Stability of one state, and whether an instability is physical or numerical: ``onset state``.

    The discretization is stable if all ``omega^2`` of its dynamical matrix ``D(k)`` are real and nonnegative for all ``k`` of the zone. The material
    is stable if it is strongly elliptic: ``A_iJkL g_i N_J g_k N_L > 0`` for all ``g, N``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    stretch
        Principal stretches along the axes, shape (D,) to (3,); missing stretches are 1.
    F
        Deformation gradient instead of `stretch`, shape (3, 3) or (D, D).
    certify
        Prove stability or instability, with a bound or a witness, in ``answer.certificate``.
    tolerance
        Smallest measure (dimensionless) of an undecided state that counts as different from zero.
    weak
        Limit of weakly controlled waves: largest ratio of their frequency to the frequency of the slowest material wave with the same wave vector. It
        is compared with ``answer.discretization.weakest_mode``, in the reference configuration.

    Returns
    -------
    State
        Verdict with its evidence. Its parts ``material`` and ``discretization`` have the numbers of both.

    Raises
    ------
    InputError
        If the law or the method is not defined at the state.

    Examples
    --------
    >>> sph = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
    >>> answer = onset.state("neo-hooke", sph, stretch=(1.1, 1.0))
    >>> answer.verdict, answer.mechanism
    ('numerical', 'tensile')
    """
    problem = problem_of(material, method)
    proof = between(tolerance, "tolerance", 0.0, np.nextafter(1.0, 0.0), "a number above 0 and below 1, for example 1e-3")
    given, gradient = state_as_typed(F, stretch)
    answer = State(problem.state(given, gradient, proof if switch(certify, "certify") else None, share(weak, "weak")))
    here = np.ascontiguousarray(answer.deformation_gradient, dtype=np.float64).reshape(1, 9)
    return answer._with_spectrum(lambda k: _waves_at(problem, here, k))._of(lambda: Cell.of(problem, given, gradient, here))


def _waves_at(problem: _onset.Problem, states: Floats, k: Floats) -> tuple[Complexes, Floats]:
    """Returns the waves of particles and continuum of one state at wave vectors of shape (n, D)."""
    k = np.ascontiguousarray(k)
    particles = received(problem.omega_squared(states, k), (len(k), problem.branches * 2)).view(np.complex128)
    continuum = received(problem.continuum_omega_squared(states, k), (len(k), problem.dimension))
    return particles, continuum


def _wave_vector(value: ArrayLike, dimension: int) -> Floats:
    """Returns one wave vector."""
    given = np.atleast_1d(finite(value, "wave_vector"))
    if given.shape != (dimension,):
        raise InputError(f"wave_vector has the shape {given.shape}; expected ({dimension},)")
    return given


def _wave_vectors(k: ArrayLike, dimension: int) -> tuple[Floats, tuple[int, ...]]:
    """Returns wave vectors as rows, and the shape of the other axes."""
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
    """Plane waves ``g exp(i omega t + i k.X)`` of one state at many wave vectors.

    The particles satisfy ``omega^2 g = D(k) g``, and the continuum ``rho_0 omega^2 g = Q(k) g``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    k
        Reference wave vectors, shape (..., D); 1/length.
    stretch
        Principal stretches along the axes, shape (D,) to (3,); missing stretches are 1.
    F
        Deformation gradient instead of `stretch`, shape (3, 3) or (D, D).

    Returns
    -------
    Dispersion
        Waves of particles and continuum, as arrays of the shape of `k`.

    Raises
    ------
    InputError
        If more than one state is given; ``onset.omega_squared`` accepts many states.

    Examples
    --------
    >>> waves = onset.dispersion("neo-hooke", k=[(1, 0), (2, 0)], stretch=(1, 1))
    >>> waves.frequencies.shape
    (2, 2)
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    if shape:
        raise InputError(f"dispersion accepts one state; the states have the shape {shape}\n  hint: onset.omega_squared accepts many states")
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
    """Squared frequencies ``omega^2 g = D(k) g`` of the particles, for many states and many wave vectors.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    k
        Reference wave vectors, shape (n, D) or (D,); 1/length.
    stretch
        Principal stretches of the states, shape (..., D) to (..., 3).
    F
        Deformation gradients instead of `stretch`, shape (..., 3, 3) or (..., D, D).

    Returns
    -------
    Complexes
        ``omega^2`` by increasing real part, shape (..., n, branches), or (..., branches) for one wave vector; 1/time^2.

    Raises
    ------
    InputError
        If a state is not a deformation, or the law or the method is not defined there.

    Examples
    --------
    >>> onset.omega_squared("neo-hooke", k=[(1, 0), (2, 0)], stretch=[(1, 1), (1.1, 1), (1.2, 1)]).shape
    (3, 2, 2)
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
    """Dynamical matrix ``D(k)``: its eigenvalues are ``omega^2``, its eigenvectors the polarizations of the particles of a cell.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    k
        Reference wave vectors, shape (n, D) or (D,); 1/length.
    stretch
        Principal stretches of the states, shape (..., D) to (..., 3).
    F
        Deformation gradients instead of `stretch`, shape (..., 3, 3) or (..., D, D).

    Returns
    -------
    Complexes
        ``D(k)``, shape (..., n, branches, branches), or (..., branches, branches) for one wave vector; 1/time^2.

    Raises
    ------
    InputError
        If a state is not a deformation, or the law or the method is not defined there.

    Examples
    --------
    >>> onset.dynamical_matrix("neo-hooke", k=(1, 0), stretch=(1.1, 1)).shape
    (2, 2)
    """
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    vectors, around = _wave_vectors(k, problem.dimension)
    branches = problem.branches
    matrices = received(problem.dynamical_matrices(states, vectors), (*shape, *around, branches, branches * 2))
    return matrices.view(np.complex128)


def _state_or_reference(F: ArrayLike | None, stretch: ArrayLike | None, dimension: int) -> tuple[str | None, str | None]:
    """Returns a state in the notation of the command line, by default the reference configuration."""
    return state_as_typed(F, (1.0,) * dimension if F is None and stretch is None else stretch)


@asks
def waves(
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    wave_vector: ArrayLike,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
) -> Waves:
    """Waves with one wave vector, ``omega^2 g = D(k) g``: ``onset dispersion --wave-vector``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    wave_vector
        Reference wave vector, shape (D,); 1/length.
    stretch
        Principal stretches along the axes, shape (D,) to (3,); missing stretches are 1. The reference configuration if `stretch` and `F` are omitted.
    F
        Deformation gradient instead of `stretch`, shape (3, 3) or (D, D).

    Returns
    -------
    Waves
        Waves with ``omega_squared``, ``continuum_omega_squared`` and ``dynamical_matrix``.

    Raises
    ------
    InputError
        If the wave vector has a wrong number of components, or the state cannot be evaluated.

    Examples
    --------
    >>> onset.waves("neo-hooke", wave_vector=(1, 0), stretch=(1, 1)).omega_squared.shape
    (2,)
    """
    problem = problem_of(material, method)
    given, gradient = _state_or_reference(F, stretch, problem.dimension)
    answer = Waves(problem.waves(given, gradient, typed(_wave_vector(wave_vector, problem.dimension))))
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
    """Dispersion relation ``omega(k)`` along a path through the zone, with the density of states: ``onset dispersion --path``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    stretch
        Principal stretches along the axes, shape (D,) to (3,); missing stretches are 1. The reference configuration if `stretch` and `F` are omitted.
    F
        Deformation gradient instead of `stretch`, shape (3, 3) or (D, D).
    path
        Names of points of high symmetry (``"G-M-K-G"``), or points in units of the reciprocal vectors (``"0,0; 0.5,0; K"``); all inequivalent points
        of high symmetry if omitted.

    Returns
    -------
    Bands
        Waves at samples ``k`` along the path, with ``corners`` and their ``labels``.

    Raises
    ------
    InputError
        If the zone has no point with a given name; the message lists the names.

    Examples
    --------
    >>> onset.bands("neo-hooke", onset.Method(lattice="square"), stretch=(1, 1), path="G-X-M-G").labels
    ('Γ', 'X', 'M', 'Γ', 'k*')
    """
    problem = problem_of(material, method)
    given, gradient = _state_or_reference(F, stretch, problem.dimension)
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
    """Loss and recovery of stability along a path of deformations: ``onset path``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    to, from_
        End and start of the path: stretches, or deformation gradients of shape (D, D) or (3, 3). With `mode` both are imposed stretches (`from_` is 1
        if omitted), or amounts of shear in simple shear (`from_` is 0 if omitted).
    mode
        Loading: ``uniaxial``, ``equibiaxial``, ``planar``, ``simple-shear`` or ``hydrostatic``.
    lateral
        Condition on the other directions: ``free``, ``plane-stress``, ``plane-strain`` or ``held``; the least constrained condition of the loading if
        omitted.

    Returns
    -------
    Path
        Crossings of the boundary of stability, for the material and for the discretization.

    Raises
    ------
    InputError
        If `lateral` is given without `mode`.

    Examples
    --------
    >>> answer = onset.path("blatz-ko", from_=(1, 1), to=(4, 1))
    >>> round(float(answer.material_onset.stretch[0]), 4)
    3.7321
    """
    problem = problem_of(material, method)
    if mode is not None:
        rest = 0.0 if isinstance(mode, str) and mode == "simple-shear" else 1.0
        start = rest if from_ is None else number(from_, "from_")
        return Path(problem.loading_path(mode, lateral, start, number(to, "to")))
    if lateral is not None:
        raise InputError("`lateral` requires `mode`")
    if from_ is None:
        raise InputError("a path needs `from_` and `to`; `from_` is optional only with `mode`")
    return Path(problem.straight_path(_end(from_, "from_"), _end(to, "to")))


def _end(given: ArrayLike, what: str) -> str:
    """Returns the end of a path in the notation of the command line."""
    array = numbers(given, what)
    return components(array) if array.ndim == 2 else typed(array)


@asks
def verdicts(
    material: MaterialLike = None,
    method: MethodLike = None,
    F: ArrayLike | None = None,
    *,
    stretch: ArrayLike | None = None,
    waves: int | None = None,
) -> Verdicts:
    """Verdicts on many states, computed as in a map, on all cores and without the interpreter's lock.

    A state at which the law or the method is not defined has the verdict ``undefined``.

    With `waves` the verdicts are sampled, not searched: an instability between the wave vectors of the grid is missed, so that ``growth_rate`` is a
    lower bound, and ``critical_time_step`` an upper bound unless forces are damped. The law is assessed in full, and long waves are tested if
    the law or a wave of the grid is unstable.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    F
        Deformation gradients, shape (..., 3, 3) or (..., D, D).
    stretch
        Principal stretches instead of `F`, shape (..., D) to (..., 3).
    waves
        Number of wave vectors along each reciprocal vector, from 2 to 48, for a coarse zone; by default the zone is searched. A multiple of 6 includes
        the points of high symmetry.

    Returns
    -------
    Verdicts
        Arrays of the shape of the states; ``verdict`` has the names.

    Raises
    ------
    InputError
        If a state is not a deformation, ``det F <= 0``.

    Examples
    --------
    >>> onset.verdicts("neo-hooke", "updated-sph", stretch=[(1, 1), (1.1, 1)]).verdict.tolist()
    ['zero-energy', 'numerical']
    """
    count = None if waves is None else whole(waves, "waves", 2, 48)
    problem = problem_of(material, method)
    states, shape = deformations(F, stretch, problem.dimension)
    steps = partial(problem.critical_time_steps, states) if problem.is_damped else None
    return Verdicts(problem.verdicts(states, count), shape, problem.dimension, steps)


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
    """Simulation of the particles of a periodic patch, and the measured rate of a wave: ``onset simulate``.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    stretch
        Principal stretches along the axes, shape (D,) to (3,); missing stretches are 1.
    F
        Deformation gradient instead of `stretch`, shape (3, 3) or (D, D).
    cells
        Number of cells along the primitive vectors, one number or D.
    mode
        Initial motion: ``"critical"``, the critical wave of the patch, or ``"noise"``, random displacements.
    wave_vector
        Reference wave vector of the initial wave instead of `mode`, shape (D,); 1/length.
    turns
        Number of wavelengths of the initial wave along each side of the patch, instead of `wave_vector`.
    branch
        Number of the wave with this wave vector, counted from 1 by increasing ``omega^2``.
    amplitude
        Largest initial displacement, in particle spacings.
    seed
        Seed of the random displacements.
    steps, time
        Number of steps, or duration; if both are omitted, about a period, four e-folding times of growth or one of decay.
    fraction, time_step
        Time step as a fraction of the largest stable step, or as a time; 0.5 or less of the largest stable step if both are omitted, or
        ``discretization.time-step`` for a transfer of material points, if set.
    supercritical
        Allow a time step above the largest stable step.
    integrator
        If omitted, the integrator of the method, which is ``kick-drift-kick`` by default. ``kick-drift-kick``, ``central-differences``, ``predictor-corrector``, ``sixth-order`` or a Runge-Kutta method of
        ``onset.limit``. A transfer of material points defines its step and accepts no integrator.
    tolerance
        Largest relative difference between rates that agree.
    out
        Folder for the history, the fields and the checkpoints.
    every, fields, checkpoint
        Number of steps between lines of the history, number of fields, and number of steps between checkpoints (a checkpoint every five seconds if
        omitted).
    resume, overwrite
        Resume from the checkpoint in `out`, or start a new run.

    Returns
    -------
    Simulation
        Predicted and measured rate, and the outcome of their comparison.

    Raises
    ------
    InputError
        If a wave does not fit into the patch; the message contains the nearest wave that does.
    MachineError
        If the motion breaks down.

    Examples
    --------
    >>> method = onset.Method("total-lagrangian-sph", lattice="square")
    >>> onset.simulate("neo-hooke", method, stretch=(1, 1), turns=(1, 0), cells=4).outcome
    'agrees'
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
            None if wave_vector is None else [float(x) for x in _wave_vector(wave_vector, problem.dimension)],
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
def screen(
    x: Any,
    X: ArrayLike | None = None,
    time: ArrayLike | None = None,
    material: MaterialLike = None,
    method: MethodLike = None,
    *,
    velocity: Any = None,
    F: Any = None,
    stress: Any = None,
    held: ArrayLike | None = None,
    volumes: ArrayLike | None = None,
    elements: ArrayLike | None = None,
    region: tuple[ArrayLike, ArrayLike] | None = None,
    time_step: float | None = None,
    stepping: str = "velocity-verlet",
    threshold: float = 0.05,
    seed: float | None = None,
    bin: float = 0.001,
    actual: float | None = None,
    fields: bool = False,
) -> Screening:
    """First cause of an instability in a run of your own code: ``onset screen``.

    The gradient of each particle follows from the positions of its neighbors by least squares. The amplitude of short waves is predicted as
    ``a_0 exp(integral of gamma dt)``, where ``gamma`` is the largest real part of the roots of ``s^2 + s C(k) + D(k) = 0`` in the state of the
    particle. The cause is the first of lost ellipticity, a predicted amplitude above `threshold`, and a time step above the largest stable step of the
    body.

    Frames are read one by one as ``x[0]``, ``x[1]``, ..., and only one frame is in memory at a time. The arguments `x`, `velocity`, `F` and `stress` may
    be arrays, memory maps, datasets of h5py or zarr, or arrays of Dask.

    Parameters
    ----------
    x
        Positions of the particles in each frame, shape (frames, particles, D) or (frames, particles, 3); length. Frames after a position that is not
        finite, and frames with damaged records, are skipped with a note.
    X
        Reference positions, shape (particles, D) or (particles, 3); length. The first frame if omitted.
    time
        Time of each frame, shape (frames,), ascending; a frame that repeats a time is skipped. The numbers of the frames if omitted.
    material, method
        Material law and discretization; the defaults of the command if omitted.
    velocity
        Velocities, the shape of `x`; length/time. They improve the amplitude at the start.
    F
        Deformation gradients of the code, shape (frames, points, D, D) or (frames, points, 3, 3). They are compared with the positions.
    stress
        Cauchy stresses of the code, shape (frames, points, 3) as xx, yy, xy, or (frames, points, 6) as xx, yy, zz, xy, xz, yz. They are compared with
        the law.
    held
        True for particles with prescribed motion, shape (particles,).
    volumes
        Reference volumes, shape (particles,); length^D. The square or cube of the spacing if omitted.
    elements
        Node indices of each element in the order of VTK, shape (elements, nodes). States are then evaluated in the elements instead of the particles.
    region
        Lower and upper corner of a box of reference positions; other particles are not assessed.
    time_step
        Time step of the code. Its limit is not assessed if it is omitted.
    stepping
        ``velocity-verlet`` (also leapfrog and central differences), ``extrapolated-stress`` (LAMMPS smd/tlsph), ``late-density`` (smd/ulsph) or
        ``late-acceleration`` (PySPH).
    threshold
        Amplitude at which short waves count as observed; spacings.
    seed
        Amplitude of the waves when growth begins, in spacings; the short waves of the first frames if omitted.
    bin
        Width of the bins of stretch in which particles share a state.
    actual
        Time at whose nearest frame the lowest modes of the body are found: ``K u = omega^2 M u`` with ``K`` the tangent of the forces on all particles at
        their positions, minus the derivative of the forces with respect to the displacements. Held particles are fixed, and rigid motions are
        excluded. ``answer["actual"]`` has ``omega_squared`` (1/time^2), the growth rate (1/time) and the kind of each mode; ``modes()`` has its displacements.
    fields
        Keep the fields of all frames for ``fields()`` of the answer.

    Returns
    -------
    Screening
        First cause with its time and place, and a table of the frames.

    Raises
    ------
    InputError
        If shapes do not fit together, or a position of the first frame is not finite.

    Examples
    --------
    >>> X = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0)), axis=-1).reshape(-1, 2)
    >>> x = np.stack([X * (1 + 0.01 * n, 1) for n in range(3)])
    >>> onset.screen(x, material="neo-hooke", method=onset.Method("total-lagrangian-sph", lattice="square", penalty=0.5)).cause
    'none'
    """
    problem = problem_of(material, method)
    give, count, reference, given, repeated = frames_of(x, X, time, velocity, F, stress, problem.dimension)
    particles = len(reference)

    def of_particles(value: ArrayLike | None, what: str, kinds: str) -> Floats | None:
        if value is None:
            return None
        array = numbers(value, what, kinds)
        if array.shape != (particles,):
            raise InputError(f"{what} has the shape {array.shape}; expected ({particles},), a value for each particle")
        if not np.all(np.isfinite(array)):
            raise InputError(f"{what} has values that are not finite")
        return array

    fixed = of_particles(held, "held", "fiub")
    volume = of_particles(volumes, "volumes", "fiu")
    if volume is not None and not np.all(volume > 0):
        raise InputError("volumes has values that are not positive")
    nodes = None if elements is None else np.atleast_2d(numbers(elements, "elements"))
    if nodes is not None and not np.all((nodes >= 0) & (nodes < particles) & (nodes == np.floor(nodes))):
        raise InputError(f"elements refers to missing particles; expected whole numbers from 0 to {particles - 1}")
    corners = None if region is None else [typed(np.atleast_1d(numbers(corner, "region"))) for corner in region]
    kept: list[tuple[float, Mapping[str, bytes]]] = []
    asked: dict[str, object] = dict(
        reference=reference.tolist(),
        held=[False] * particles if fixed is None else [bool(is_held) for is_held in fixed],
        volumes=None if volume is None else volume.tolist(),
        elements=None if nodes is None else nodes.astype(int).tolist(),
        region=None if corners is None else ":".join(corners),
        stress_given=given,
        time_step=None if time_step is None else positive(time_step, "time_step"),
        stepping=stepping,
        threshold=share(threshold, "threshold"),
        seed=None if seed is None else share(seed, "seed"),
        bin=share(bin, "bin"),
        actual=None if actual is None else number(actual, "actual"),
        repeated=repeated,
    )
    take = (lambda _, now, found: kept.append((now, found))) if switch(fields, "fields") else None
    modes: list[bytes] = []
    return Screening(_onset.screen(problem, asked, count, give, take, modes.append), kept, modes)


@asks
def criteria(
    material: MaterialLike = None,
    *,
    range: tuple[float, float] = (0.1, 10.0),
    modes: Iterable[str] = (),
    incompressible: bool = False,
) -> Criteria:
    """First violation of each stability criterion of a law along standard loadings: ``onset criteria``.

    Parameters
    ----------
    material
        Material law; the default of the command if omitted.
    range
        Smallest and largest stretch.
    modes
        Modes of loading: ``uniaxial``, ``equibiaxial``, ``planar``, ``simple-shear``, ``hydrostatic``; all if omitted.
    incompressible
        Use the incompressible response of an isotropic law.

    Returns
    -------
    Criteria
        Losses and recoveries of each criterion for each loading.

    Raises
    ------
    InputError
        If a mode is unknown, or the law cannot be evaluated at ``F = 1``.

    Examples
    --------
    >>> frame = onset.criteria("blatz-ko", modes=["uniaxial"]).to_frame()
    >>> frame.loc[frame["criterion"] == "strong-ellipticity", "tension_lost"].round(3).tolist()
    [2.868, 2.685, 3.732]
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
    """Safe range of a law, the stretches at which it is strongly elliptic: ``onset card``.

    The range is computed as boxes of principal stretches, for any loading, and along standard loadings.

    Parameters
    ----------
    material
        Material law; the default of the command if omitted.
    range
        Smallest and largest stretch.
    modes
        Modes of loading: ``uniaxial``, ``equibiaxial``, ``planar``, ``simple-shear``, ``hydrostatic``; all if omitted.
    incompressible
        Use the incompressible response of an isotropic law.

    Returns
    -------
    Card
        Boxes of principal stretches, and the limits of each loading.

    Raises
    ------
    InputError
        If a mode is unknown, or the law cannot be evaluated at ``F = 1``.

    Examples
    --------
    >>> round(onset.card("blatz-ko", modes=["uniaxial"]).loadings[0].tension, 3)
    2.868
    """
    return Card(material_of(material)._law().card(_two(range, "range"), names(modes, "modes"), switch(incompressible, "incompressible")))


#: Test: arrays of stretches, nominal stresses and, if measured, lateral stretches, or a table with the names of columns of a file, or the path of a table.
Test = Sequence[ArrayLike] | Mapping[str, ArrayLike] | str | os.PathLike[str] | Any


@asks
def fit(
    tests: Mapping[str, Test] | Iterable[str | os.PathLike[str]] | str | os.PathLike[str],
    law: str | Iterable[str] = "all",
    *,
    weights: str = "relative",
    weight: Mapping[str, float] | None = None,
    floor: float | None = None,
    stable: str | None = "data",
    criterion: str = "both",
    margin: float = 1e-6,
    starts: int = 64,
    fix: Mapping[str, float] | None = None,
    bound: Mapping[str, tuple[float, float]] | None = None,
    bulk: float | None = None,
    unit: str | None = None,
    area: float | None = None,
    range: tuple[float, float] | None = None,
    material: str | None = None,
) -> Fit:
    """Laws fitted to tests, stable in the range where they are used: ``onset fit``.

    The constants ``c`` minimize ``sum_i (P(lambda_i, c) - P_i)^2 / s_i^2`` over the points of all tests, as in Ogden, Saccomandi and Sgura, Comput. Mech. 34
    (2004) 484. ``P`` is the nominal stress of the incompressible specimen, ``(w_1 - w_3) / lambda_1`` with ``w_i = dW/d ln(lambda_i)`` and the free face 3, or
    the stress of a foam with free lateral faces. The scale ``s_i`` is the measured stress or 1. The criteria are satisfied in the whole range of stretches:
    ``d^2 W / d ln(lambda_i) d ln(lambda_j)`` is positive definite on increments that keep the volume (Drucker), and ``m . Q(N) m > 0`` for all waves
    with the normal ``N`` and the amplitude ``m`` that keep the volume (strong ellipticity).

    Parameters
    ----------
    tests
        Mapping from the loading (``uniaxial``, ``equibiaxial``, ``planar``, ``simple-shear``, ``volumetric``) to a test, or paths of tables whose
        names or comments contain the loading, or of a list of tests (TOML). A test is the path of a table, a pair of arrays of shape (n,), or a table, for
        example of pandas, with the names of columns of a file: ``stretch`` or ``strain [%]``, ``nominal_stress [MPa]``, ``true_stress`` or ``force``,
        and ``lateral_stretch`` if it was measured. The arrays are stretch (dimensionless) and nominal stress (stress), and may be followed by the lateral
        stretch. Simple shear has the amount of shear as stretch, and a volumetric test the volume ratio and the pressure.
    law
        Names of laws, or ``all``; if the volume of the specimens changes, ``all`` are the laws of foam.
    weights
        ``relative`` (``s_i`` is the measured stress), ``by-test`` (relative, with the same weight for each test) or ``absolute``.
    weight
        Weights of the squared errors of tests by their loading, for example ``{"equibiaxial": 3}``; 1 if omitted.
    floor
        Smallest scale of relative errors, as a fraction of the largest stress of the test, from 0 to 1; 0, and 0.02 with ``by-test``, if omitted.
    stable
        Range of the stability constraint: ``data`` (up to 1.25 times the largest stretch of the tests), ``data=FACTOR``, ``box=LOW,HIGH`` (all
        principal stretches), ``loadings=LOW,HIGH`` (uniaxial, equibiaxial and planar), or ``None``.
    criterion
        Required criterion: ``drucker``, ``ellipticity`` or ``both``.
    margin
        Smallest value of a criterion, as a fraction of its value in the reference configuration.
    starts
        Number of initial guesses for constants in which a law is nonlinear.
    fix, bound
        Values, and lower and upper bounds, of constants by name.
    bulk
        Bulk modulus of the fitted law; stress. From a volumetric test, or 1000 shear moduli, if omitted.
    unit
        Unit of stress of tests without a unit, for example ``MPa``.
    area
        Undeformed area of the cross-section, which converts the forces of a table to nominal stresses; length^2.
    range
        Smallest and largest stretch of the points that are used.
    material
        Material whose tests are read from a deck of Abaqus or Ansys with several materials: its name or its number.

    Returns
    -------
    Fit
        Fitted laws, the best first; ``constants`` and ``material`` are of the best.

    Raises
    ------
    InputError
        If a test contradicts itself or another test, or no law can be fitted.

    Examples
    --------
    >>> stretch = np.linspace(1.1, 2, 10)
    >>> answer = onset.fit({"uniaxial": (stretch, 0.5 * (stretch - stretch**-2))}, "neo-hooke")
    >>> answer.law, round(answer.constants["mu"], 6)
    ('neo-hooke-isochoric', 0.5)
    """
    laws = [part.strip() for name in names(law, "law") for part in name.split(",")]
    part = None if floor is None else number(floor, "floor")
    asked: dict[str, object] = dict(
        tests=_tests(tests),
        law=laws,
        weights=weights,
        weight=[(name, positive(value, f"weight[{name!r}]")) for name, value in (weight or {}).items()],
        floor=part if part is None or part == 0.0 else share(part, "floor"),
        stable=stable if stable is not None else "none",
        criterion=criterion,
        margin=share(margin, "margin"),
        starts=whole(starts, "starts", 1, 10_000),
        fix=[(name, _finite(value, f"fix[{name!r}]")) for name, value in (fix or {}).items()],
        bound=[(name, _limits(value, f"bound[{name!r}]")) for name, value in (bound or {}).items()],
        bulk=None if bulk is None else positive(bulk, "bulk"),
        unit=unit,
        area=None if area is None else positive(area, "area"),
        range=None if range is None else pair(range, "range"),
        material=material,
    )
    return Fit(_onset.fit(asked))


def _finite(given: object, what: str) -> float:
    value = number(given, what)
    if not np.isfinite(value):
        raise InputError(f"{what} is {value!r}; expected a finite number")
    return value


def _limits(given: ArrayLike, what: str) -> tuple[float, float]:
    low, high = _two(given, what)
    if not low < high:
        raise InputError(f"{what} expects two numbers, the smaller one first, for example (-5, 10)")
    return low, high


#: Loading, path, arrays, and columns by name of a test.
_Given = tuple[str | None, str | None, list[list[float]], list[tuple[str, list[str]]]]


def _tests(tests: Any) -> list[_Given]:
    """Returns the loading of each test with its path, its arrays or its columns."""
    if isinstance(tests, (str, os.PathLike)):
        tests = [tests]
    if hasattr(tests, "columns"):
        raise TypeError('tests is a table; expected the loading of each test, for example {"uniaxial": table}')
    found: list[_Given] = []
    if not isinstance(tests, Mapping):
        found = [(None, place(path, "tests"), [], []) for path in listed(tests, "tests")]
    else:
        for mode, test in tests.items():
            if not isinstance(mode, str):
                raise TypeError(f"tests has the key {mode!r}; expected the name of a loading")
            found.append(_test(test, mode, f"tests[{mode!r}]"))
    if not found:
        raise InputError('tests is empty\n  hint: for example {"uniaxial": (stretch, stress)}')
    return found


def _cells(values: Any, what: str) -> list[str]:
    """Returns the cells of a column of a table; texts are read, or ignored, with the names of the columns."""
    try:
        array = numbers(values, what)
    except TypeError:
        return [str(value) for value in np.asarray(values).tolist()]
    if array.ndim != 1:
        raise InputError(f"{what} has the shape {array.shape}; expected (n,)")
    return [repr(value) for value in array.tolist()]


def _test(test: Any, mode: str, what: str) -> _Given:
    """Returns a test that is a path, a table with names of columns, or arrays."""
    if isinstance(test, (str, os.PathLike)):
        return mode, place(test, what), [], []
    if isinstance(test, Mapping) or hasattr(test, "columns"):
        names = list(test if isinstance(test, Mapping) else test.columns)
        return mode, None, [], [(str(name), _cells(test[name], f"{name} of {what}")) for name in names]
    items = listed(test, what)
    if len(items) not in (2, 3):
        raise InputError(f"{what} has {len(items)} parts; expected two arrays, stretch and nominal stress, or three with the lateral stretch")
    arrays = []
    for name, values in zip(("stretch", "nominal_stress", "lateral_stretch"), items, strict=False):
        array = numbers(values, f"{name} of {what}")
        if array.ndim != 1:
            raise InputError(f"{name} of {what} has the shape {array.shape}; expected (n,)")
        arrays.append(array.tolist())
    return mode, None, arrays, []


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
    """Checks that a law has an energy and a consistent tangent: ``onset audit``.

    The checks use finite differences: ``P_iJ = dW/dF_iJ``, ``A_iJkL = dP_iJ/dF_kL``, objectivity, the work around closed loops, and more.

    Parameters
    ----------
    material
        Material law; the default of the command if omitted.
    strain
        Magnitude of the strains of the states, above 0 and at most 0.8, unless states are given.
    stretch, F
        List of states: principal stretches, or deformation gradients.
    convention
        Convention in which the tangent of a built-in law is checked: ``first-piola``, ``jaumann-kirchhoff``, ``truesdell``, ...

    Returns
    -------
    Audit
        Checks with their largest errors, and the verdict ``consistent``.

    Raises
    ------
    InputError
        If the convention is unknown; the message lists the names.

    Examples
    --------
    >>> onset.audit("neo-hooke").consistent
    True
    """
    size = between(strain, "strain", 0.0, 0.8, "a number above 0 and at most 0.8, for example 0.05")
    stretches = [typed(numbers(one, "stretch")) for one in listed(stretch, "stretch")]
    return Audit(material_of(material)._law().audit(size, stretches, [components(one) for one in listed(F, "F")], convention))


@asks
def localize(model: Material | str | None = None, path: str | None = None, load: str | None = None, **parameters: Value) -> Localization:
    """Localization of a plastic material along a loading, with the band and its angle: ``onset localize``.

    A band with the normal ``n`` can form where ``det(n.L.n) = 0``, with the tangent ``L`` of continued flow.

    Parameters
    ----------
    model, path, load
        Plastic law (its name, or a `Material`; ``"drucker-prager"`` by default), path of loading, and its sense, tension or compression.
    **parameters
        Parameters of the law, as for `Material`, and keys of the path (``strain_ratio``, ``strains``, ``bands``, ``slip``):
        ``onset.localize("drucker-prager", "plane-strain", friction=0.7)``. Stresses are in any consistent unit, or all have a unit.

    Returns
    -------
    Localization
        Localization with its band, and the path to it.

    Raises
    ------
    InputError
        If the law, the path or a parameter is invalid.

    Examples
    --------
    >>> answer = onset.localize("j2", "plane-strain")
    >>> answer.to_frame().columns[0]
    'plastic_shear_strain'
    >>> rock = onset.Material("drucker-prager", friction=0.7)
    >>> onset.localize(rock, "plane-strain")["localization"]["band"]["kind"]
    'dilatant-shear-band'
    """
    law = model.assignments if isinstance(model, Material) else ()
    is_routine = not {"material.model=umat", "material.model=library"}.isdisjoint([*law, f"material.model={model}"])
    of_path = {"path", "load", "strain_ratio", "strains", "bands", "slip"} | ({"confinement"} if is_routine else set())
    named = {"model": None if law else model, "path": path, "load": load} | parameters
    keys = {_key("plasticity" if name in of_path else "material", name): value for name, value in named.items() if value is not None}
    return Localization(_onset.localize([*law, *(f"{key}={_typed(value, key)}" for key, value in keys.items())]))


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

    Parameters
    ----------
    method, material
        Discretization and material law; the defaults of the command if omitted.
    weak
        Largest ratio of the frequency of a listed wave to the frequency of the slowest material wave with the same wave vector.
    cells
        Number of cells along each primitive vector of the patch that is drawn, and exported by ``save``.
    amplitude
        Largest displacement of the drawn and exported modes, in particle spacings.

    Returns
    -------
    Modes
        List of modes, zero-energy modes first.

    Raises
    ------
    InputError
        If the law or the method is invalid, or the patch is too large.

    Examples
    --------
    >>> onset.modes(onset.Method("total-lagrangian-sph", lattice="square")).to_frame()["nullity"].tolist()
    [2, 2, 2]
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
    """Smallest sufficient coefficient of a stabilization: ``onset tune``.

    A sufficient coefficient removes the spurious modes and does not mask the instability of the material.

    Parameters
    ----------
    method
        Discretization.
    key
        Key of ``[discretization]`` with a numerical value: ``onset.tune(method, "penalty")``.
    material
        Material law; the default of the command if omitted.
    range
        Smallest and largest value in the search, in the unit of the key.
    stretches
        Smallest and largest stretch of the states where verdicts are compared.
    weak
        Limit of weakly controlled waves, relative to the frequency of the slowest material wave.
    wrong
        Largest accepted fraction of states with a wrong verdict.
    later
        Largest accepted delay of the onset, relative to the strain at the onset of the material.

    Returns
    -------
    Tuning
        Values that were tried; ``recommended`` is the smallest sufficient value, or ``None``.

    Raises
    ------
    InputError
        If the method does not read the key.

    Examples
    --------
    >>> sph = onset.Method("total-lagrangian-sph", lattice="square")
    >>> answer = onset.tune(sph, "penalty", material="neo-hooke")
    >>> round(answer.recommended, 3)
    0.633
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
    time_step: float | str | None = None,
    keeps: Literal["stable"] | None = None,
    stretches: tuple[float, float] | None = None,
    stretch: ArrayLike | None = None,
    F: ArrayLike | None = None,
    range: tuple[float, float] | None = None,
    safety: float = 1.0,
    integrator: str | None = None,
) -> Limit:
    """Values of a modulus, spacing or coefficient that a time step admits, or that keep states stable: ``onset limit``.

    With `time_step` a value is admitted if the step is at most `safety` times the critical time step of the state. With ``keeps="stable"`` a value is
    admitted if the verdict on all states of a window of stretches is stable.

    Parameters
    ----------
    material, method
        Material law and discretization; the defaults of the command if omitted.
    vary
        Key with a numerical value, ``"material.young"`` or ``"discretization.spacing"``.
    time_step
        Time step; time. A text has a unit, ``"1 us"``.
    keeps
        ``"stable"``, instead of `time_step`.
    stretches
        With `keeps`: smallest and largest stretch along the axes; 0.7 to 1.5 if omitted.
    stretch, F
        State, as in ``onset.state``; ``F = 1`` if omitted.
    range
        Smallest and largest value in the search, in the unit of the key; 1e-6 to 1e6 times the present value if omitted.
    safety
        Safety factor, above 0 and at most 1.
    integrator
        If omitted, the integrator of the method (``Method(..., integrator="rk4")``), which is ``kick-drift-kick`` by default.
        ``central-differences``, ``kick-drift-kick`` or ``predictor-corrector``, which differ only with damping; or a Runge-Kutta method:
        ``forward-euler``, ``heun``, ``rk3``, ``rk4``, ``carpenter-kennedy``, ``rdpk3-35`` or ``rdpk3-49``.

    Returns
    -------
    Limit
        Values that were tried; ``intervals`` admit the time step.

    Raises
    ------
    InputError
        If the method does not read the key, or no value of the key can be evaluated.

    Examples
    --------
    >>> rubber = onset.Material("neo-hooke", young=2, poisson=0.4)
    >>> answer = onset.limit(rubber, vary="material.young", time_step=0.1)
    >>> len(answer.intervals)
    1
    """
    if not isinstance(vary, str):
        raise TypeError(f"vary is {type(vary).__name__}; expected the name of a key")
    if not isinstance(integrator, str | None):
        raise TypeError(f"integrator is {type(integrator).__name__}; expected a name")
    if (time_step is None) == (keeps is None):
        raise InputError('a limit has `time_step` or `keeps="stable"`\n  hint: give one of them')
    problem = problem_of(material, method)
    if time_step is None:
        if keeps != "stable" or stretch is not None or F is not None:
            raise InputError('expected keeps="stable" with `stretches`, without `stretch` and `F`')
        window = None if stretches is None else pair(stretches, "stretches")
        return Limit(problem.keeps(vary, window, None if range is None else pair(range, "range")))
    if stretches is not None:
        raise InputError('stretches has no effect with time_step\n  hint: give keeps="stable" instead')
    given = (None, None) if stretch is None and F is None else state_as_typed(F, stretch)
    step = time_step if isinstance(time_step, str) else repr(positive(time_step, "time_step"))
    ends = None if range is None else pair(range, "range")
    return Limit(problem.limit(vary, step, given, ends, share(safety, "safety"), integrator))


#: Methods to compare: a method, a list, a dictionary with names, or a file.
Methods = Method | Sequence[MethodLike] | Mapping[str, MethodLike] | os.PathLike[str] | str


def _comparison(methods: Methods, material: MaterialLike, options: Mapping[str, Value]) -> tuple[tuple[str, str], list[_onset.Function]]:
    """Returns a comparison as a file, and the law separately if it consists of Python functions."""
    if isinstance(methods, (str, os.PathLike)):
        if material is not None or options:
            raise InputError("a file is a complete comparison\n  hint: change it with `set`")
        return source(methods), []
    if isinstance(methods, Mapping):
        named: list[tuple[str | None, MethodLike]] = list(methods.items())
    else:
        named = [(None, method) for method in ([methods] if isinstance(methods, Method) else listed(methods, "methods"))]
    law = material_of(material)
    beside = [setting for setting in law._assigned() if isinstance(setting, _onset.Function)]
    text = "" if beside else f"[material]\n{law._section_text()}"
    if options:
        keys = {_key("compare", name): value for name, value in options.items()}
        text += "\n[compare]\n" + "".join(f"{key.partition('.')[2]} = {toml(value, key)}\n" for key, value in keys.items())
    for name, method in named:
        own = method_of(method)
        title = "" if name is None else f"name = {quoted(name, 'name')}\n"
        text += f"\n[[methods]]\n{title}{own._section_text()}"
    return ("comparison", text), beside


def _variation(name: object, values: object) -> str:
    """Returns the values of a key in the notation of ``--vary``."""
    if not isinstance(name, str):
        raise TypeError(f"a key of vary is {type(name).__name__}; expected its name")
    key = name if "." in name else _key("discretization", name)
    texts = [_typed(value, key) for value in listed(values, key)]
    return f"{key}={(';' if any(',' in text for text in texts) else ',').join(texts)}"


@asks
def compare(
    methods: Methods,
    material: MaterialLike = None,
    *,
    vary: Mapping[str, Sequence[Value]] | None = None,
    set: Iterable[str] = (),
    allow_library: Iterable[str | os.PathLike[str]] = (),
    **options: Value,
) -> Comparison:
    """Comparison of several methods for one material: ``onset compare``.

    Parameters
    ----------
    methods
        Method, list, dictionary with names, or file. Methods in a list are named after their families and what differs between them.
    material
        Material law; the default of the command if omitted.
    vary
        Keys of ``[discretization]`` with lists of values. Each method is replaced by its variants, one for each combination, as by ``--vary``.
    set
        Assignments as after ``--set``.
    allow_library
        Libraries that a file may load.
    **options
        Keys of ``[compare]``: ``stretches=(0.7, 1.5)``.

    Returns
    -------
    Comparison
        Table with one row for each method.

    Raises
    ------
    InputError
        If `methods` is a file, which is a complete comparison, and a material or options are also given.

    Examples
    --------
    >>> sph = onset.Method("updated-sph", lattice="square")
    >>> table = onset.compare(sph, "blatz-ko", vary={"kernel": ["cubic-spline", "wendland-c2"]}, states=4)
    >>> table.to_frame()["method"].tolist()
    ['kernel cubic-spline', 'kernel wendland-c2']
    """
    libraries = [place(path, "allow_library") for path in listed(allow_library, "allow_library")]
    file, law = _comparison(methods, material, options)
    if vary is not None and not isinstance(vary, Mapping):
        raise TypeError(f"vary is {type(vary).__name__}; expected keys with lists of values")
    variations = [_variation(name, values) for name, values in (vary or {}).items()]
    return Comparison(_onset.compare(file, [*law, *names(set, "set")], libraries, variations))


@asks
def zoo(name: str | None = None) -> Zoo | Report:
    """Instabilities that users of particle codes reported, or the answer for one of them: ``onset zoo``.

    Parameters
    ----------
    name
        Name of a report, for example ``trixi-371-cubic``; all reports are listed if omitted.

    Returns
    -------
    Zoo or Report
        The list, or the report with its answer, its remedy and the answer with the remedy.

    Raises
    ------
    InputError
        If no report has the name.

    Examples
    --------
    >>> report = onset.zoo("trixi-371-cubic")
    >>> isinstance(report, onset.Report)
    True
    """
    answer = _onset.zoo(name)
    return Zoo(answer) if name is None else Report(answer)


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
    """Ranking of methods for a material and a range of stretches: ``onset recommend``.

    Parameters
    ----------
    material
        Material law; the default of the command if omitted.
    methods
        Methods, as for ``onset.compare``; the built-in methods for the `dimension` if omitted.
    dimension
        Number of space dimensions.
    stretches
        Smallest and largest stretch of interest.
    weak, wrong
        Limits, as for ``onset.tune``.
    long_waves
        Largest accepted relative error of the long-wavelength moduli.
    wavelength
        Wavelength at which frequencies are compared: 4, 8 or 16 particle spacings.
    set
        Assignments as after ``--set``.
    allow_library
        Libraries that a file may load.

    Returns
    -------
    Recommendation
        Ranking, the reasons, and the comparison behind it.

    Raises
    ------
    InputError
        If a method or an option is invalid.

    Examples
    --------
    >>> answer = onset.recommend("neo-hooke", dimension=1)
    >>> answer.to_frame().columns.tolist()
    ['place', 'method', 'score', 'cost', 'rule', 'why']
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
    """Boundaries in the plane of a study where material and particles lose stability: ``onset boundary``.

    Parameters
    ----------
    study
        Study with two axes, or its file.
    flutter
        Also trace the boundary between flutter (complex ``omega^2``) and divergence (``omega^2 < 0``).

    Returns
    -------
    Boundary
        Curves in the coordinates of the axes; ``geojson`` and ``curves`` return them.

    Raises
    ------
    InputError
        If the study does not have two axes.

    Examples
    --------
    >>> axes = {"stretch-1": (0.8, 3.0, 8), "stretch-2": (0.8, 3.0, 8)}
    >>> study = onset.Study.of("blatz-ko", "updated-sph", axes)
    >>> len(onset.boundary(study).curves()) > 0
    True
    """
    return Boundary(study_of(study)._study.boundary(switch(flutter, "flutter")))


class Future(Protocol):
    """Result of a task of an executor."""

    def result(self) -> Any:
        """Waits for the result of the task."""

    def cancel(self) -> Any:
        """Cancels the task unless it has started."""


class Executor(Protocol):
    """Object with ``submit(function, *arguments)``, which runs a function elsewhere.

    Examples are an executor of ``concurrent.futures`` with processes, and a Dask client.
    """

    def submit(self, function: Callable[..., int], /, *arguments: Any) -> Future:
        """Submits a function with its arguments."""


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
    """Computes the map of a study into the store `out`, and returns a summary: ``onset map``.

    Ctrl-C interrupts the map. Stored tiles are kept, and `resume` computes the others.

    Parameters
    ----------
    out
        Folder of the store.
    study
        Study, or its file.
    tiles
        First tile, and the tile after the last; or a share, ``"1/8"`` to ``"8/8"``, whose tiles are spread evenly over the map. Several processes may
        compute parts of one store concurrently.
    resume, overwrite
        Resume an existing store, or replace it.
    executor
        Object with ``submit`` whose workers have access to `out`. Each tile is a task; the tiles of lost workers are computed in this process at the
        end.

    Returns
    -------
    Mapped
        Number of states with each verdict, and the path of the store.

    Raises
    ------
    InputError
        If the store exists, unless `resume` or `tiles` resume it or `overwrite` replaces it.

    Examples
    --------
    >>> axes = {"stretch-1": (0.8, 3.0, 8), "stretch-2": (0.8, 3.0, 8)}
    >>> study = onset.Study.of("blatz-ko", onset.Method(), axes)
    >>> onset.map_into("foam.zarr", study, overwrite=True).states
    64
    """
    part = None
    if isinstance(tiles, str):
        part = tiles
    elif tiles is not None:
        first, last = _two(tiles, "tiles")
        part = f"{whole(first, 'tiles', 0, MOST)}..{whole(last, 'tiles', 0, MOST)}"
    anew, again = switch(overwrite, "overwrite"), switch(resume, "resume")
    if anew and (again or part is not None):
        raise InputError("`overwrite` replaces the store; omit `resume` and `tiles`")
    folder, own = place(out, "out"), study_of(study)
    if executor is None:
        return Mapped(own._study.map(folder, part, again, anew))
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor is {type(executor).__name__}; expected an object with `submit`")
    if part is not None:
        raise InputError("an executor computes all tiles; omit `tiles`")
    _elsewhere(executor, own, os.path.abspath(folder), own._study.begin(folder, again, anew))
    return Mapped(own._study.map(folder, None, True, False))


def _elsewhere(executor: Executor, study: Study, folder: str, tiles: int) -> None:
    """Computes all tiles with an executor."""
    # The mark is unique, because a scheduler with a cache must not reuse the results of an earlier store.
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
    """Computes one tile of a store in a process of an executor; it may be repeated. `run` distinguishes tasks of different runs."""
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
    """Computes the map of a study into the store `out`, and opens it as a dataset.

    Requires xarray and zarr.

    Parameters
    ----------
    study
        Study, or its file.
    out
        Folder of the store.
    tiles, resume, overwrite, executor
        Parts of the map, as for ``onset.map_into``.

    Returns
    -------
    xarray.Dataset
        Dataset of ``xarray.open_zarr(out)``, with coordinates, units and attributes.

    Raises
    ------
    OnsetError
        If xarray or zarr is not installed.
    InputError
        If the store exists, unless `resume` or `tiles` resume it or `overwrite` replaces it.

    Examples
    --------
    >>> axes = {"stretch-1": (0.8, 3.0, 8), "stretch-2": (0.8, 3.0, 8)}
    >>> study = onset.Study.of("blatz-ko", onset.Method(), axes)
    >>> dict(onset.map(study, out="foam.zarr", overwrite=True).sizes)
    {'stretch-2': 8, 'stretch-1': 8, 'component': 2}
    """
    map_into(out, study, tiles=tiles, resume=resume, overwrite=overwrite, executor=executor)
    return open_map(out)


@asks
def open_map(store: str | os.PathLike[str]) -> xarray.Dataset:
    """Opens a store of ``onset map`` as a dataset: fields over the axes of the study, with coordinates, units and attributes.

    Parameters
    ----------
    store
        Folder of the store.

    Returns
    -------
    xarray.Dataset
        Dataset of the whole map; states of missing tiles have the fill values.

    Raises
    ------
    OnsetError
        If xarray or zarr is not installed.
    InputError
        If the store does not exist.

    Examples
    --------
    >>> axes = {"stretch-1": (0.8, 3.0, 8), "stretch-2": (0.8, 3.0, 8)}
    >>> made = onset.map_into("foam.zarr", onset.Study.of("blatz-ko", onset.Method(), axes), overwrite=True)
    >>> "verdict" in onset.open_map(made.store)
    True
    """
    folder = place(store, "store")
    try:
        import xarray
        import zarr  # noqa: F401
    except ImportError as error:
        raise OnsetError("opening a map requires xarray and zarr\n  hint: pip install xarray zarr") from error
    try:
        dataset: xarray.Dataset = xarray.open_zarr(folder)
    except Exception as error:
        raise InputError(f"cannot open {folder}: {error}\n  hint: expected a store written by `onset map`") from error
    return dataset


@asks
def keys(section: str = "") -> dict[str, str]:
    """Keys of settings by name, each with its meaning and the expected values.

    Parameters
    ----------
    section
        ``material``, ``discretization``, ``state`` or ``map``; all sections if omitted.

    Returns
    -------
    dict[str, str]
        Meaning and expected values by name of the key.

    Raises
    ------
    InputError
        If the section does not exist.

    Examples
    --------
    >>> "discretization.support" in onset.keys("discretization")
    True
    """
    if not isinstance(section, str):
        raise TypeError(f"section is {type(section).__name__}; expected a name")
    keys = _onset.keys()
    sections = sorted({name.split(".")[0] for name, _, _ in keys})
    if section and section not in sections:
        raise InputError(f"section {section!r} does not exist; expected {' or '.join(sections)}")
    return {name: f"{meaning}: {expects}" for name, expects, meaning in keys if not section or name.split(".")[0] == section}


def models() -> list[str]:
    """Names of the built-in laws, as in ``onset list materials``.

    Returns
    -------
    list[str]
        Names in the order of the list.

    Examples
    --------
    >>> "neo-hooke" in onset.models()
    True
    """
    return _onset.models()

