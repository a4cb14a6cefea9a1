"""Answers as objects: attributes, figures, files and types."""

from __future__ import annotations

import copy
import doctest
import importlib.metadata
import inspect
from pathlib import Path
import pickle
import re
import subprocess
import sys

import numpy as np
import onset
import pytest

from conftest import REPOSITORY

RUBBER = onset.Material("neo-hooke", mu=0.4, lambda_=2.0)
SPH = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
STUDY = onset.Study.of(RUBBER, onset.Method(frame="eulerian"), {"stretch-1": (0.8, 1.3, 6), "stretch-2": (0.8, 1.3, 6)})


Kind = onset.Answer | onset.Verdicts | onset.Dispersion


def answers(folder: Path) -> list[Kind]:
    """One answer of each type."""
    return [
        onset.state(RUBBER, SPH, stretch=(1.1, 1.0)),
        onset.waves(RUBBER, SPH, wave_vector=(1, 1), stretch=(1.1, 1.0)),
        onset.bands(RUBBER, SPH, stretch=(1.1, 1.0)),
        onset.path(RUBBER, SPH, from_=(1, 1), to=(1.2, 1)),
        onset.path(RUBBER, SPH, mode="uniaxial", to=1.2),
        onset.criteria(RUBBER, modes=["uniaxial"]),
        onset.card(RUBBER, modes=["uniaxial"]),
        onset.audit(RUBBER),
        onset.localize("j2", "plane-strain"),
        onset.modes(onset.Method(quadrature="nodal")),
        onset.compare([onset.Method("total-lagrangian-sph"), onset.Method(frame="eulerian")], RUBBER, states=4),
        onset.boundary(STUDY),
        onset.map_into(folder / "map.zarr", STUDY),
        onset.simulate(RUBBER, onset.Method("total-lagrangian-sph", lattice="square"), stretch=(1, 1), turns=(1, 0), cells=4),
        onset.verdicts(RUBBER, SPH, stretch=[(1.1, 1.0), (0.9, 1.0)]),
        onset.dispersion(RUBBER, SPH, stretch=(1.1, 1.0), k=np.linspace([0, 0], [3, 0], 20)),
    ]


@pytest.fixture(scope="module")
def of_every_kind(tmp_path_factory: pytest.TempPathFactory) -> list[Kind]:
    return answers(tmp_path_factory.mktemp("answers"))


def test_answers_have_text_html_and_a_plot(of_every_kind: list[Kind], tmp_path: Path) -> None:
    from matplotlib import pyplot

    for answer in of_every_kind:
        page = answer._repr_html_()
        assert page.startswith("<") and "nan" not in page.lower().split("<svg")[0]
        assert repr(answer).startswith("<onset.")
        axes = answer.plot()
        assert axes.has_data(), answer
        figure = axes.get_figure()
        assert figure is not None
        figure.canvas.draw()
        pyplot.close("all")
        if isinstance(answer, onset.Answer):
            assert answer.to_dict() and str(answer) and answer.csv
            written = answer.save(tmp_path / type(answer).__name__)
            assert [Path(path).read_bytes() for path in written] == list(answer.files().values())


def test_figures_are_drawn_with_native_axes(of_every_kind: list[Kind]) -> None:
    from matplotlib import pyplot

    for answer in of_every_kind:
        if not isinstance(answer, onset.Answer):
            continue
        try:
            told = answer.figure()
        except onset.OnsetError as error:
            assert str(error) == "this answer has no figure"
            continue
        figure = pyplot.figure()
        left, right = figure.subfigures(1, 2)
        first = answer.plot(fig=right)
        panels = right.axes[: len(told["panels"])]
        assert first is panels[0] and not left.axes
        for axes, panel in zip(panels, told["panels"], strict=True):
            assert not axes.images
            assert (axes.get_xlabel(), axes.get_ylabel()) == (panel["x"]["label"], panel["y"]["label"])
            assert axes.get_xlim() == pytest.approx(panel["x"]["range"]) and axes.get_ylim() == pytest.approx(panel["y"]["range"])
            curves = [layer["line"] for layer in panel["layers"] if "line" in layer]
            drawn = [line.get_xydata() for line in axes.lines]
            for curve in curves:
                points = np.array(curve["points"], dtype=float)
                assert any(own.shape == points.shape and np.array_equal(own, points, equal_nan=True) for own in drawn)
        legends = [*right.legends, *(own for axes in panels if (own := axes.get_legend()))]
        legend = [text.get_text().replace("\n", " ") for own in legends for text in own.get_texts()]
        assert legend == [entry["name"] for entry in told["legend"]]
        figure.canvas.draw()
        pyplot.close("all")
        with pytest.raises(onset.InputError, match="into both"):
            answer.plot(first, fig=right)
        with pytest.raises(onset.InputError, match="panels?, and 5 axes"):
            answer.plot(pyplot.figure().subplots(1, 5))
        pyplot.close("all")
