"""Collects the licenses of all that is linked into the command or the Python package: crates, the standard library of Rust, and the embedded font.

`python python/licenses.py OUT [PACKAGE]` writes them into the file OUT, for `onset-cli` by default. The exit code is 1 if a crate has a license that is not
admitted below. A crate that ships no license text gets the text of the MIT license, if it may be used under it.
"""

from __future__ import annotations

import json
from pathlib import Path
import re
import subprocess
import sys
from typing import Any

#: Licenses that permit the uses permitted by the licenses of this project, if their texts are shipped.
ADMITTED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-1-Clause", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "ISC", "MIT",
    "Unicode-3.0", "Unlicense", "Zlib",
}  # fmt: skip
#: Names of files that contain a license, or a notice that a license requires to be distributed.
TEXTS = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)
OWN = ("onset", "xtask")
ROOT = Path(__file__).resolve().parent.parent
#: The MIT license below its line of copyright.
PERMISSION = (ROOT / "LICENSE-MIT").read_text(encoding="utf-8").split("\n\n", 2)[2].strip()


def linked(package: str) -> list[dict[str, Any]]:
    """Crates that are linked into a package on any system, as entries of `cargo metadata`."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    read = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    packages = {found["id"]: found for found in read["packages"]}
    nodes = {node["id"]: node for node in read["resolve"]["nodes"]}
    todo = [found["id"] for found in packages.values() if found["name"] == package]
    reached: set[str] = set()
    while todo:
        here = todo.pop()
        if here not in reached:
            reached.add(here)
            normal = (other for other in nodes[here]["deps"] if any(kind["kind"] is None for kind in other["dep_kinds"]))
            todo += [other["pkg"] for other in normal]
    found = (packages[here] for here in reached)
    return sorted((crate for crate in found if not crate["name"].startswith(OWN)), key=lambda crate: (crate["name"], crate["version"]))


def is_admitted(expression: str) -> bool:
    """Returns true if one side of each choice in an SPDX expression is admitted. Older crates write a choice with a slash."""
    terms = re.split(r"\s+AND\s+", expression.replace("/", " OR ").replace("(", "").replace(")", ""))
    return all(any(choice.strip() in ADMITTED for choice in re.split(r"\s+OR\s+", term)) for term in terms)


def main(out: str, package: str = "onset-cli") -> int:
    """Writes the file and returns the exit code."""
    texts: dict[str, list[str]] = {}
    faults = []
    for crate in linked(package):
        name = f"{crate['name']} {crate['version']}"
        folder = Path(crate["manifest_path"]).parent
        files = sorted(path for path in folder.iterdir() if path.is_file() and TEXTS.search(path.name))
        if not is_admitted(crate["license"] or ""):
            faults.append(f"{name}: the license {crate['license']} is not among those admitted")
        if not files and "MIT" not in crate["license"]:
            faults.append(f"{name}: no text of the license {crate['license']}")
        elif not files:
            authors = ", ".join(crate["authors"]) or f"the authors of {crate['name']}"
            texts.setdefault(f"Copyright (c) {authors}\n\n{PERMISSION}", []).append(f"{name} ({crate['license']}), {crate['repository']}")
        for path in files:
            texts.setdefault(path.read_text(encoding="utf-8", errors="replace").strip(), []).append(f"{name} ({crate['license']}), {path.name}")
    texts.setdefault(f"Copyright (c) The Rust Project Contributors\n\n{PERMISSION}", []).append("standard library of Rust (MIT OR Apache-2.0)")
    font = ROOT / "crates/onset-study/src/figure/DejaVu-LICENSE.txt"
    texts.setdefault(font.read_text(encoding="utf-8").strip(), []).append("DejaVu Sans, embedded in figures")
    for fault in faults:
        print(fault, file=sys.stderr)
    head = "Licenses of the crates, the standard library and the font that are linked into this program. Of a crate that offers a choice, all texts follow.\n"
    rule = "\n" + "=" * 100 + "\n"
    parts = ("\n".join(names) + "\n\n" + text + "\n" for text, names in sorted(texts.items(), key=lambda entry: entry[1][0]))
    Path(out).write_text(head + "".join(rule + part for part in parts), encoding="utf-8")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
