"""Notebooks: each solves a problem of a user and shows a figure."""

from __future__ import annotations

from pathlib import Path
import subprocess
import sys

import nbclient
import nbformat
import pytest

from conftest import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "python" / "notebooks").glob("*.ipynb"))


def test_there_are_eight_notebooks() -> None:
    assert len(NOTEBOOKS) == 8


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_notebook_runs_and_shows_a_figure(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Figures are drawn inline.
    monkeypatch.delenv("MPLBACKEND")
    # The notebooks read the folder `runs` of the repository by a relative path.
    folder = tmp_path / "python" / "notebooks"
    folder.mkdir(parents=True)
    (tmp_path / "runs").symlink_to(REPOSITORY / "runs", target_is_directory=True)
    notebook = nbformat.read(path, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not kept"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    assert any("image/png" in output.data for output in shown)


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
