"""Exported modes and bands: displacements of plane waves, forces on supercells, and files that other packages read."""

from __future__ import annotations

from pathlib import Path
import sys

import numpy as np
import onset
from onset._settings import problem_of
import pytest

RUBBER = onset.Material("neo-hooke", mu=0.4, lambda_=2.0)
SPH = onset.Method("total-lagrangian-sph", lattice="square", kernel="cubic-spline", support=2.6)
TURN = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
SHEARED = TURN @ np.array([[1.1, 0.2], [0.0, 0.9]])
#: Number of cells along a side of a supercell.
SIDE = 4


def wave_vector(method: onset.Method, *turns: float) -> np.ndarray:
    """A wave vector in units of the reciprocal vectors."""
    return np.asarray(np.array(turns) @ np.array(problem_of(RUBBER, method).reciprocal))


@pytest.mark.parametrize(
    "method",
    [
        SPH.replace(penalty=0.2),
        onset.Method("updated-sph", lattice="hexagonal", kernel="cubic-spline", support=2.2),
        onset.Method("total-lagrangian-sph", lattice="honeycomb", kernel="cubic-spline", support=3.0),
        # Method with complex omega^2.
        onset.Method(lattice="square", frame="eulerian", support=1.6),
    ],
)
@pytest.mark.parametrize("turns", [(0.25, 0.5), (0.5, 0.0), (0.25, -0.25)])
def test_forces_on_a_supercell_agree_with_the_plane_wave(method: onset.Method, turns: tuple[float, float]) -> None:
    # One cell contains the whole patch, so D(0) gives the forces for any displacement, divided by the masses.
    # A perturbation below the tolerance prevents the reduction to the primitive cell.
    whole = method.replace(cells=SIDE, perturbation=1e-13)
    forces = onset.dynamical_matrix(RUBBER, whole, k=np.zeros(2), F=SHEARED)
    places = np.array(problem_of(RUBBER, whole).cell(None, ",".join(map(str, SHEARED.ravel())))[0])
    edges = 2 * np.pi * np.linalg.inv(np.array(problem_of(RUBBER, whole).reciprocal)).T
    waves = onset.waves(RUBBER, method, wave_vector=wave_vector(method, *turns), F=SHEARED)
    for branch, omega_squared in enumerate(waves.omega_squared, 1):
        mode = waves.mode(branch, cells=SIDE)
        assert mode.periodic.tolist() == [True, True, False]
        apart = (places[:, None] - mode.reference_positions) @ np.linalg.inv(edges)
        same = np.argmin(np.linalg.norm(apart - np.round(apart), axis=-1), axis=1)
        assert sorted(same) == list(range(len(places)))
        for phase in (0.0, 0.7):
            moved = mode.at(phase)[same, :2].ravel()
            size = np.max(np.abs(waves.omega_squared)) * np.max(np.abs(moved))
            # Expected: Re(omega^2 u exp(-i p)), where Im(u exp(-i p)) is the displacement a quarter period later.
            later = mode.at(phase + 0.5 * np.pi)[same, :2].ravel()
            expected = omega_squared.real * moved - omega_squared.imag * later
            np.testing.assert_allclose((forces @ moved).real, expected, atol=1e-9 * size)


def test_particles_of_a_mode_are_displaced_by_a_plane_wave() -> None:
    method = SPH.replace(cells=2, perturbation=0.1, penalty=0.1)
    k = wave_vector(method, 0.2, 1 / 3)
    waves = onset.waves(RUBBER, method, wave_vector=k, F=SHEARED)
    for branch in (1, 5, 8):
        mode = waves.mode(branch, amplitude=0.3)
        # Smallest number of cells, at least four on each side, with whole wavelengths; a cell has four particles.
        assert len(mode.positions) == 5 * 6 * 4 and mode.periodic.tolist() == [True, True, False]
        X, sites = mode.reference_positions, mode.sites
        np.testing.assert_allclose(mode.positions[:, :2], X @ SHEARED.T, atol=1e-12)
        np.testing.assert_allclose(mode.edges[:2, :2], np.diag([10.0, 12.0]) @ SHEARED.T, atol=1e-12)
        own = mode.displacements * np.exp(-1j * X @ k)[:, None]
        vector = np.concatenate([own[sites == site][0, :2] for site in range(4)])
        for site in range(4):
            assert np.allclose(own[sites == site, :2], vector[2 * site : 2 * site + 2], atol=1e-12)
        residual = waves.dynamical_matrix @ vector - waves.omega_squared[branch - 1] * vector
        assert np.max(np.abs(residual)) < 1e-9 * np.max(np.abs(waves.omega_squared))
        # The largest displacement equals the amplitude and occurs at phase 0.
        reach = [np.max(np.linalg.norm(mode.at(phase), axis=1)) for phase in np.linspace(0, 2 * np.pi, 721)]
        assert max(reach) <= 0.3 + 1e-12 and abs(reach[0] - 0.3) < 1e-12


