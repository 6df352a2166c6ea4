#!/usr/bin/python3
"""docs/constants.md has each constant of the floors below as in the code: name, value, unit and
the words above it. With --write it writes that page."""

import difflib
import pathlib
import re
import sys

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
PAGE = PACKAGE / "docs/constants.md"
FLOORS = ("geometry", "dynamics", "shapes", "search", "constraints", "scene", "simulation", "run")

HEAD = """# Constants

This page has every named number of the layers
{floors}: {count} in {files} files. The words are those of
the comments in the code: the reason of a number, or its source. A number without a unit is a share or a count. Numbers
of a fitted formula stand in that formula alone (`method_choice.cpp`). Numbers that mathematics or a format sets, such
as the order of a method, are enumerators: the {structure} of them are at the end. [method.md](method.md) shows
the place of the numbers in the method. `test/check_constants.py --write` writes this page; `scripts/test` fails where
the page differs from the code.
"""

# A constant and the comment behind it. Its value has digits: left out are values that follow from others,
# the ranges of users' values, which docs/scenes.md has, and an index -1 for none.
CONSTANT = re.compile(r"(?:static |inline )*constexpr (?!Range|bool|const char|int \w+ = -1\b)[\w:]+(?:<[^>]*>)? "
                      r"(?P<name>\w+)(?:<\w+>)?(?: = (?P<value>(?:\w+ [*/] |-)?\d[^;]*)|"
                      r"(?P<list>\{[-\d][^;]*\}));(?:\s*// ?(?P<behind>.*))?$")
# A number of structure.
ENUMERATOR = re.compile(r"enum(?: : [\w:]+)? \{ (?P<name>\w+) = (?P<value>\d+) \};")
# These share their words with a number that has a unit, and have none.
PURE = {"max_violation_share", "margin", "lift"}
# Not the unit of a function of the number.
UNIT = re.compile(r"(?<!\) )\[((?:1/|k?)(?:m|s|g|N|J|K|Hz|rad|bytes)\b[\w/^ ]*)\]")


def words_above(lines, number):
    """The comment that ends above a line, in one."""
    words = []
    if number > 0 and lines[number - 1].strip().startswith("template"):
        number -= 1
    while number > 0 and lines[number - 1].strip().startswith("//"):
        number -= 1
        words.insert(0, lines[number].strip().lstrip("/").strip())
    return " ".join(words)


def indent_of(line):
    return len(line) - len(line.lstrip())


def words_around(lines, number):
    """The first two sentences above the function or class that a line is in; empty where there are
    none."""
    indent, words = indent_of(lines[number]), ""
    while indent > 0 and number > 0 and not words:
        number -= 1
        if lines[number].strip() and indent_of(lines[number]) < indent:
            indent = indent_of(lines[number])
            words = words_above(lines, number)
    while number > 0 and not words and lines[number - 1].strip():
        number -= 1  # of a head of several lines
        words = words_above(lines, number)
    return " ".join(re.split(r"(?<=[.?:]) +(?=[A-Z])", words)[:2])


def constants_of(path):
    """Rows of a file: name, value, unit, words. Successive constants share the words above the first."""
    lines, rows, above, last = path.read_text().splitlines(), [], "", -2
    for number, line in enumerate(lines):
        found = CONSTANT.match(line.strip())
        if not found:
            continue
        new = words_above(lines, number)
        follows = last == number - 1 and not new
        above = above if follows else new
        last = number
        behind = found["behind"] or ""
        words = "; ".join(filter(None, [behind, above])) or words_around(lines, number)
        units = UNIT.findall(behind or above)
        rows.append((found["name"], found["value"] or found["list"],
                     units[0] if len(set(units)) == 1 and found["name"] not in PURE else "", words))
    return rows


def enumerators_of(path):
    """Rows of a file: name, value, the file."""
    return [(found["name"], found["value"], path.relative_to(PACKAGE).as_posix())
            for found in map(ENUMERATOR.match, map(str.strip, path.read_text().splitlines())) if found]


def row(cells):
    name, value, unit, words = (cell.replace("|", "\\|") for cell in cells)
    return f"| `{name}` | {value} | {unit} | {words} |"


def page():
    parts, count, files, structure = [], 0, 0, []
    for floor in FLOORS:
        heading = f"\n## {floor}\n"
        for base in ("include/clothsim", "src"):
            for path in sorted((PACKAGE / base / floor).glob("*")):
                structure += enumerators_of(path)
                rows = constants_of(path)
                if not rows:
                    continue
                count += len(rows)
                files += 1
                parts.append(f"{heading}\n### {path.relative_to(PACKAGE)}\n")
                heading = ""  # once
                parts.append("\n| name | value | unit | why |\n|---|---|---|---|\n")
                parts.append("\n".join(map(row, rows)) + "\n")
    floors = ", ".join(FLOORS[:-1]) + " and " + FLOORS[-1]
    parts.append("\n## Structure\n\n| name | value | file |\n|---|---|---|\n")
    parts += [f"| `{name}` | {value} | {path} |\n" for name, value, path in structure]
    return HEAD.format(floors=floors, count=count, files=files, structure=len(structure)) + "".join(parts)


def main():
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(page())
        return 0
    written, now = PAGE.read_text(), page()
    if written == now:
        return 0
    for line in difflib.unified_diff(written.splitlines(), now.splitlines(), "docs/constants.md",
                                     "the code", n=0, lineterm=""):
        print(line)
    print("test/check_constants.py --write writes the page anew")
    return 1


if __name__ == "__main__":
    sys.exit(main())
