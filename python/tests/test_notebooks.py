"""Notebooks: each solves a problem of a user, shows a figure, and keeps the outputs of a run."""

from __future__ import annotations

from pathlib import Path
import re
import runpy
import subprocess
import sys

import nbformat
import pytest

from conftest import REPOSITORY

# Its folder must not be on the path of modules: the sources of the package there would hide the installed package in child processes.
_SCRIPT = runpy.run_path(str(REPOSITORY / "python" / "notebooks.py"))
NOTEBOOKS, run = _SCRIPT["NOTEBOOKS"], _SCRIPT["run"]

#: Checksum of the program, or the digits of a long number.
CHECKSUM = re.compile(r"\b[0-9a-f]{12,}\b")
#: Number in a text.
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def texts(notebook: nbformat.NotebookNode) -> list[str]:
    """Texts of all outputs, ``figure`` for a figure."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    return [CHECKSUM.sub("checksum", output.get("text") or output.data.get("text/plain", "figure")) for output in outputs]


def assert_same(fresh: str, kept: str) -> None:
    """Compares two texts; their numbers may differ by rounding."""
    assert NUMBER.sub("#", fresh) == NUMBER.sub("#", kept)
    numbers = [[float(number) for number in NUMBER.findall(text)] for text in (fresh, kept)]
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-3, abs=1e-6)


def test_there_are_eight_notebooks() -> None:
    assert len(NOTEBOOKS) == 8


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_notebook_runs_as_shown_and_has_a_figure(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Figures are drawn inline.
    monkeypatch.delenv("MPLBACKEND")
    fresh, kept = texts(run(path, tmp_path)), texts(nbformat.read(path, as_version=4))
    assert len(fresh) == len(kept), "other cells have outputs than those kept\n  hint: python python/notebooks.py"
    for own, known in zip(fresh, kept, strict=True):
        assert_same(own, known)
    assert "figure" in kept


def test_code_of_notebooks_passes_the_type_checker(tmp_path: Path) -> None:
    files = []
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        file = tmp_path / f"{path.stem.replace('-', '_')}.py"
        file.write_text("\n".join(cell.source for cell in cells if cell.cell_type == "code") + "\n")
        files.append(str(file))
    # SciPy ships no type stubs.
    (tmp_path / "mypy.ini").write_text("[mypy]\nstrict = true\n[mypy-scipy.*]\nignore_missing_imports = true\n")
    mypy = subprocess.run([sys.executable, "-m", "mypy", *files], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert mypy.returncode == 0, mypy.stdout + mypy.stderr
