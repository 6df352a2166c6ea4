"""How well a towel of config/sweeps/towel.yaml is folded at the end of a case."""

import numpy as np

SIDE = 0.4  # [m]
LARGEST_ERROR = 0.03  # [m] between the edges of a fold that succeeds
HIGHEST = 0.08  # [m] of one that lies


def measure(folder):
    """`folder` is a pathlib.Path; the numbers go into the table."""
    positions = np.load(folder / "final.npz")["positions"]
    n = round(len(positions) ** 0.5)
    grid = positions.reshape(n, n, 3)  # rows from the front edge, which was carried, to the back
    error = float(np.linalg.norm(grid[0, :, :2] - grid[-1, :, :2], axis=1).max())
    slip = float(np.abs(grid[-1, :, 1] - SIDE).max())
    height = float(positions[:, 2].max())
    return {"edge_error": error, "slip": slip, "height": height,
            "success": float(error < LARGEST_ERROR and slip < LARGEST_ERROR and height < HIGHEST)}
