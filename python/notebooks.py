"""Runs the notebooks and keeps their outputs, so that they can be read without running them: python python/notebooks.py."""

from __future__ import annotations

from pathlib import Path
import tempfile

import nbclient
import nbformat

REPOSITORY = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((REPOSITORY / "python" / "notebooks").glob("*.ipynb"))


def run(path: Path, place: Path) -> nbformat.NotebookNode:
    """Returns a notebook with the outputs of a run. The notebooks read the folder `runs` of the repository by a relative path."""
    folder = place / "python" / "notebooks"
    folder.mkdir(parents=True)
    (place / "runs").symlink_to(REPOSITORY / "runs", target_is_directory=True)
    notebook: nbformat.NotebookNode = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    # The version of the interpreter is not part of a notebook.
    metadata = dict(notebook.metadata)
    nbclient.NotebookClient(notebook, timeout=300, record_timing=False, resources={"metadata": {"path": str(folder)}}).execute()
    notebook.metadata = nbformat.from_dict(metadata)  # type: ignore[no-untyped-call]
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = _joined([output for output in map(_kept, cell.outputs) if output is not None])
    return notebook


def _joined(outputs: list[nbformat.NotebookNode]) -> list[nbformat.NotebookNode]:
    """Joins successive texts, which the kernel divides by chance."""
    joined: list[nbformat.NotebookNode] = []
    for output in outputs:
        if joined and output.output_type == joined[-1].output_type == "stream":
            joined[-1].text += output.text
        else:
            joined.append(output)
    return joined


def _kept(output: nbformat.NotebookNode) -> nbformat.NotebookNode | None:
    """Returns an output as it is kept: figures without their names, numbers and tables as text, no warnings or names of objects of matplotlib."""
    if output.get("name") == "stderr":
        return None
    data = output.get("data", {})
    if "image/png" in data:
        output.data = {"image/png": data["image/png"]}
    elif data:
        output.data = {"text/plain": data["text/plain"]}
        if data["text/plain"].startswith(("<Axes", "<matplotlib")):
            return None
    return output


def main() -> None:
    """Writes all notebooks with their outputs."""
    for path in NOTEBOOKS:
        with tempfile.TemporaryDirectory() as place:
            nbformat.write(run(path, Path(place)), path)  # type: ignore[no-untyped-call]


if __name__ == "__main__":
    main()
