"""Arrays of states, waves and laws agree with single calls and with differences; the interpreter's lock is released."""

from __future__ import annotations

import pickle
import threading
import time

import numpy as np
import onset
import pytest

RUBBER = onset.Material("neo-hooke", mu=0.4, lambda_=2.0)
SPH = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
EULERIAN = onset.Method(frame="eulerian", support=1.6)


@pytest.mark.parametrize("method", [SPH, EULERIAN, onset.Method("total-lagrangian-sph", lattice="square"), onset.Method(lattice="chain")])
def test_array_verdicts_agree_with_single_states(method: onset.Method) -> None:
    chance = np.random.default_rng(3)
    dimension = 1 if "chain" in repr(method) else 2
    F = np.eye(3) + chance.uniform(-0.2, 0.2, (5, 20, 3, 3))
    many = onset.verdicts(RUBBER, method, F[..., :dimension, :dimension])
    assert many.codes.shape == (5, 20) and many.wave_vector.shape == (5, 20, dimension)
    assert sum(many.count().values()) == len(many) == 100
    for place in np.ndindex(5, 20):
        if many.verdict[place] == "undefined":
            continue
        one = onset.state(RUBBER, method, F=F[place][:dimension, :dimension])
        assert many.verdict[place] == one.verdict
        assert many.mechanism[place] == (one.mechanism or "")
        np.testing.assert_allclose(many.growth_rate[place], one.growth_rate, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(many.acoustic_minimum[place], one.minimum_acoustic_eigenvalue, rtol=1e-9, atol=1e-9)
        if one.critical_time_step is not None:
            np.testing.assert_allclose(many.critical_time_step[place], one.critical_time_step, rtol=1e-9)


@pytest.mark.parametrize("method", [SPH, EULERIAN, onset.Method("total-lagrangian-sph", lattice="square")])
def test_sampled_verdicts_follow_from_the_wave_vectors_of_the_grid(method: onset.Method) -> None:
    waves = 6
    stretches = np.random.default_rng(8).uniform(0.7, 1.5, (12, 2))
    sampled = onset.verdicts(RUBBER, method, stretch=stretches, waves=waves)
    reciprocal = 2 * np.pi * np.array([[1, 0], [0, 1]]) if "square" in repr(method) else 2 * np.pi * np.array([[1, -1 / np.sqrt(3)], [0, 2 / np.sqrt(3)]])
    shares = np.stack(np.meshgrid(np.arange(waves), np.arange(waves)), axis=-1) / waves
    for n, stretch in enumerate(stretches):
        squares = onset.dispersion(RUBBER, method, k=shares @ reciprocal, stretch=tuple(stretch)).omega_squared
        np.testing.assert_allclose(sampled.lowest_omega_squared[n], min(squares.real.min(), 0.0), rtol=1e-9, atol=1e-9 * abs(squares).max())
        np.testing.assert_allclose(sampled.critical_time_step[n], 2 / np.sqrt(squares.real.max()), rtol=1e-9)
    searched = onset.verdicts(RUBBER, method, stretch=stretches)
    assert np.all(sampled.growth_rate <= searched.growth_rate * (1 + 1e-9) + 1e-9)
    assert np.mean(sampled.codes == searched.codes) > 0.8
    for wrong in (1, 49, 2.5):
        with pytest.raises(onset.InputError, match="waves"):
            onset.verdicts(RUBBER, method, stretch=stretches, waves=wrong)


def test_damping_costs_verdicts_nothing_and_time_steps_are_searched_for_when_needed() -> None:
    viscous = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6, viscosity=0.1)
    stretches = [(1.0, 1.0), (1.1, 0.95)]
    many, plain = (onset.verdicts(RUBBER, method, stretch=stretches) for method in (viscous, SPH))
    assert many.verdict.tolist() == plain.verdict.tolist()
    assert many._steps is None
    again = pickle.loads(pickle.dumps(many))
    for n, stretch in enumerate(stretches):
        step = onset.state(RUBBER, viscous, stretch=stretch).discretization.damped_time_steps.kick_drift_kick
        np.testing.assert_allclose([many.critical_time_step[n], again.critical_time_step[n]], step, rtol=1e-6)


def test_results_do_not_depend_on_the_batch_size() -> None:
    stretches = np.random.default_rng(4).uniform(0.8, 1.3, (200, 2))
    many = onset.verdicts(RUBBER, EULERIAN, stretch=stretches)
    few = [onset.verdicts(RUBBER, EULERIAN, stretch=part) for part in np.split(stretches, 20)]
    assert np.array_equal(many.codes, np.concatenate([part.codes for part in few]))
    np.testing.assert_allclose(many.scaled_minimum, np.concatenate([part.scaled_minimum for part in few]), rtol=1e-10)


@pytest.mark.parametrize("shape", [(0, 2), (0, 3)])
def test_an_empty_array_gives_no_verdicts(shape: tuple[int, int]) -> None:
    assert onset.verdicts(RUBBER, SPH, stretch=np.empty(shape)).count().keys() >= {"stable"}
    assert len(onset.verdicts(RUBBER, SPH, stretch=np.empty(shape))) == 0