def test_every_answer_is_a_data_frame(of_every_kind: list[Kind]) -> None:
    for answer in of_every_kind:
        frame = answer.to_frame()
        assert len(frame.columns) > 1 and all(frame.columns), answer
        assert len(frame) > 0 or not answer.modes, answer
        if isinstance(answer, onset.Answer):
            # Numbers are read back exactly.
            assert frame.attrs["text"] == str(answer)
            if isinstance(answer, onset.Simulation):
                assert len(frame) == answer["measured"]["samples"] and frame.columns[0].startswith("time")
            else:
                assert ",".join(frame.columns) == answer.csv.splitlines()[0]
    state = onset.state(RUBBER, SPH, stretch=(1.1, 1.0))
    row = state.to_frame().loc[0]
    assert (row["verdict"], row["growth_rate"], row["F11"]) == (state.verdict, state.growth_rate, 1.1)
    assert row["wave_vector_1"] == state.wave_vector[0] and row["elliptic"] == state.elliptic
    measured = onset.Method(lattice="square", spacing="1 mm", density="1 g/cm^3")
    units = onset.state(onset.Material("neo-hooke", young="2 MPa", poisson=0.4), measured, stretch=(1.1, 1)).to_frame()
    assert {"s11 [Pa]", "growth_rate [1/s]", "F11"} <= set(units.columns)


def test_a_table_without_pandas_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(onset.OnsetError, match="pip install pandas"):
        onset.state(stretch=(1, 1)).to_frame()


def test_methods_without_names_have_short_names_and_variants() -> None:
    sph = onset.Method("total-lagrangian-sph", lattice="square")
    table = onset.compare([sph, sph.replace(penalty=0.4)], RUBBER, states=2)
    assert [row.name for row in table.rows] == ["total-lagrangian-sph", "total-lagrangian-sph, penalty 0.4"]
    varied = onset.compare(sph, RUBBER, vary={"kernel": ["cubic-spline", "wendland-c2"], "smoothing_length": [1.2, 1.3]}, states=2)
    assert [row.name for row in varied.rows][:2] == ["kernel cubic-spline, smoothing-length 1.2", "kernel cubic-spline, smoothing-length 1.3"]
    assert len(varied.rows) == 4
    with pytest.raises(onset.SettingError, match="same for all methods"):
        onset.compare(sph, RUBBER, vary={"material.mu": [1, 2]})


def test_the_name_of_a_file_in_place_of_a_law_leads_to_the_function_that_reads_it() -> None:
    for name, reader in [("o.inp", "Material"), ("decks/tire.k", "Material"), ("rubber.toml", "Study")]:
        with pytest.raises(onset.InputError, match=rf"onset\.{reader}\.read\('{name}'\)"):
            onset.state(name, stretch=(1.1, 1))


