"""The notebooks: each is a question of a user with an answer and a picture."""

from __future__ import annotations

from pathlib import Path
import subprocess
import sys

import nbclient
import nbformat
import pytest

from conftest import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "python" / "notebooks").glob("*.ipynb"))


def test_there_are_eight() -> None:
    assert len(NOTEBOOKS) == 8


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs_and_shows_a_picture(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A notebook draws into itself.
    monkeypatch.delenv("MPLBACKEND")
    # Runs of the repository lie at the place that the folder of the notebooks has.
    folder = tmp_path / "python" / "notebooks"
    folder.mkdir(parents=True)
    (tmp_path / "runs").symlink_to(REPOSITORY / "runs", target_is_directory=True)
    notebook = nbformat.read(path, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not kept"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    assert any("image/png" in output.data for output in shown)


def test_types(tmp_path: Path) -> None:
    files = []
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        file = tmp_path / f"{path.stem.replace('-', '_')}.py"
        file.write_text("\n".join(cell.source for cell in cells if cell.cell_type == "code") + "\n")
        files.append(str(file))
    # SciPy has no types of its own.
    (tmp_path / "mypy.ini").write_text("[mypy]\nstrict = true\n[mypy-scipy.*]\nignore_missing_imports = true\n")
    mypy = subprocess.run([sys.executable, "-m", "mypy", *files], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert mypy.returncode == 0, mypy.stdout + mypy.stderr
