"""Checks the links of all Markdown pages: files of the repository, headings of pages, and the form of addresses elsewhere. It needs no network."""

import doctest
import re
import subprocess
import sys
from pathlib import Path, PurePosixPath
from posixpath import normpath

LINK = re.compile(r"\]\(\s*<?([^\s<>)]+)>?[^)]*\)|^\s*\[[^\]]+\]:\s*(\S+)|<(https?:[^>]*)>", re.MULTILINE)
ELSEWHERE = re.compile(r"(https://([\w-]+\.)+[a-z]{2,}(:\d+)?(/[^\s\\]*)?|mailto:[\w.+-]+@[\w.-]+)")
FENCE = re.compile(r"^( *)(```+).*?^ *\2 *$", re.MULTILINE | re.DOTALL)


def blank(found):
    """Line breaks of a removed text, so that later lines keep their numbers."""
    return "\n" * found.group().count("\n")


def anchors(text):
    """Anchors of the headings, as GitHub and mdBook make them, and anchors set by hand."""
    found = set(re.findall(r'<[^>]* (?:id|name)="([^"]+)"', text))
    for heading in re.findall(r"^#+ +(.+?) *#*$", text, re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        number = 0
        while (numbered := f"{anchor}-{number}" if number else anchor) in found:
            number += 1
        found.add(numbered)
    return found


def broken(page, text, files, places):
    """Line, address and fault of each broken link of a page.

    >>> page = "# A `b` c\\n# A\\n# A\\n[](#a-b-c) [](#a-1) `[](code)`\\n[](#a-2) [](/q.md) [](https://a.org/b) [](http://a)"
    >>> for line, address, fault in broken("p/q.md", page, {"p/q.md"}, {"p/q.md": anchors(page)}):
    ...     print(line, address, fault)
    5 #a-2 has no heading in p/q.md
    5 /q.md does not exist
    5 http://a is not an address that starts with https:// or mailto:
    """
    text = re.sub(r"(`+).+?\1", blank, text, flags=re.DOTALL)
    for link in LINK.finditer(text):
        address = next(group for group in link.groups() if group)
        line = text.count("\n", 0, link.start()) + 1
        if re.match(r"\w+:", address):
            if not ELSEWHERE.fullmatch(address):
                yield line, address, "is not an address that starts with https:// or mailto:"
            continue
        path, _, anchor = address.partition("#")
        target = normpath(PurePosixPath(page).parent / path) if path else page
        if target not in files:
            yield line, address, "does not exist"
        elif anchor and anchor not in places.get(target, ()):
            yield line, address, f"has no heading in {target}"


def main():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], capture_output=True, text=True, check=True).stdout.splitlines()
    listed = [name for name in listed if Path(name).is_file()]
    files = set(listed) | {str(folder) for name in listed for folder in PurePosixPath(name).parents}
    pages = {name: FENCE.sub(blank, Path(name).read_text()) for name in listed if name.endswith(".md")}
    places = {name: anchors(text) for name, text in pages.items()}
    faults = [f"{page}:{line}: {address} {fault}" for page, text in pages.items() for line, address, fault in broken(page, text, files, places)]
    print("\n".join([*faults, f"{len(faults)} broken links"]))
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(doctest.testmod().failed or main())