@pytest.mark.parametrize("F", [np.eye(2), SHEARED])
def test_a_zero_energy_mode_alternates(F: np.ndarray) -> None:
    listed = onset.modes(SPH, RUBBER)
    number = next(n for n, mode in enumerate(listed.modes, 1) if np.allclose(np.abs(mode.fractional), [0.5, 0.0], atol=1e-6))
    of_list = listed.mode(number, cells=4)
    assert listed.modes[number - 1].nullity > 0 and abs(of_list.omega_squared) < 1e-12
    for mode in (of_list, onset.waves(RUBBER, SPH, wave_vector=(np.pi, 0), F=F).mode(cells=4)):
        signs = np.where(np.round(mode.reference_positions[:, 0]) % 2 == 0, 1, -1)
        turned = mode.at(0.0) * signs[:, None]
        np.testing.assert_allclose(turned, np.broadcast_to(turned[0], turned.shape), atol=1e-12)
        assert abs(np.linalg.norm(turned[0]) - 0.1) < 1e-12
        # A standing wave passes through zero.
        assert np.max(np.abs(mode.at(0.5 * np.pi))) < 1e-12


def test_zero_energy_modes_of_a_supercell_exclude_translations() -> None:
    listed = onset.modes(SPH.replace(cells=2, perturbation=1e-14), RUBBER)
    number = next(n for n, mode in enumerate(listed.modes, 1) if np.allclose(mode.fractional, 0.0, atol=1e-9))
    for branch in range(1, int(listed.modes[number - 1].nullity) + 1):
        mode = listed.mode(number, branch)
        assert abs(mode.omega_squared) < 1e-9
        assert np.max(np.abs(mode.masses @ mode.displacements)) < 1e-9


def test_positions_of_chains_and_three_dimensional_lattices_have_three_components() -> None:
    chain = onset.Method(lattice="chain", kernel="cubic-spline", support=2.6)
    mode = onset.waves(RUBBER, chain, wave_vector=np.pi / 3, stretch=1.2).mode()
    assert mode.periodic.tolist() == [True, False, False]
    np.testing.assert_allclose(mode.edges, np.diag([6 * 1.2, 0.0, 0.0]), atol=1e-12)
    assert not np.any(mode.positions[:, 1:]) and not np.any(mode.displacements[:, 1:])
    # No whole wavelengths: the patch is open on that side.
    waves = onset.waves(RUBBER, chain, wave_vector=0.123, stretch=1.2)
    assert not np.any(waves.mode().periodic) and len(waves.mode().positions) == 12
    cubic = onset.Method("total-lagrangian-sph", lattice="body-centered-cubic", penalty=0.1)
    k = wave_vector(cubic, 0.5, 0.0, 0.25)
    mode = onset.waves(RUBBER, cubic, wave_vector=k, stretch=(1.1, 1.0, 0.9)).mode(2, cells=(2, 1, 4))
    assert len(mode.positions) == 8 and mode.periodic.all()
    volume = np.linalg.det(mode.edges) / 0.99
    assert abs(np.sum(mode.masses) - volume) < 1e-12


def test_the_exported_mode_agrees_with_the_reported_wave() -> None:
    method = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
    state = onset.state(RUBBER, method, stretch=(1.1, 1.0))
    mode = state.mode(cells=4)
    assert abs(np.sqrt(mode.omega_squared).imag) == pytest.approx(state.growth_rate, rel=1e-6)
    direction = np.array(state.discretization.polarization) + 1j * np.array(state.discretization.polarization_imaginary)
    own = mode.displacements[0, :2] / np.linalg.norm(mode.displacements[0])
    assert abs(np.vdot(direction / np.linalg.norm(direction), own)) == pytest.approx(1.0, abs=1e-6)
    assert repr(mode).startswith("<onset.Mode of 16 particles") and np.allclose(mode.wave_vector, state.wave_vector)
    with pytest.raises(onset.InputError, match="limit of long waves") as refused:
        onset.state(RUBBER, "material-points", stretch=(0.8, 1.0)).mode()
    assert refused.value.hint