@pytest.mark.parametrize("name", ["rubber (2).inp", "*.inp", "rubber.inp"])
def test_a_text_that_names_a_file_is_its_path(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(BLOCK)
    read = onset.Material.read(str(tmp_path / name), "abaqus")
    assert read == onset.Material.read(BLOCK, "abaqus") == onset.Material.read(tmp_path / name, "abaqus")


def test_a_law_from_a_deck_has_numbers_and_warns_of_unread_parts(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.warns(UserWarning, match=r"not read: \*EXPANSION") as warned:
        read = onset.Material.read("*MATERIAL, NAME=A\n*HYPERELASTIC, YEOH\n0.5, -0.01, 0.001, 0.1, 0, 0\n*EXPANSION\n1e-5\n")
    assert [Path(one.filename).name for one in warned] == ["test_objects.py"]
    assert repr(read) == "Material(model='yeoh', c10=0.5, c20=-0.01, c30=0.001, kappa=20)"
    assert capsys.readouterr() == ("", "")


def test_waves_without_a_state_are_waves_of_the_reference_configuration() -> None:
    assert "the reference configuration" in str(onset.waves(RUBBER, wave_vector=(1, 0)))
    bands = onset.bands(RUBBER, path="G-M")
    assert str(bands) == str(onset.bands(RUBBER, path="G-M", stretch=(1, 1)))
    assert "the reference configuration" in str(bands)


def test_examples_of_docstrings_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every public function has parameters, the returned value, exceptions and an example."""
    monkeypatch.chdir(tmp_path)
    finder = doctest.DocTestFinder()
    tried = 0
    for name in onset.__all__:
        thing = getattr(onset, name)
        told = thing.__doc__ or ""
        if inspect.isfunction(thing):
            expected = [part for part in ("Parameters", "Raises") if name != "models"]
            for part in [*expected, "Returns", "Examples"]:
                assert f"{part}\n    ---" in told, (name, part)
        for test in finder.find(thing, name, globs={"onset": onset, "np": np}):
            outcome = doctest.DocTestRunner().run(test)
            assert outcome.failed == 0, test.name
            tried += outcome.attempted
    assert tried > 40


def test_plots_of_paths_label_units_and_clip_rounding_to_zero() -> None:
    from matplotlib import pyplot

    law = onset.Material("neo-hooke", mu=0.4, lambda_=2.0)
    answer = onset.path(law, onset.Method("total-lagrangian-sph", lattice="square"), mode="uniaxial", to=2.0)
    first = answer.plot()
    figure = first.get_figure()
    assert figure is not None
    particles, material = figure.axes
    assert particles is first and particles.get_xlabel() == material.get_xlabel() == "imposed stretch λ (−)"
    assert particles.get_ylabel().endswith("(−)") and material.get_ylabel() == "smallest acoustic eigenvalue"
    x, y = particles.lines[-1].get_xydata().T
    assert (x[0], x[-1]) == (1.0, 2.0) and not np.any(y)
    # The shear modulus at F = 1, unscaled.
    assert material.lines[-1].get_xydata()[0, 1] == pytest.approx(0.4)
    pyplot.close("all")
    # Two panels are not squeezed into one axes.
    _, both = pyplot.subplots(1, 2)
    lost = onset.path(onset.Material("blatz-ko"), SPH, from_=(1, 1), to=(4, 1))
    with pytest.raises(onset.InputError, match=r"plot\(fig=figure\)"):
        lost.plot(both[1])
    drawn = lost.plot(both)
    assert drawn is both[0] and drawn.get_xlabel() == "stretch λ₁ (−)" and len(drawn.get_figure().axes) == 2
    pyplot.close("all")


def test_figures_follow_the_parameters_of_matplotlib() -> None:
    import matplotlib
    from matplotlib import pyplot

    answer = onset.path(RUBBER, SPH, from_=(1, 1), to=(1.2, 1))
    own = {"figure.figsize": (5.0, 2.5), "lines.linewidth": 4.5, "axes.prop_cycle": matplotlib.cycler(color=["#123456", "#654321"])}
    with pyplot.rc_context(own):
        first = answer.plot()
        figure = first.get_figure()
        assert figure is not None and tuple(figure.get_size_inches()) == (5.0, 2.5)
        colors = [line.get_color() for axes in figure.axes for line in axes.lines[1:]]
        assert {"#123456", "#654321"} & set(colors)
        assert max(line.get_linewidth() for line in first.lines) > 3.0
    # The legend is not wider than the figure.
    names = onset.bands(RUBBER, SPH, stretch=(0.7, 1)).plot().get_figure()
    assert names is not None
    names.canvas.draw()
    (legend,) = names.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0 and box.x1 <= names.bbox.x1
    pyplot.close("all")


def test_files_of_an_answer_can_be_made_for_a_paper(tmp_path: Path) -> None:
    answer = onset.path(RUBBER, SPH, from_=(1, 1), to=(1.2, 1))
    written = {Path(path).name: Path(path) for path in answer.save(tmp_path, size="84mm", bare=True, theme="dark")}
    assert set(written) == {"path.csv", "path.svg", "path.png", "path.pdf", "path.txt"}
    assert 'width="84mm"' in written["path.svg"].read_text()
    assert written["path.txt"].read_text().startswith("Stability along a path from ")
    with pytest.raises(onset.InputError, match="size: expected a width"):
        answer.save(tmp_path, size="84")
    with pytest.raises(onset.InputError, match="theme"):
        answer.save(tmp_path, theme="blue")  # type: ignore[arg-type]


def test_attributes_agree_with_the_document() -> None:
    answer = onset.state(RUBBER, SPH, stretch=(1.1, 1.0))
    document = answer.to_dict()
    assert answer.verdict == document["verdict"] and answer["verdict"] == answer.verdict
    assert answer.growth_rate == document["discretization"]["growth_rate"] == answer.discretization.growth_rate
    assert answer.wave_vector.tolist() == document["discretization"]["wave_vector"]
    assert isinstance(answer.discretization.minimum_omega_squared, complex)
    assert answer.deformation_gradient.shape == (3, 3) and answer.material.tangent.shape == (3, 3, 3, 3)
    assert answer.settings.discretization_support.value == 2.6
    path = onset.path(RUBBER, SPH, from_=(1, 1), to=(1.2, 1))
    assert path.from_.shape == (3, 3)


def test_answers_can_be_copied_and_pickled() -> None:
    answer = onset.state(RUBBER, SPH, stretch=(1.1, 1.0))
    assert copy.copy(answer) is answer and copy.deepcopy(answer.discretization) == answer.discretization
    # Only the document is pickled, not the figures and files.
    sent = pickle.loads(pickle.dumps(answer))
    assert type(sent) is onset.Record and sent.to_dict() == answer.to_dict()
    assert pickle.loads(pickle.dumps((RUBBER, SPH))) == (RUBBER, SPH)
    assert not hasattr(answer, "_no_such_name")


def test_settings_support_comparison_repr_and_replacement() -> None:
    assert SPH == onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
    assert hash(SPH.replace(support=2.6)) == hash(SPH) and SPH.replace(support=2.0) != SPH
    assert SPH.replace(artificial_stress=0.3).assignments[-1] == "discretization.artificial-stress=0.3"
    assert repr(SPH) == "Method(method='updated-sph', lattice='square', kernel='cubic-spline', support=2.6)"
    assert repr(onset.Material("neo-hooke", mu=np.float64(2))) == "Material(model='neo-hooke', mu=2.0)"
    assert RUBBER.replace(mu=1).assignments == ("material.model=neo-hooke", "material.mu=1", "material.lambda=2.0")
    assert onset.Material("mu/2*(I1 - 3)", mu=1).assignments[:2] == ("material.model=formula", "material.energy=mu/2*(I1 - 3)")
    assert RUBBER.replace(mu=1) == RUBBER.replace(mu="1.0") and hash(RUBBER.replace(mu=1)) == hash(RUBBER.replace(mu=1.0))
    assert RUBBER.replace(mu=2**53 + 1).assignments[1] == "material.mu=9007199254740993"
    assert "discretization.support" in onset.keys("discretization") and "neo-hooke" in onset.models()
    with pytest.raises(onset.InputError, match="section 'mat' does not exist"):
        onset.keys("mat")


BLOCK = "*HYPERELASTIC, NEO HOOKE\n1.0, 0.1"


def test_numeric_strings_become_numbers_in_studies() -> None:
    axes = {"stretch-1": ("0.8", 1.3, 2), "stretch-2": (0.8, np.array(1.3), np.array(2))}
    read = onset.Material.read(BLOCK, "abaqus")
    study = onset.Study.of(read, onset.Method(frame="eulerian", support="1.6"), axes, title="2026", map={"adaptive": "false", "tile": "8"})
    assert 'title = "2026"' in study.text and "c10 = 1\n" in study.text and "support = 1.6\n" in study.text and "adaptive = false\n" in study.text
    assert "range = [0.8, 1.3]\nstates = 2\n" in study.text
    same = onset.Study.of(read.replace(c10=1.0), onset.Method(frame="eulerian", support=1.6), axes)
    assert onset.boundary(study).to_dict()["curves"] == onset.boundary(same).to_dict()["curves"]
    method = onset.Method("total-lagrangian-sph", lattice="square", support="2.6")
    table = onset.compare({"1": method}, onset.Material("neo-hooke", mu="0.4", lambda_=" 2."), states="2")
    assert table == onset.compare({"1": method.replace(support=2.6)}, RUBBER, states=2)
    assert onset.recommend(read, methods=None, dimension=1).csv
    assert onset.recommend(methods=[onset.Method(lattice="chain", kernel="cubic-spline", support="2.6")]).csv
    # A key that takes a list accepts a single value; a string remains a string.
    library = onset.Material("umat", library="2", properties="1, 2.5")
    text = library._section_text()
    assert 'library = "2"\n' in text and "properties = [1, 2.5]\n" in text
    assert "properties = [1.0, 2]\n" in onset.Material("umat", properties=[1.0, np.array(2)])._section_text()
    assert "properties = [3]\n" in onset.Material("umat", properties=3)._section_text()
    assert "support = 2.5\n" in onset.Method(support=np.array([2.5]))._section_text()
    listing = onset.Study.of(RUBBER, SPH, axes, map={"outputs": "growth_rate, wave_vector"})
    assert 'outputs = ["growth_rate", "wave_vector"]' in listing.text
    large = onset.Material("mu*(I1 - 3)", mu=2**60)._section_text()
    assert "mu = 1.152921504606847e+18\n" in large and onset.Study.of(onset.Material("neo-hooke", mu=2**60), SPH, axes)


def test_replacing_parameters_keeps_the_notes_of_a_law() -> None:
    read = onset.Material.read(BLOCK, "abaqus")
    other = read.replace(c10=2)
    assert read.notes and other.notes == read.notes
    assert other != read and other.replace(c10="1") == read
    assert type(SPH.replace(kernel="wendland-c2")) is onset.Method


def test_zero_dimensional_arrays_are_accepted_as_numbers() -> None:
    assert onset.Material("neo-hooke", mu=np.array(0.4), lambda_=np.array(2)) == RUBBER
    assert onset.Method(np.str_("updated-sph"), lattice=np.array("square"), kernel="cubic-spline", support=np.float32(2.5)) == SPH.replace(support=2.5)
    certified = onset.state(RUBBER, SPH, stretch=(1.1, 1.0), certify=np.array(False), tolerance=np.array(1e-3))
    assert certified == onset.state(RUBBER, SPH, stretch=(1.1, 1.0))


def test_a_single_assignment_is_accepted_in_place_of_a_list() -> None:
    text = STUDY.text
    assert onset.Study(text, set="discretization.support=2").text == onset.Study(text, set=["discretization.support=2"]).text
    methods = [onset.Method("total-lagrangian-sph")]
    assert onset.compare(methods, RUBBER, set="compare.states=2") == onset.compare(methods, RUBBER, states=2)
    with pytest.raises(TypeError, match="set expects texts"):
        onset.Study(text, set=[1])  # type: ignore[list-item]


class Drawing:
    """Answer that counts how often its files are computed."""

    json, text, csv = "{}", "stable\nin all", ""

    def __init__(self, error: Exception | None = None) -> None:
        self.error = error
        self.times = 0

    def files(self) -> dict[str, bytes]:
        self.times += 1
        if self.error is not None:
            raise self.error
        return {"figure.svg": b"<svg></svg>", "figure.png": b""}


def drawn_by(drawing: Drawing) -> onset.Answer:
    """Answer whose figures `drawing` computes."""
    answer = onset.state(RUBBER, SPH, stretch=(1.1, 1.0))
    object.__setattr__(answer, "_answer", drawing)
    return answer


def test_figures_are_cached_and_a_failed_figure_does_not_break_the_display() -> None:
    drawing = Drawing()
    answer = drawn_by(drawing)
    assert answer._repr_html_() == answer._repr_html_() and "<svg>" in answer._repr_html_()
    answer.files().clear()
    assert set(answer.files()) == {"figure.svg", "figure.png"} and drawing.times == 1
    failing = drawn_by(Drawing(onset.MachineError("no figure")))
    page = failing._repr_html_()
    assert "<strong>stable</strong>" in page and "<svg" not in page
    with pytest.raises(onset.MachineError):
        failing.files()


def test_equal_calls_give_equal_answers() -> None:
    first = onset.state(RUBBER, SPH, stretch=(1.1, 1.0))
    assert first == onset.state(RUBBER, SPH, stretch=(1.1, 1.0)) and first != onset.state(RUBBER, SPH, stretch=(1.2, 1.0))
    assert len({first, onset.state(RUBBER, SPH, stretch=(1.1, 1.0))}) == 1


@pytest.mark.parametrize("page", ["README.md", "python/README.md", "book/src/how-to/python.md"])
def test_examples_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```", (REPOSITORY / page).read_text(), flags=re.DOTALL)
    assert examples
    exec("\n".join(examples), {"__name__": "example"})


def test_stubs_match_the_compiled_module(tmp_path: Path) -> None:
    """The package and the examples of the documentation also pass the strict type checker."""
    package = REPOSITORY / "python" / "onset"
    stubtest = subprocess.run([sys.executable, "-m", "mypy.stubtest", "onset._onset"], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert stubtest.returncode == 0, stubtest.stdout + stubtest.stderr
    examples = []
    for number, page in enumerate(["README.md", "python/README.md", "book/src/how-to/python.md"]):
        blocks = re.findall(r"```python\n(.*?)```", (REPOSITORY / page).read_text(), flags=re.DOTALL)
        example = tmp_path / f"example_{number}.py"
        example.write_text("\n".join(blocks))
        examples.append(str(example))
    for checked in ([str(package)], [str(package.with_name(name)) for name in ("reference.py", "notebooks.py")], examples):
        mypy = subprocess.run([sys.executable, "-m", "mypy", "--strict", *checked], capture_output=True, text=True, cwd=tmp_path, check=False)
        assert mypy.returncode == 0, mypy.stdout + mypy.stderr


def test_the_installed_package_has_the_licenses_of_all_linked_libraries() -> None:
    files = {file.name: file for file in importlib.metadata.files("onset-mechanics") or []}
    texts = files["THIRD-PARTY.txt"].read_text(encoding="utf-8")
    assert {"LICENSE-MIT", "LICENSE-APACHE"} <= set(files)
    for crate in ("nalgebra", "pyo3", "rayon", "serde", "tiny-skia"):
        assert f"\n{crate} " in texts, crate
    for part in ("standard library of Rust", "DejaVu Sans, embedded"):
        assert part in texts, part


def test_the_program_of_a_deck_is_recognized() -> None:
    assert onset.Material.read(BLOCK) == onset.Material.read(BLOCK, "abaqus")
    with pytest.raises(onset.InputError, match="not recognized as a deck"):
        onset.Material.read("one line\nand another")


def test_the_zoo_lists_reports_and_answers_one() -> None:
    names = [report["name"] for report in onset.zoo().to_dict()["reports"]]
    assert len(names) == 18
    report = onset.zoo("trixi-371-cubic")
    assert (report.answer.verdict, report.remedy_answer.verdict) == ("zero-energy", "stable")
    with pytest.raises(onset.InputError, match="did you mean"):
        onset.zoo("trixi-371-cubik")
