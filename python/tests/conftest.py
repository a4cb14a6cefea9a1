"""Shared fixtures: the command line as reference."""

from __future__ import annotations

from dataclasses import dataclass
import os
from pathlib import Path
import subprocess

import pytest

#: Path or name of the `onset` command; `cargo xtask python` sets it.
COMMAND = os.environ.get("ONSET_COMMAND", "onset")
REPOSITORY = Path(__file__).resolve().parents[2]
# Stubs of other packages are located once.
os.environ["MYPY_CACHE_DIR"] = str(REPOSITORY / "target" / "mypy")


@dataclass(frozen=True)
class Output:
    """Exit code and output of the command."""

    code: int
    document: str
    error: str


def command(*arguments: str, cwd: Path | None = None) -> Output:
    """Runs the command with `--json`."""
    done = subprocess.run([COMMAND, *arguments, "--json"], capture_output=True, text=True, cwd=cwd, check=False)
    error = done.stderr.removeprefix("error: ").removesuffix("\n")
    return Output(done.returncode, done.stdout.removesuffix("\n"), error)


@pytest.fixture(autouse=True)
def no_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are drawn in memory."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
