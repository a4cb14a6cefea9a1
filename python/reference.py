"""Generates the page of the book on every public name from the docstrings: ``python python/reference.py``."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
import re
import textwrap

PACKAGE = Path(__file__).resolve().parent / "onset"
PAGE = PACKAGE.parents[1] / "book" / "src" / "how-to" / "python-reference.md"

INTRODUCTION = """\
# Python: every name

All public names of `import onset`. [In Python](python.md) shows how they are used. The page is generated from the docstrings, which `help(onset.state)`
also prints.

In shapes `D` is the number of dimensions of the lattice (1, 2 or 3), `branches` is the number of waves with one wave vector (`D` for each particle of a cell), and
`...` are further axes, if any. Units are given by their dimension: stresses have the unit of the material parameters, lengths the unit of the spacing.
If settings have units, answers are in SI. [Conventions](../conventions.md) defines the symbols, [Words](../words.md#verdicts) the verdicts; the types are
[explained at the end](#types).\
"""
SETTINGS = """\
Materials and methods are immutable and hashable; two of them are equal if their settings are equal. Obsolete names of keys and values are accepted with a
`UserWarning`. A `UserWarning` is also issued for the state of a study if the function takes another state.\
"""
FUNCTIONS = """\
`material` is a `Material`, the name of a law or a formula; `method` is a `Method` or the name of a family. If omitted, they are the defaults of the
command. A state is either `stretch`, the principal stretches along the axes, shape (D,) to (3,), with missing stretches 1, or the deformation gradient
`F`, shape (3, 3), or (D, D) without strain out of the D dimensions.

Invalid input raises an `InputError` (for a setting, a `SettingError`), an argument of a wrong type a `TypeError`, and a failure with valid input a
`MachineError`.\
"""
ANSWERS = """\
The functions above return these classes. All are immutable `Answer`s that consist of `Record`s, except `Verdicts` and `Dispersion`, which contain arrays.
`plot` needs matplotlib, and raises an `OnsetError` without it.\
"""
ERRORS = "The exceptions can be pickled and passed between processes."
TYPES = "Types of other packages are `ArrayLike` and `NDArray` (`numpy.typing`), `Axes` (`matplotlib.axes`) and `xarray.Dataset`."

EXPORTS = "The method `mode` of an answer with waves returns a `Mode`. [In Python](python.md) shows it in motion."

#: Parts of the page: the module of each, and an introduction.
PARTS = {
    "Settings": ("_settings", SETTINGS),
    "Functions": ("_ask", FUNCTIONS),
    "Answers": ("_answers", ANSWERS),
    "Modes for other tools": ("_exports", EXPORTS),
    "Errors": ("_errors", ERRORS),
}


class Module:
    """Source of a module of the package."""

    def __init__(self, name: str) -> None:
        self.text = (PACKAGE / f"{name}.py").read_text(encoding="utf-8")
        self.lines = self.text.splitlines()
        self.body = ast.parse(self.text).body
        self.classes = {node.name: node for node in self.body if isinstance(node, ast.ClassDef)}

    def written(self, node: ast.AST | None) -> str:
        return ast.get_source_segment(self.text, node) or "" if node is not None else ""

    def comment(self, node: ast.stmt) -> str:
        """Returns the comment after ``#:`` above a statement."""
        start = end = node.lineno - 1
        while self.lines[start - 1].lstrip().startswith("#:"):
            start -= 1
        return "\n".join(line.strip().removeprefix("#: ") for line in self.lines[start:end])

    def call(self, function: ast.FunctionDef, name: str) -> str:
        """Returns the signature of a function under a name."""
        head = textwrap.dedent("\n".join(self.lines[function.lineno - 1 : function.body[0].lineno - 1]))
        rest = head.removeprefix(f"def {function.name}").removesuffix(":").removesuffix(" -> None")
        return name + re.sub(r"(?<=\()(\s*)(self|cls)(,\s*|(?=\)))", r"\1", rest, count=1)

    def members(self, owner: ast.ClassDef, name: str) -> Iterator[tuple[str, str]]:
        """Yields attributes, properties and methods of a class and of its private bases under its name, with their descriptions."""
        for node in owner.body:
            match node:
                case ast.AnnAssign():
                    yield f"{self.written(node.target)}: {self.written(node.annotation)}", self.comment(node)
                case ast.FunctionDef(name="__init__"):
                    for made in node.body:
                        if isinstance(made, ast.AnnAssign) and isinstance(made.target, ast.Attribute):
                            yield f"{made.target.attr}: {self.written(made.annotation)}", self.comment(made)
                case ast.FunctionDef():
                    kinds = [self.written(decorator) for decorator in node.decorator_list]
                    if "property" in kinds:
                        call = f"{node.name}: {self.written(node.returns)}"
                    else:
                        call = " ".join(self.call(node, node.name).split()).replace("( ", "(").replace(", )", ")")
                    yield f"{name}.{call}" if "classmethod" in kinds else call, markdown(ast.get_docstring(node) or "")
        for base in owner.bases:
            if isinstance(base, ast.Name) and base.id.startswith("_"):
                yield from self.members(self.classes[base.id], name)


    def head(self, owner: ast.ClassDef) -> str:
        """Returns the first line of a class, with the public bases."""
        bases = [base for name in owner.bases for base in self.public(self.written(name))]
        return f"class {owner.name}({', '.join(bases)})" if bases else f"class {owner.name}"

    def public(self, base: str) -> list[str]:
        """Returns a public base, or the public bases of a private base."""
        if not base.startswith("_"):
            return [base]
        return [known for name in self.classes[base].bases for known in self.public(self.written(name))]


def block(code: str) -> str:
    """Returns a code block that is not executed."""
    return f"```python,ignore\n{code}\n```"


def markdown(docstring: str) -> str:
    """Returns a docstring with its NumPy sections as Markdown lists."""
    text, _, examples = docstring.partition("Examples\n--------\n")
    if examples:
        return f"{markdown(text).rstrip()}\n\n**Example**\n\n{block(examples.rstrip())}"
    text = re.sub(r"^(Parameters|Returns|Raises)\n-+\n", r"**\1**\n\n", docstring, flags=re.MULTILINE)
    text = re.sub(r"^(\S[^\n]*)\n    (?=\S)", r"- `\1`: ", text, flags=re.MULTILINE)
    return re.sub(r"^    (?=\S)", "  ", text, flags=re.MULTILINE)


def item(code: str, told: str) -> str:
    return f"- `{code}`\n\n{textwrap.indent(told, '  ')}"


def link(name: str) -> str:
    """Returns a public name with a link to its heading."""
    return f"[`{name}`](#{name if name.islower() else f'class-{name.lower()}'})"


def entry(module: Module, node: ast.ClassDef | ast.FunctionDef, is_made: bool) -> list[str]:
    """Returns the entry of a function or a class; `is_made` adds the constructor of a class."""
    told = markdown(ast.get_docstring(node) or "")
    if isinstance(node, ast.FunctionDef):
        return [f"### `{node.name}`", block(f"def {module.call(node, node.name)}"), told]
    maker = next((made for made in node.body if isinstance(made, ast.FunctionDef) and made.name == "__init__"), None)
    call = module.call(maker, node.name) if maker and is_made else module.head(node)
    members = [item(code, told) for code, told in module.members(node, node.name) if not code.startswith("_")]
    return [f"### `class {node.name}`", block(call), told, *members]


def types(modules: list[Module], page: str, public: list[str]) -> Iterator[str]:
    """Yields the types on the page that are not public names."""
    for module in modules:
        for node in module.body:
            match node:
                case ast.Assign(targets=[ast.Name(id=name)]):
                    code, told = module.written(node), module.comment(node)
                case ast.ClassDef(name=name):
                    code, told = f"class {name}", markdown(ast.get_docstring(node) or "")
                case _:
                    continue
            if told and name not in public and re.search(rf"[:\[|,>] ?{name}\b", page):
                yield item(code, told)


def page() -> str:
    """Returns the page in Markdown."""
    names = next(node.value for node in Module("__init__").body if isinstance(node, ast.Assign) and isinstance(node.value, ast.List))
    public: list[str] = ast.literal_eval(names)
    modules = {name: Module(name) for name in ("_arrays", *(module for module, _ in PARTS.values()))}
    contents, parts = [], []
    for part, (name, told) in PARTS.items():
        module = modules[name]
        nodes = [node for node in module.body if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name in public]
        contents.append(f"- [{part}](#{part.lower().replace(' ', '-')}): {', '.join(link(node.name) for node in nodes)}")
        parts += [f"## {part}", told, *(piece for node in nodes for piece in entry(module, node, is_made=part == "Settings"))]
    parts += ["## Types", TYPES, *types(list(modules.values()), "\n".join(parts), public)]
    text = "\n\n".join([INTRODUCTION, "\n".join(contents), *parts]) + "\n"
    return re.sub(r"``onset\.(\w+)``", lambda found: link(found[1]) if found[1] in public else found[0], text)


if __name__ == "__main__":
    PAGE.write_bytes(page().encode())
