#!/usr/bin/python3
"""Each room of the code includes only from its own floor or below, and only ros/ and rviz/ depend on ROS.
Files have at most 400 lines, functions 50."""

import pathlib
import re
import sys
import xml.etree.ElementTree

BELOW_CONSTRAINTS = {"model", "geometry", "dynamics", "shapes", "search"}
SIMULATION = BELOW_CONSTRAINTS | {"constraints", "scene", "simulation"}
CORE = SIMULATION | {"run"}
MAY_INCLUDE = {
    "model": {"model"},
    "geometry": {"model", "geometry"},
    "dynamics": {"model", "dynamics"},
    "shapes": {"model", "geometry", "shapes"},
    "search": {"model", "geometry", "search"},
    "constraints": BELOW_CONSTRAINTS | {"constraints"},
    "scene": {"model", "geometry", "dynamics", "shapes", "scene"},
    "simulation": SIMULATION,
    "run": CORE,
    "render": {"model", "geometry", "shapes", "render"},
    "view": CORE | {"render", "view"},
    "python": CORE | {"render", "view", "python"},
    "ros": CORE | {"render", "view", "ros"},
    "rviz": CORE | {"render", "view", "ros", "rviz"},
    "benchmark": CORE | {"render", "view", "benchmark"},
}

package = pathlib.Path(__file__).resolve().parent.parent
manifest = xml.etree.ElementTree.parse(package / "package.xml").getroot()
ros_packages = {"ros", "clothsim"} | {
    element.text for element in manifest if "_" in element.text and "depend" in element.tag
}

MOST_LINES = 400
MOST_LINES_OF_FUNCTION = 50

NO_CODE = re.compile(r"""//[^\n]*|/\*[\s\S]*?\*/|R"\([\s\S]*?\)"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])'"""
                     r"""|^[ ]*\#(?:[^\n]*\\\n)*[^\n]*""", re.MULTILINE)
SCOPE = re.compile(r"(?:.*>\s*)?(?:inline )?(?:namespace|class|struct|enum|union|extern)\b(?!.*\)\s*$)")


def long_functions(text):
    """(line, length) of functions that are too long: only blocks in namespaces and classes count."""
    text = NO_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    begin, blocks = 0, []  # start of the statement; for each open block: is it a scope, and its line
    for place, character in enumerate(text):
        if character == "{":
            head = text[begin:place]
            line = text.count("\n", 0, place - len(head.lstrip())) + 1
            blocks.append((bool(SCOPE.match(" ".join(head.split()))), line))
        elif character == "}":
            is_scope, line = blocks.pop()
            length = text.count("\n", 0, place) + 2 - line
            in_scope = all(of_scope for of_scope, _ in blocks)
            if in_scope and not is_scope and length > MOST_LINES_OF_FUNCTION:
                yield line, length
        if character in ";{}" and all(of_scope for of_scope, _ in blocks):
            begin = place + 1


mistakes = 0
for base in ("include/clothsim", "src"):
    for path in sorted((package / base).rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        room = path.relative_to(package / base).parts[0]
        text, name = path.read_text(), path.relative_to(package)
        lines = text.splitlines()
        too_long = [f"{start}: a function of {length} lines" for start, length in long_functions(text)]
        if len(lines) > MOST_LINES:
            too_long.append(f"{len(lines)} lines")
        for what in too_long:
            mistakes += 1
            print(f"{name}:{what}")
        for number, line in enumerate(lines, 1):
            found = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line)
            if not found:
                continue
            parts = found.group(1).split("/")
            if parts[0] == "clothsim" and len(parts) > 2:
                fits = parts[1] in MAY_INCLUDE[room]
            else:
                fits = room in ("ros", "rviz") or parts[0] not in ros_packages
            if not fits:
                mistakes += 1
                print(f"{name}:{number}: {room}/ may not include {found.group(1)}")
sys.exit(mistakes > 0)
