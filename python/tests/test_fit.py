"""Laws fitted to tests given as arrays, tables and paths."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import REPOSITORY, command
import onset

RUBBER = REPOSITORY / "rubber"
MODES = ("uniaxial", "equibiaxial", "planar")


def treloar(mode: str) -> Any:
    stretch, stress = np.loadtxt(RUBBER / f"treloar-{mode}.csv", delimiter=",", skiprows=3, unpack=True)
    return {"stretch": stretch, "nominal_stress": stress}


def yeoh(stretch: Any, c10: float = 0.17, c20: float = -1e-3, c30: float = 4e-5) -> Any:
    strain = stretch**2 + 2 / stretch - 3
    return 2 * (stretch - stretch**-2) * (c10 + 2 * c20 * strain + 3 * c30 * strain**2)


class Frame:
    """Minimal data frame: names of columns, and columns by name."""

    def __init__(self, **columns: Any) -> None:
        self.columns = list(columns)
        self._columns = columns

    def __getitem__(self, name: str) -> Any:
        return self._columns[name]


def test_arrays_tables_and_paths_give_the_same_fit_as_the_command() -> None:
    paths = [RUBBER / f"treloar-{mode}.csv" for mode in MODES]
    output = command("fit", *(str(path) for path in paths), "--law", "yeoh,mooney-rivlin", "--unit", "MPa")
    data = {mode: treloar(mode) for mode in MODES}
    arrays = {mode: (own["stretch"], own["nominal_stress"]) for mode, own in data.items()}
    frames = {mode: Frame(**own) for mode, own in data.items()}
    for tests in (arrays, frames, data, paths, dict(zip(MODES, paths, strict=True))):
        fit = onset.fit(tests, "yeoh,mooney-rivlin", unit="MPa")
        assert fit.json == output.document
    document = json.loads(output.document)
    assert (fit.law, fit.error) == (document["laws"][0]["law"], document["laws"][0]["error"])
    assert [row["law"] for row in fit.table()] == [own["law"] for own in document["laws"]]
    assert all(row["proof"] == "proved" for row in fit.table())
    assert str(fit).startswith(f"{fit.law} fits the 3 tests")
    assert "fit.png" in fit.files()


def test_lateral_stretches_in_arrays_agree_with_a_table(tmp_path: Path) -> None:
    stretch = np.concatenate([np.linspace(0.4, 0.95, 10), np.linspace(1.05, 1.5, 8)])
    lateral = stretch**-0.2
    stress = 0.5 * (stretch**2 - stretch**-1.0) / stretch
    table = tmp_path / "foam-uniaxial.csv"
    rows = zip(stretch.tolist(), stress.tolist(), lateral.tolist(), strict=True)
    table.write_text("stretch,nominal_stress,lateral_stretch\n" + "".join(f"{a!r},{b!r},{c!r}\n" for a, b, c in rows))
    fit = onset.fit({"uniaxial": (stretch, stress, lateral)}, "hyperfoam-2", starts=4)
    frame = Frame(lateral_stretch=lateral, stretch=stretch, nominal_stress=stress)
    assert fit.json == onset.fit({"uniaxial": frame}, "hyperfoam-2", starts=4).json
    # The notes name the table by its path.
    of_table = onset.fit(table, "hyperfoam-2", starts=4).json
    assert of_table.replace(str(table), r'tests[\"uniaxial\"]') == fit.json
    with pytest.raises(onset.InputError, match="lateral"):
        onset.fit({"uniaxial": (stretch, stress)}, "hyperfoam-2", starts=4)


def test_constants_are_recovered_from_exact_data() -> None:
    stretch = np.linspace(1.1, 5.0, 20)
    fit = onset.fit({"uniaxial": (stretch, yeoh(stretch))}, ["yeoh"], stable=None)
    assert list(fit.constants.values()) == pytest.approx([0.17, -1e-3, 4e-5], rel=1e-8)
    # A fixed constant keeps its value.
    first = next(iter(fit.constants))
    assert onset.fit({"uniaxial": (stretch, yeoh(stretch))}, "yeoh", stable=None, fix={first: 0.2}).constants[first] == 0.2


def test_the_fitted_law_is_a_material() -> None:
    stretch = np.linspace(1.1, 4.0, 12)
    fit = onset.fit({"uniaxial": (stretch, yeoh(stretch))}, "yeoh", bulk=200.0)
    own, written = (dict(pair.split("=") for pair in pairs) for pairs in (fit.material.assignments, fit.settings))
    assert own.pop("material.model") == written.pop("material.model") == "yeoh"
    assert {key: float(value) for key, value in own.items()} == {key: float(value) for key, value in written.items()}
    assert written["material.kappa"] == "200"
    F = np.diag([2.0, 2.0**-0.5, 2.0**-0.5])
    P = fit.material.stress(F)
    assert P[0, 0] - P[1, 1] * F[1, 1] / F[0, 0] == pytest.approx(yeoh(2.0), rel=1e-6)
    assert onset.card(fit.material).symmetric_box is not None
    assert onset.criteria(fit.material, incompressible=True).loadings


def test_arrays_and_tables_give_the_same_error_messages(tmp_path: Path) -> None:
    stretch = np.linspace(1.1, 4.0, 12)
    stress = yeoh(stretch)
    swapped = [1, 0, *range(2, 12)]
    for name, (x, y) in {
        "percent": (100 * (stretch - 1), stress),
        "unsorted": (stretch[swapped], stress[swapped]),
        "negative": (stretch, -stress),
        "few": (stretch[:2], stress[:2]),
        "strain": (stretch - 1.2, stress),
    }.items():
        table = tmp_path / f"{name}.csv"
        table.write_text("stretch,nominal_stress\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), y.tolist(), strict=True)))
        output = command("fit", "--uniaxial", str(table), "--law", "yeoh")
        assert output.code == 2
        with pytest.raises(onset.InputError) as raised:
            onset.fit({"uniaxial": (x, y)}, "yeoh")
        # Only the position differs: a line of the file, an index of the array.
        assert raised.value.message.partition(": ")[2] == output.error.partition("\n")[0].partition(": ")[2], name
        with pytest.raises(onset.InputError) as raised:
            onset.fit({"uniaxial": table}, "yeoh")
        assert str(raised.value) == output.error
    for names in ("yeo", "holzapfel-gasser-ogden"):
        output = command("fit", str(RUBBER / "treloar-uniaxial.csv"), "--law", names)
        with pytest.raises(onset.InputError) as raised:
            onset.fit({"uniaxial": (stretch, stress)}, names)
        assert str(raised.value) == output.error


def test_hints_name_keywords_instead_of_options() -> None:
    x = np.linspace(1.1, 4.0, 3)
    for given in ({"law": "polynomial-3"}, {"law": "hencky"}, {"range": (7.0, 8.0)}):
        with pytest.raises(onset.InputError) as raised:
            onset.fit(**{"tests": {"uniaxial": (x, yeoh(x))}, "law": "yeoh", **given})
        assert "hint:" in str(raised.value)
        assert "--" not in str(raised.value)


def test_faults_name_the_argument() -> None:
    x = np.linspace(1.1, 4.0, 12)
    y = yeoh(x)
    hole = np.where(np.arange(12) == 3, np.nan, y)
    masked = np.ma.MaskedArray(y, mask=np.arange(12) == 3)
    faults: list[tuple[dict[str, Any], str]] = [
        ({"tests": {"uniaxial": (x, hole)}}, r'tests\["uniaxial"\], point 3: the value NaN'),
        ({"tests": {"uniaxial": (x, masked)}}, r"nominal_stress of tests\['uniaxial'\] has 1 masked"),
        ({"tests": {"uniaxial": (x, y[:5])}}, "the arrays have 12 and 5 numbers"),
        ({"tests": {"uniaxial": (x, y, x[:4])}}, "the arrays have 12 and 4 numbers"),
        ({"tests": {"uniaxial": (x, y[:, None])}}, r"has the shape \(12, 1\)"),
        ({"tests": {"uniaxial": (x,)}}, "1 parts; expected two arrays"),
        ({"tests": {"uniaxial": Frame(length=x, stress=y)}}, "expected stretch"),
        ({"tests": {"biax": (x, y)}}, 'loading cannot be "biax"'),
        ({"tests": {"volumetric": (1 - x / 100, y, x)}}, "has no lateral stretch"),
        ({"tests": {"uniaxial": (x, y), "planar": (x, 1000 * y)}}, "different shear moduli at small strains"),
        ({"tests": {}}, "tests is empty"),
        ({"tests": "nowhere-uniaxial.csv"}, "nowhere-uniaxial.csv"),
        ({"weights": "some"}, "expected relative, by-test or absolute"),
        ({"criterion": "some"}, "expected drucker, ellipticity or both"),
        ({"stable": "box=2,3"}, "stable is .*expected limits on both sides of 1"),
        ({"fix": {"nothing": 1.0}}, "nothing"),
        ({"bound": {"c10": (2, 1)}}, r"bound\['c10'\] expects two numbers"),
        ({"margin": 0}, "margin is 0"),
        ({"starts": 0}, "starts is 0"),
        ({"bulk": -1}, "bulk is -1"),
    ]
    for given, message in faults:
        with pytest.raises(onset.InputError, match=message):
            onset.fit(**{"tests": {"uniaxial": (x, y)}, "law": "yeoh", **given})
    for tests in (Frame(stretch=x, nominal_stress=y), {1: (x, y)}, {"uniaxial": 1.0}, 1.0):
        with pytest.raises(TypeError):
            onset.fit(tests, "yeoh")  # type: ignore[arg-type]


def test_units_in_the_names_of_columns_are_read() -> None:
    stretch = np.linspace(1.1, 2, 8)
    pull = {"stretch": stretch, "stress [MPa]": 0.5 * (stretch - stretch**-2)}
    shear = 0.5 * (stretch - stretch**-3)
    fit = onset.fit({"uniaxial": pull, "planar": {"stretch": stretch, "nominal stress (MPa)": shear}}, "neo-hooke")
    assert (fit.unit, round(fit.constants["mu"], 9)) == ("MPa", 0.5)
    # Units are converted as in files: without a conversion the moduli would differ by a factor of 1000.
    kilo = {"stretch": stretch, "stress [kPa]": 1000 * shear}
    fit = onset.fit({"uniaxial": pull, "planar": kilo}, "neo-hooke")
    assert (fit.unit, round(fit.constants["mu"], 9)) == ("MPa", 0.5)
    for tests, fact in [
        ({"uniaxial": pull, "planar": (stretch, shear)}, "one of the tests uniaxial and planar names a unit of stress"),
        ({"uniaxial": {"strain [‰]": stretch - 1, "stress": shear}}, "has the unit ‰"),
        ({"uniaxial": {"stretch [%]": stretch, "stress": shear}}, "has the unit %"),
        ({"uniaxial": {"stretch": stretch, "stress [foo]": shear}}, "the unit of stress `foo` is not known"),
    ]:
        with pytest.raises(onset.InputError, match=fact):
            onset.fit(tests, "neo-hooke")


def test_a_table_has_the_columns_of_a_file() -> None:
    stretch = np.linspace(1.1, 2, 8)
    nominal = 0.5 * (stretch - stretch**-2)
    specimen = ["a"] * 8
    cases: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({"stretch": stretch, "true_stress": stretch * nominal}, {}),
        ({"true strain": np.log(stretch), "Cauchy stress [MPa]": stretch * nominal}, {}),
        ({"strain [%]": 100 * (stretch - 1), "force [N]": 4 * nominal}, {"area": 4.0}),
        ({"specimen": specimen, "lambda": stretch, "engineering_stress": nominal}, {}),
    ]
    for table, given in cases:
        fit = onset.fit({"uniaxial": table}, "neo-hooke", **given)
        assert fit.constants["mu"] == pytest.approx(0.5, rel=1e-8), table
    faults: list[tuple[dict[str, Any], str]] = [
        ({"stretch": stretch, "force": nominal}, "without the area"),
        ({"stretch": stretch, "stress": specimen}, "`a` of the column `stress` is not a finite number"),
        ({"stretch": stretch, "stress": nominal[:5]}, "`stress` has 5 numbers"),
        ({"stretch": stretch, "stress": np.where(stretch > 1.5, np.nan, nominal)}, "point 4.*not a finite number"),
    ]
    for table, fact in faults:
        with pytest.raises(onset.InputError, match=fact):
            onset.fit({"uniaxial": table}, "neo-hooke")