def test_ase_reads_exported_frames(tmp_path: Path) -> None:
    import ase.io

    bands = onset.bands(RUBBER, SPH, F=SHEARED, path="G-X-M-G")
    mode = bands.mode("X", 2)
    assert np.allclose(mode.wave_vector, (np.pi, 0))
    frames = mode.to_ase(frames=8, unit=0.5)
    ase.io.write(tmp_path / "mode.xyz", frames)
    read = ase.io.read(tmp_path / "mode.xyz", index=":")
    assert len(frames) == len(read) == 8
    for n, (made, again) in enumerate(zip(frames, read, strict=True)):
        np.testing.assert_allclose(made.positions, 2 * (mode.positions + mode.at(2 * np.pi * n / 8)), atol=1e-12)
        np.testing.assert_allclose(again.positions, made.positions, atol=1e-7)
        np.testing.assert_allclose(again.arrays["displacement"], made.arrays["displacement"], atol=1e-7)
        np.testing.assert_allclose(again.cell[:], 2 * mode.edges, atol=1e-7)
        assert again.pbc.tolist() == [True, True, False]
        assert again.info["phase"] == pytest.approx(2 * np.pi * n / 8) and again.info["omega"] > 0
    # The periodic images of a particle are not closer than its neighbors in the patch.
    assert np.min(frames[0].get_all_distances(mic=True)[0, 1:]) > 1.0
    assert bands.mode(120, 2).positions.shape == mode.positions.shape


def test_meshio_reads_exported_meshes(tmp_path: Path) -> None:
    import meshio  # type: ignore[import-untyped]

    mode = onset.waves(RUBBER, SPH, wave_vector=(np.pi / 2, 0.4), stretch=(1.1, 1.0)).mode(2, cells=(4, 5))
    mode.to_meshio().write(tmp_path / "mode.vtu")
    mesh = meshio.read(tmp_path / "mode.vtu")
    np.testing.assert_allclose(mesh.points, mode.positions)
    assert mesh.cells[0].type == "vertex" and mesh.cells[0].data.ravel().tolist() == list(range(20))
    moved = np.cos(0.3) * mesh.point_data["displacement"] + np.sin(0.3) * mesh.point_data["quarter"]
    np.testing.assert_allclose(moved, mode.at(0.3), atol=1e-14)


@pytest.mark.parametrize(
    ("method", "stretch"),
    [
        (SPH, (1.0, 1.0)),
        (onset.Method(lattice="square", quadrature="nodal", cells=2, perturbation=0.1), (1.1, 0.8)),
        (onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6, density=3.0), (1.1, 1.0)),
        (onset.Method("total-lagrangian-sph", lattice="honeycomb", kernel="cubic-spline", support=3.0), (0.9, 1.1)),
    ],
)
def test_the_band_file_agrees_with_the_bands(tmp_path: Path, method: onset.Method, stretch: tuple[float, float]) -> None:
    import yaml  # type: ignore[import-untyped]

    bands = onset.bands(RUBBER, method, stretch=stretch, path="0,0; 0.5,0; 0.5,0.5 | 0.5,0; 0,0")
    text = bands.to_yaml(tmp_path / "band.yaml")
    assert (tmp_path / "band.yaml").read_text(encoding="utf-8") == text
    file = yaml.safe_load(text)
    # A corner between two segments is listed twice. The last segment passes through the critical wave.
    legs = int(np.sum(np.diff(bands.corners) > 0))
    assert file["npath"] == legs and file["segment_nqpoint"] == [121] * legs and file["nqpoint"] == len(file["phonon"]) == 121 * legs
    assert len(file["labels"]) == legs and file["labels"][:3] == [list(bands.labels[n : n + 2]) for n in (0, 1, 3)]
    file["phonon"] = file["phonon"][:363]
    samples = [*range(121), *range(120, 241), *range(241, 362)]
    omega_squared = bands.omega_squared[samples].real
    frequency = np.array([[band["frequency"] for band in point["band"]] for point in file["phonon"]])
    size = np.max(np.abs(omega_squared))
    np.testing.assert_allclose(np.sign(frequency) * (2 * np.pi * frequency) ** 2, omega_squared, atol=1e-9 * size)
    # The lattice is in the deformed configuration; wave vectors are in units of its reciprocal vectors.
    lattice, reciprocal = np.array(file["lattice"]), np.array(file["reciprocal_lattice"])
    np.testing.assert_allclose(lattice @ reciprocal.T, np.eye(3), atol=1e-12)
    q = np.array([point["q-position"] for point in file["phonon"]])
    spatial = 2 * np.pi * q @ reciprocal
    np.testing.assert_allclose(spatial[:, :2] * stretch, bands.k[samples], atol=1e-12)
    assert not np.any(spatial[:, 2])
    distance = np.array([point["distance"] for point in file["phonon"]])
    steps = np.linalg.norm(np.diff(q @ reciprocal, axis=0), axis=1)
    steps[241] = 0.0  # Jump of the path between two segments.
    np.testing.assert_allclose(np.diff(distance), steps, atol=1e-12)
    # Masses of one cell, and orthonormal eigenvectors of the mass-scaled stiffness matrix.
    masses = np.array([point["mass"] for point in file["points"]])
    assert file["natom"] == len(masses) and sum(masses) == pytest.approx(
        bands.settings.discretization_density.value * np.linalg.det(lattice) / np.prod(stretch) / bands.settings.discretization_spacing.value
    )
    parts = np.array([[band["eigenvector"] for band in point["band"]] for point in file["phonon"]])
    vectors = (parts[..., 0] + 1j * parts[..., 1])[..., :2].reshape(*frequency.shape, -1)
    assert not np.any(parts[..., 2, :])
    displacements = vectors / np.sqrt(np.repeat(masses, 2))
    moved = np.einsum("nij,nbj->nbi", bands.dynamical_matrices[samples], displacements)
    np.testing.assert_allclose(moved, omega_squared[..., None] * displacements, atol=1e-9 * size)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1.0, atol=1e-12)
    if "total-lagrangian" in repr(method) or "nodal" in repr(method):
        gram = np.einsum("nbi,nci->nbc", vectors.conj(), vectors)
        np.testing.assert_allclose(gram, np.broadcast_to(np.eye(gram.shape[-1]), gram.shape), atol=1e-9)


