"""Prose that a native reader would send back: docs, comments, messages, pages of the book, and names of tests and constants.

`cargo xtask english` lists the places, `cargo xtask test` fails if a file has more of them than `allowed.txt` grants. A place is to be read, and the sentence
rewritten; an expression is not a verdict. Patterns and advice are in `patterns.txt`.
"""

import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
KINDS = {"doc", "fn", "more", "comment", "message", "page", "test"}
# Largest number of words in a sentence.
LONGEST = {"page": 45}
LONGEST_ELSE = 40
STRING = re.compile(r'"((?:[^"\\]|\\.)*)')


def patterns():
    """Name, kinds, expression and advice of each pattern."""
    for line in (HERE / "patterns.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            name, kinds, expression, advice = line.split("\t")
            flags = 0 if name in ("headless", "of-first") else re.IGNORECASE
            yield name, set(kinds.split()) or KINDS, re.compile(expression, flags), advice


def plain(text):
    """The text without code, formulas and the targets of links."""
    text = re.sub(r"`[^`]*`|\$[^$]*\$|\[([^\]]*)\]\([^)]*\)", lambda m: m.group(1) or "X", text)
    return re.sub(r"\s+", " ", text).strip()


def of_page(text):
    """Paragraphs, list items and rows of a page, with their lines."""
    is_code, part, begin = False, [], 0
    for number, line in enumerate([*text.split("\n"), ""], 1):
        if line.lstrip().startswith("```"):
            is_code, line = not is_code, ""
        starts = re.match(r"\s*([-*|#>]|\d+\.)", line)
        if is_code or not line.strip() or starts:
            if part:
                yield "page", begin, plain(" ".join(part))
                part = []
            if is_code or not line.strip():
                continue
        if not part:
            begin = number
        part.append(re.sub(r"^\s*([-*>#]+|\d+\.)\s*", "", line).replace("|", " "))


def messages(number, line):
    """Texts of six words or more in a line of code; no code, dates or options."""
    for found in STRING.finditer(line):
        message = re.sub(r"\{[^}]*\}", "X", found.group(1)).strip()
        if len(re.findall(r"[A-Za-z]{2,}", message)) >= 6 and not re.search(r"\b(1[89]|20)\d\d\b|::|[<>]|\b\w+ = |--\w+.*--\w+", message):
            yield "message", number, message


def of_script(text, is_python):
    """Docs and comments of Python and TypeScript, messages of Python, and names of its tests."""
    docs = re.compile(r'"""(.*?)"""|/\*\*(.*?)\*/', re.DOTALL)
    for found in docs.finditer(text):
        if text[: found.start()].endswith(("= ", "(")):
            continue
        doc = re.sub(r"\n\s*\*", "\n", found.group(1) or found.group(2) or "")
        yield "doc", text.count("\n", 0, found.start()) + 1, plain(doc.split("\n\n")[0])
    code = docs.sub(lambda found: "\n" * found.group().count("\n"), text)
    for number, line in enumerate(code.split("\n"), 1):
        comment = re.match(r"\s*(?:#:?|//) (.*)", line)
        if comment:
            yield "comment", number, plain(comment.group(1))
        name = re.match(r"def test_(\w+_\w+_\w+)\(", line)
        if name:
            yield "test", number, name.group(1).replace("_", " ")
        elif is_python:
            yield from messages(number, line)


def of_rust(text, is_test):
    """Docs (of functions: `fn`; paragraphs after the first: `more`), comments, messages and constants; of tests names and comments."""
    doc, comment, begin, is_code = [], [], 0, False
    for number, line in enumerate([*text.split("\n"), ""], 1):
        code = line.strip()
        is_test |= code.startswith("#[cfg(test)]")
        if is_test:
            if re.match(r"//[/!]? ", code):
                begin = begin if comment else number
                comment.append(code.lstrip("/!"))
                continue
            if comment:
                yield "comment", begin, plain(" ".join(comment))
                comment = []
            name = re.match(r"(?:async )?fn (\w+_\w+_\w+)\(\)", code)
            if name:
                yield "test", number, name.group(1).replace("_", " ")
            continue
        if code.startswith(("///", "//!")):
            word = code[3:].strip()
            if word.startswith("```"):
                is_code = not is_code
            elif not is_code:
                begin = begin if doc else number
                doc.append(word)
            continue
        if doc and not code.startswith("#["):
            is_fn = re.match(r"(pub(\([^)]*\))? )?(const |async )*fn ", code)
            first = plain("\n".join(doc).split("\n\n")[0].replace("# Errors", ""))
            yield "fn" if is_fn else "doc", begin, first
            whole = plain(" ".join(word for word in doc if not word.startswith(("#", "|"))))
            if len(whole) > len(first):
                yield "more", begin, whole[len(first) :].strip()
            doc = []
        if code.startswith("// "):
            begin = begin if comment else number
            comment.append(code[3:])
            continue
        if comment:
            yield "comment", begin, plain(" ".join(comment))
            comment = []
        constant = re.match(r"(?:pub(?:\([^)]*\))? )?(?:const|static) ([A-Z]\w*):", code)
        if constant:
            yield "constant", number, constant.group(1)
        yield from messages(number, line)


def parts(path, text):
    if path.suffix == ".md":
        return of_page(text)
    if path.suffix == ".rs":
        return of_rust(text, "tests" in path.parts or path.name == "tests.rs")
    return of_script(text, path.suffix != ".ts")


def is_read(path):
    """Returns true for Rust and Markdown, the Python package with its tests, and the page."""
    return path.suffix in (".rs", ".md", ".ts") or path.parts[:2] == ("python", "onset") or (path.suffix == ".py" and path.parts[:2] == ("python", "tests"))


def hits(kind, text, all_patterns):
    for name, kinds, expression, _ in all_patterns:
        if kind in kinds and expression.search(text):
            yield name
    sentences = re.split(r"(?<=[.?!]) ", text)
    if any(len(sentence.split()) > LONGEST.get(kind, LONGEST_ELSE) for sentence in sentences):
        yield "long"
    if any(sentence.count(";") > 1 for sentence in sentences):
        yield "semicolons"


def main(names):
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], capture_output=True, text=True, check=True).stdout.splitlines()
    allowed = {}
    for line in (HERE / "allowed.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            count, name, _reason = line.split(maxsplit=2)
            allowed[name] = int(count)
    all_patterns = list(patterns())
    advice = {name: text for name, _, _, text in all_patterns}
    advice |= {"long": "too many words in a sentence -> two sentences", "semicolons": "two in a sentence -> a list, or sentences"}
    failed = False
    total = 0
    for name in sorted(listed):
        path = Path(name)
        if not is_read(path) or not path.is_file() or path.suffix == ".pyc":
            continue
        found = [(line, hit, text) for kind, line, text in parts(path, path.read_text()) for hit in hits(kind, text, all_patterns)]
        total += len(found)
        is_asked = any(name.startswith(asked) for asked in names)
        is_over = not names and len(found) > allowed.get(name, 0)
        failed |= is_over
        if is_asked or is_over:
            for line, hit, text in found:
                print(f"{name}:{line}: [{hit}] {text[:120]}\n    {advice[hit]}")
        if is_over:
            print(f"{name}: {len(found)} places, {allowed.get(name, 0)} are allowed")
    print(f"{total} places that a native reader might send back")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
