"""Small scenes for the tests of the Python package, and paths of the repository."""

import pathlib

import numpy as np

CLONE = pathlib.Path(__file__).resolve().parents[2]
SCENES = CLONE / "config/scenes"


def free(points=8, **cloth):
    """A cloth in free fall."""
    return {"cloth": {"columns": points, "rows": points, "density": 5, **cloth}}


def busy(method="auto", **simulation):
    """A small cloth with a pin, a ball that follows a frame, the ground and self contact."""
    return {
        "cloth": {"columns": 10, "rows": 10, "thickness": 0.02, "self_collision": True, "ks": 300,
                  "pinned": [{"point": [0, 0], "frame": "hand"}]},
        "colliders": [
            {"name": "ball", "shape": "sphere", "center": [0.5, 0.5, 0.75], "frame": "ball",
             "friction": 0.5},
            {"name": "ground", "shape": "plane", "friction": 0.5}],
        "simulation": {"method": method, **simulation},
    }


def hanging(points=12, **cloth):
    """A cloth that is held at two corners and swings."""
    pins = [[0, 0], [points - 1, 0]]
    return free(points, pinned=pins, **cloth)


def same_state(a, b):
    return np.array_equal(a.positions, b.positions) and np.array_equal(a.velocities, b.velocities)
