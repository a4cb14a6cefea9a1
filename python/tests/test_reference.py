"""The reference page of the book is generated from the docstrings."""

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


def test_the_reference_page_is_generated_from_the_docstrings() -> None:
    assert PAGE.read_bytes() == SCRIPT["page"]().encode(), "a docstring or a signature has changed: regenerate the page with `python python/reference.py`"


def parts() -> dict[str, str]:
    """Text under each heading of the page."""
    sections = PAGE.read_text(encoding="utf-8").split("\n### ")[1:]
    return {heading.strip("`"): rest.partition("\n## ")[0] for heading, _, rest in (section.partition("\n") for section in sections)}


def test_the_page_has_every_public_name_and_no_other() -> None:
    expected = {f"class {name}" if inspect.isclass(getattr(onset, name)) else name for name in onset.__all__}
    assert set(parts()) == expected


@pytest.mark.parametrize("name", onset.__all__)
def test_the_page_documents_every_member(name: str) -> None:
    """Arguments of functions; attributes, properties and methods of classes, each with a docstring."""
    thing: Any = getattr(onset, name)
    assert inspect.getdoc(thing)
    if not inspect.isclass(thing):
        text = parts()[name]
        assert all(argument in text for argument in inspect.signature(thing).parameters)
        return
    text = parts()[f"class {name}"]
    for member, value in vars(thing).items():
        if not member.startswith("_"):
            assert f"- `{member}" in text or f"- `{name}.{member}(" in text, member
            assert not callable(value) or inspect.getdoc(value), member
    # Every member has a description.
    assert all(item.partition("\n\n  ")[2].strip() for item in re.split(r"\n- `(?!`)(?![^`]*`: )", text)[1:])