def test_arrays_of_wave_vectors_agree_with_single_wave_vectors() -> None:
    k = np.random.default_rng(5).uniform(-3, 3, (4, 6, 2))
    stretch = (1.1, 0.9)
    many = onset.dispersion(RUBBER, SPH, k=k, stretch=stretch)
    matrices = onset.dynamical_matrix(RUBBER, SPH, k=k, stretch=stretch)
    for place in np.ndindex(4, 6):
        one = onset.waves(RUBBER, SPH, wave_vector=k[place], stretch=stretch)
        assert np.array_equal(many.omega_squared[place], one.omega_squared)
        assert np.array_equal(many.continuum_omega_squared[place], one.continuum_omega_squared)
        assert np.array_equal(matrices[place], one.dynamical_matrix)
    # The order of conjugate eigenvalues must not depend on rounding.
    sorted_omega_squared, eigenvalues = (np.sort_complex(np.round(values, 10)) for values in (many.omega_squared, np.linalg.eigvals(matrices)))
    np.testing.assert_allclose(sorted_omega_squared, eigenvalues, rtol=1e-9, atol=1e-9)
    F = np.array([np.diag([a, 0.9, 1.0]) for a in (1.0, 1.1)])
    both = onset.omega_squared(RUBBER, SPH, k=k, F=F)
    assert both.shape == (2, 4, 6, 2)
    assert np.array_equal(both[1], many.omega_squared)


def test_bands_agree_with_single_wave_vectors() -> None:
    bands = onset.bands(RUBBER, SPH, stretch=(1.1, 1.0), path="G-X-M-G")
    assert bands.omega_squared.shape == (len(bands.k), 2) and bands.labels[0] == "Γ"
    again = onset.omega_squared(RUBBER, SPH, k=bands.k, stretch=(1.1, 1.0))
    np.testing.assert_allclose(bands.omega_squared, again, rtol=1e-12, atol=1e-12)


def test_stress_and_tangent_are_derivatives_of_the_energy() -> None:
    chance = np.random.default_rng(6)
    F = np.eye(3) + chance.uniform(-0.2, 0.2, (7, 3, 3))
    formula = onset.Material("mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*ln(J)^2", mu=0.4, lambda_=2.0)
    h = 1e-5
    stress, tangent = formula.stress(F), formula.tangent(F)
    for i, j in np.ndindex(3, 3):
        step = np.zeros((3, 3))
        step[i, j] = h
        difference = (formula.energy(F + step) - formula.energy(F - step)) / (2 * h)
        np.testing.assert_allclose(stress[:, i, j], difference, rtol=1e-6, atol=1e-8)
        difference = (formula.stress(F + step) - formula.stress(F - step)) / (2 * h)
        np.testing.assert_allclose(tangent[..., i, j], difference, rtol=1e-6, atol=1e-7)
    # Stress and tangent agree with the answer for a state.
    plane = np.array([[1.1, 0.2, 0.0], [0.1, 0.9, 0.0], [0.0, 0.0, 1.0]])
    one = onset.state(formula, SPH, F=plane)
    assert np.array_equal(one.material.first_piola, formula.stress(plane))
    assert np.array_equal(one.material.tangent, formula.tangent(plane))
    # Layout of FElupe: components first.
    (gradient, _), (hessian,) = formula.gradient([np.moveaxis(F, 0, -1)]), formula.hessian([np.moveaxis(F, 0, -1)])
    assert gradient is not None
    assert np.array_equal(gradient, np.moveaxis(stress, 0, -1)) and np.array_equal(hessian, np.moveaxis(tangent, 0, -1))


def test_a_block_of_another_program_gives_the_same_law() -> None:
    block = "*HYPERELASTIC, OGDEN, N=1\n2.0, 4.0, 0.02"
    law = onset.Material.read(block, "abaqus")
    same = onset.Material("ogden", mu1=1, alpha1=4, mu2=0, mu3=0, kappa=100)
    F = np.diag([1.2, 0.9, 1.0])
    np.testing.assert_allclose(law.stress(F), same.stress(F), rtol=1e-14)


def test_the_interpreter_runs_while_states_are_computed() -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    begun = time.perf_counter()
    stretches = np.random.default_rng(7).uniform(0.7, 1.5, (20_000, 2))
    onset.verdicts(RUBBER, SPH, stretch=stretches)
    took = time.perf_counter() - begun
    before = counted
    done.set()
    other.join()
    # The counter would have stayed at zero if the lock had been held.
    assert took > 0.05 and before > 0.1 * took / 0.001, (before, took)


def test_responses_do_not_depend_on_batches_and_errors_count_all_states() -> None:
    F = np.eye(3) + np.random.default_rng(6).uniform(-0.1, 0.1, (40000, 3, 3))
    stress = RUBBER.stress(F)
    for place in (0, 32767, 32768, 39999):
        np.testing.assert_allclose(stress[place], RUBBER.stress(F[place]), rtol=1e-12, atol=1e-15)
    F[35000] = -F[35000]
    with pytest.raises(onset.InputError, match="state 35000"):
        RUBBER.energy(F)
    for shape in [(3,), (2, 2), (0, 3, 2)]:
        with pytest.raises(onset.InputError, match="F has the shape"):
            RUBBER.energy(np.ones(shape))
    assert RUBBER.energy(np.zeros((0, 3, 3))).shape == (0,)
