"""The page of the book on every name is what the docstrings say."""

from __future__ import annotations

import inspect
import re
import runpy
from typing import Any

import onset
import pytest

from conftest import REPOSITORY

SCRIPT = runpy.run_path(str(REPOSITORY / "python" / "reference.py"), run_name="reference")
PAGE = REPOSITORY / "book" / "src" / "how-to" / "python-reference.md"


def test_the_page_is_what_the_docstrings_say() -> None:
    assert PAGE.read_bytes() == SCRIPT["page"]().encode(), "a docstring or a signature has changed: make the page again by `python python/reference.py`"


def parts() -> dict[str, str]:
    """What stands under each heading of the page."""
    sections = PAGE.read_text(encoding="utf-8").split("\n### ")[1:]
    return {heading.strip("`"): rest.partition("\n## ")[0] for heading, _, rest in (section.partition("\n") for section in sections)}


def test_the_page_has_every_public_name_and_no_other() -> None:
    expected = {f"class {name}" if inspect.isclass(getattr(onset, name)) else name for name in onset.__all__}
    assert set(parts()) == expected


@pytest.mark.parametrize("name", onset.__all__)
def test_the_page_tells_of_every_part_of(name: str) -> None:
    """Arguments of functions; attributes, properties and methods of classes, each with a docstring."""
    thing: Any = getattr(onset, name)
    assert inspect.getdoc(thing)
    if not inspect.isclass(thing):
        told = parts()[name]
        assert all(argument in told for argument in inspect.signature(thing).parameters)
        return
    told = parts()[f"class {name}"]
    for member, value in vars(thing).items():
        if not member.startswith("_"):
            assert f"- `{member}" in told or f"- `{name}.{member}(" in told, member
            assert not callable(value) or inspect.getdoc(value), member
    # No item is without a text.
    assert all(item.partition("\n\n  ")[2].strip() for item in re.split(r"\n- `(?!`)", told)[1:])