def test_bands_with_flutter_are_refused() -> None:
    bands = onset.bands(RUBBER, onset.Method(frame="eulerian"), stretch=(1.1, 1.0))
    with pytest.raises(onset.InputError, match="flutter") as refused:
        bands.to_yaml()
    assert refused.value.hint
    # The mode of a fluttering wave can still be exported.
    assert abs(bands.mode(int(np.argmax(np.abs(bands.omega_squared[:, 0].imag)))).omega_squared.imag) > 0


def test_positions_on_the_regular_lattice_are_not_deformed() -> None:
    method = onset.Method(lattice="square", frame="eulerian", current_lattice="regular", support=2.2)
    mode = onset.waves(RUBBER, method, wave_vector=(np.pi, 0.0), F=SHEARED).mode()
    np.testing.assert_array_equal(mode.positions[:, :2], mode.reference_positions)


def test_impossible_exports_raise_errors_with_hints(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    waves = onset.waves(RUBBER, SPH, wave_vector=(1, 0), stretch=(1.1, 1.0))
    for wrong in (lambda: waves.mode(3), lambda: waves.mode(0), lambda: waves.mode(cells=(2, 2, 2)), lambda: waves.mode(cells=10**4), lambda: waves.mode(amplitude=0)):
        with pytest.raises(onset.InputError):
            wrong()
    bands = onset.bands(RUBBER, SPH, stretch=(1.1, 1.0), path="G-X")
    with pytest.raises(onset.InputError, match="no corner 'K'") as refused:
        bands.mode("K")
    assert refused.value.hint
    with pytest.raises(onset.MachineError, match="cannot write"):
        bands.to_yaml(tmp_path / "none" / "band.yaml")
    with pytest.raises(onset.InputError, match="no spurious modes"):
        onset.modes("finite-elements", weak=0.01).mode()
    mode = waves.mode()
    for name, export in (("ase", mode.to_ase), ("meshio", mode.to_meshio)):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(onset.OnsetError, match=f"this function requires {name}") as missing:
            export()
        assert missing.value.hint == f"pip install {name}"


def test_invalid_export_arguments_are_refused(tmp_path: Path) -> None:
    import yaml  # type: ignore[import-untyped]

    bands = onset.bands("neo-hooke", onset.Method("total-lagrangian-sph", lattice="square"), stretch=(1.1, 1.0))
    assert np.array_equal(bands.mode("G").wave_vector, bands.mode("Γ").wave_vector)
    assert np.array_equal(bands.mode("X'").wave_vector, bands.mode("X′").wave_vector)
    assert {point["symbol"] for point in yaml.safe_load(bands.to_yaml(symbol="No"))["points"]} == {"No"}
    for symbol in ("X: y", "a\nb", "1", ""):
        with pytest.raises(onset.InputError, match="symbol is"):
            bands.to_yaml(symbol=symbol)
    wave = bands.mode("X")
    with pytest.raises(onset.InputError, match="chemical element"):
        wave.to_ase(symbol="Zz")
    with pytest.raises(TypeError, match="symbol is int"):
        wave.to_ase(symbol=5)  # type: ignore[arg-type]
    for unit in (1e-310, 1e308):
        with pytest.raises(onset.InputError, match="unit is"):
            wave.to_ase(unit=unit)
    with pytest.raises(onset.InputError, match="too many"):
        bands.mode("X", cells=400).to_ase(frames=10_000)
    for phase in (np.nan, np.inf):
        with pytest.raises(onset.InputError, match="phase"):
            wave.at(phase)
    with pytest.raises(onset.InputError, match="character 0"):
        bands.to_yaml(str(tmp_path / "\0x"))


def test_zero_energy_modes_do_not_grow() -> None:
    (first, *_) = onset.modes(onset.Method("total-lagrangian-sph", lattice="square", support=2.6)).mode(1).to_ase()
    assert first.info["growth_rate"] == 0.0
