#!/usr/bin/python3
"""Each room of the code includes only from its own floor or below, and only ros/ and rviz/ know ROS."""

import pathlib
import re
import sys
import xml.etree.ElementTree

BELOW_SIMULATION = {"model", "geometry", "dynamics", "shapes", "search", "constraints"}
CORE = BELOW_SIMULATION | {"simulation"}
MAY_INCLUDE = {
    "model": {"model"},
    "geometry": {"model", "geometry"},
    "dynamics": {"model", "dynamics"},
    "shapes": {"model", "geometry", "shapes"},
    "search": {"model", "geometry", "search"},
    "constraints": BELOW_SIMULATION,
    "simulation": CORE,
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

mistakes = 0
for base in ("include/clothsim", "src"):
    for path in sorted((package / base).rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        room = path.relative_to(package / base).parts[0]
        for number, line in enumerate(path.read_text().splitlines(), 1):
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
                name = path.relative_to(package)
                print(f"{name}:{number}: {room}/ may not include {found.group(1)}")
sys.exit(mistakes > 0)
