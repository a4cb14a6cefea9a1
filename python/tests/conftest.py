"""What the tests share: the command, which answers the same questions."""

from __future__ import annotations

from dataclasses import dataclass
import os
from pathlib import Path
import subprocess

import pytest

#: The command, as `cargo xtask python` names it.
COMMAND = os.environ.get("ONSET_COMMAND", "onset")
REPOSITORY = Path(__file__).resolve().parents[2]
# What a type checker knows of other packages is found once.
os.environ["MYPY_CACHE_DIR"] = str(REPOSITORY / "target" / "mypy")


@dataclass(frozen=True)
class Told:
    """What the command has said."""

    code: int
    document: str
    error: str


def command(*arguments: str, cwd: Path | None = None) -> Told:
    """Asks the command for a document."""
    done = subprocess.run([COMMAND, *arguments, "--json"], capture_output=True, text=True, cwd=cwd, check=False)
    error = done.stderr.removeprefix("error: ").removesuffix("\n")
    return Told(done.returncode, done.stdout.removesuffix("\n"), error)


@pytest.fixture(autouse=True)
def no_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are drawn in memory."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
