#!/usr/bin/python3
"""The documents are consistent: each relative link leads to a file of the clone, each anchor to a
heading, no formula is left open, and README and the method keep their limits of length."""

import pathlib
import re
import sys

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
LONGEST_README = 200  # lines
LONGEST_METHOD = 2500  # words, besides displayed formulas and code


def documents():
    return [PACKAGE / "README.md", *sorted((PACKAGE / "docs").glob("*.md"))]


def without_blocks(text):
    """The text without code and displayed formulas."""
    return re.sub(r"^ *```.*?^ *```|\$\$.*?\$\$", "", text, flags=re.DOTALL | re.MULTILINE)


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", without_blocks(text))


def anchors(text):
    """Anchors of a document's headings, as GitHub makes them."""
    seen, found = {}, set()
    for heading in re.findall(r"^#+ (.*)$", without_blocks(text), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        count = seen.get(slug, 0)
        seen[slug] = count + 1
        found.add(f"{slug}-{count}" if count else slug)
    return found


def wrong_links(path, text):
    for target in re.findall(r"\]\(([^()\s]+)\)", without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        place = (path.parent / name).resolve() if name else path
        if not place.exists() or PACKAGE not in place.parents:
            yield f"there is no {target}"
        elif anchor and anchor not in anchors(place.read_text()):
            yield f"{target}: there is no such heading"


def wrong_formulas(text):
    """Lines with an odd number of dollars, where a formula is left open."""
    for line in without_code(text).splitlines():
        if line.count("$") % 2:
            yield f"a formula is left open: {line}"


def mistakes():
    for path in documents():
        text = path.read_text()
        for mistake in (*wrong_links(path, text), *wrong_formulas(text)):
            yield f"{path.relative_to(PACKAGE)}: {mistake}"
    lines = len((PACKAGE / "README.md").read_text().splitlines())
    if lines > LONGEST_README:
        yield f"README.md: {lines} lines, {LONGEST_README} at most"
    words = len(without_blocks((PACKAGE / "docs/method.md").read_text()).split())
    if words > LONGEST_METHOD:
        yield f"docs/method.md: {words} words, {LONGEST_METHOD} at most"


if __name__ == "__main__":
    found = list(mistakes())
    print("\n".join(found))
    sys.exit(bool(found))
