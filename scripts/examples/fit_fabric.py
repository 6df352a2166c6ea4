#!/usr/bin/python3
"""Fits a fabric to a measurement of a real cloth, by scipy's least squares: docs/fitting.md describes the experiment.

    fit_fabric.py                  # to a synthetic measurement
    fit_fabric.py markers.csv      # to yours, a .csv or an .npz

A strip is held by its upper edge, released from the horizontal, and swings until it nearly rests. Then a weight is
lowered onto its lower edge. Stretch follows from the lowering of the weight, bending from the strip's curvature, damping
and drag from the decay of the swings.
"""

import argparse
import csv
import pathlib

import numpy as np
import scipy.optimize
import scipy.spatial

import clothsim

COLUMNS, ROWS = 6, 15
SCENE = {  # the measured strip: its size, weight and shear, by ruler, scale and table; for clouds its stretch
    "cloth": {"width": 0.15, "height": 0.42, "columns": COLUMNS, "rows": ROWS, "density": 0.187,
              "stretch_stiffness": [60, 60], "shear_stiffness": 15, "bending_stiffness": [1e-5, 1e-5],
              "thickness": 0.0005, "pinned": [[column, 0] for column in range(COLUMNS)]},
    # Steps that do not depend on the sought values, so that the residual is smooth; still air.
    "simulation": {"method": "verlet", "substeps": 40, "wind": [0, 0, 0]},
}
WEIGHT, HUNG_AT, TAKES = 0.3, 2.0, 0.5  # [N] on the lower edge, begin and duration of its lowering [s]
NOISE = 1e-3  # [m] of a measurement
PRECISE = 1e-4  # relative change of a value that ends the search, far below what noise allows
BESIDE = np.geomspace(0.75, 1.33, 8)  # multiples of a found value, at which a better one may be

# By live value: its value for a sought number, first guess, lower and upper bound.
SOUGHT = {
    "stretch_stiffness": (lambda x: [x, x], 100.0, 20.0, 500.0),  # [N/m]
    "bending_stiffness": (lambda x: [x, x], 3e-5, 1e-6, 3e-4),  # [N m]
    "internal_damping": (lambda x: [1e-5, x], 3e-3, 1e-4, 1e-1),  # [s] of bending
    "drag": (lambda x: [x, 0.02], 0.5, 0.05, 5.0),  # across the surface
}
TRUTH = {"stretch_stiffness": 60.0, "bending_stiffness": 1.2e-5, "internal_damping": 1.5e-2, "drag": 1.17}


class Measurement:
    """Rows of `times` [K] [s] and `points` [K, 3] [m]; for markers also their coordinates on the cloth, `uv`
    [K, 2] in [0, 1] from the held edge's first corner. Without uv the points are those of a cloud, which does
    not show stretch."""

    def __init__(self, times, points, uv=None):
        seen = np.isfinite(points).all(axis=1)
        order = np.argsort(times[seen], kind="stable")
        self.times, self.points = times[seen][order], points[seen][order]
        self.uv = None if uv is None else uv[seen][order]

    @classmethod
    def load(cls, path):
        """CSV with the header time,x,y,z or time,u,v,x,y,z, or NPZ with times [T], positions [T, M, 3]
        and, for markers, uv [M, 2]."""
        if pathlib.Path(path).suffix == ".npz":
            with np.load(path) as file:
                positions, times = file["positions"], file["times"]
                uv = np.tile(file["uv"], (len(times), 1)) if "uv" in file else None
            return cls(np.repeat(times, positions.shape[1]), positions.reshape(-1, 3), uv)
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
        if not rows or not {"time", "x", "y", "z"} <= set(rows[0]):
            raise SystemExit(f"{path}: expected the header time,x,y,z or time,u,v,x,y,z and numbers below")

        def columns(*names):
            return np.array([[float(row[name] or "nan") for name in names] for row in rows])
        return cls(columns("time")[:, 0], columns("x", "y", "z"),
                   columns("u", "v") if "u" in rows[0] else None)


def weights_of(uv):
    """Bilinear weights of the grid's points at places on the cloth, [K, N]."""
    weights = np.zeros((len(uv), ROWS * COLUMNS))
    place = np.clip(uv, 0, 1) * [COLUMNS - 1, ROWS - 1]
    cell = np.minimum(place.astype(int), [COLUMNS - 2, ROWS - 2])
    share = place - cell
    for right, up in np.ndindex(2, 2):
        point = (cell[:, 1] + up) * COLUMNS + cell[:, 0] + right
        part = np.abs(1 - right - share[:, 0]) * np.abs(1 - up - share[:, 1])
        weights[np.arange(len(uv)), point] += part
    return weights


class Model:
    """Runs the experiment repeatedly in one simulator."""

    def __init__(self):
        self.simulator = clothsim.Simulator(SCENE)
        self.start = self.simulator.save()
        self.weight = np.zeros((ROWS * COLUMNS, 3))
        self.weight[-COLUMNS:, 2] = -WEIGHT / COLUMNS
        across, along = np.linspace(0, 1, 31), np.linspace(0, 1, 85)  # for the nearest to a cloud's point, 5 mm apart
        self.surface = weights_of(np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2))

    def run(self, values, times):
        """Yields the points [N, 3] at each of `times`, which ascend."""
        self.simulator.set(stretch_stiffness=SCENE["cloth"]["stretch_stiffness"])
        self.simulator.set(**{name: SOUGHT[name][0](value) for name, value in values.items()})
        self.simulator.restore(self.start)
        frame = self.simulator.frame_duration
        before = after = np.array(self.simulator.positions)
        for time in times:
            while self.simulator.time < time - 1e-9:
                share = np.clip((self.simulator.time - HUNG_AT) / TAKES, 0, 1)
                self.simulator.forces = share * self.weight if share > 0 else None
                self.simulator.step()
                before, after = after, np.array(self.simulator.positions)
            share = np.clip((self.simulator.time - time) / frame, 0, 1)
            yield share * before + (1 - share) * after

    def residual(self, values, measured):
        """Residual [m]: each component of a marker's position, distance of a cloud's point from the cloth."""
        times, first = np.unique(measured.times, return_index=True)
        parts = np.split(measured.points, first[1:])
        places = np.split(measured.uv, first[1:]) if measured.uv is not None else [None] * len(parts)
        errors = []
        for cloth, points, uv in zip(self.run(values, times), parts, places):
            if uv is not None:
                errors.append((weights_of(uv) @ cloth - points).ravel())
            else:
                errors.append(scipy.spatial.cKDTree(self.surface @ cloth).query(points)[0])
        return np.concatenate(errors)


def fit(measured):
    """The values that reproduce the measurement best, and a standard deviation of each."""
    # In a cloud, a cloth that slides along itself looks the same, except at its edge.
    names = [name for name in SOUGHT if measured.uv is not None or name != "stretch_stiffness"]
    model = Model()

    def residual(logarithms):  # of the values, which makes them positive and of the same scale
        return model.residual(dict(zip(names, np.exp(logarithms))), measured)
    start, least, most = np.log([SOUGHT[name][1:] for name in names]).T
    while True:
        found = scipy.optimize.least_squares(residual, start, diff_step=1e-3, xtol=PRECISE, ftol=PRECISE,
                                             bounds=(least, most))
        # A strip with one swing too many is a local minimum: a better start may be beside the found value.
        beside = [found.x + way * np.log(factor) for way in np.eye(len(names)) for factor in BESIDE]
        beside = [x for x in beside if (x >= least).all() and (x <= most).all()]
        costs = [np.square(residual(x)).sum() / 2 for x in beside]
        if min(costs) >= found.cost:
            break
        start = beside[int(np.argmin(costs))]
    variance = 2 * found.cost / (found.fun.size - len(names))
    spread = np.sqrt(np.diag(variance * np.linalg.inv(found.jac.T @ found.jac)))
    values = np.exp(found.x)
    return dict(zip(names, values)), dict(zip(names, values * spread))


def made_up(kind="markers", seed=1):
    """A measurement of the cloth of TRUTH: 24 markers 30 times a second, or clouds of 300 points 10 times."""
    random, times = np.random.default_rng(seed), np.arange(1, 91, 1 if kind == "markers" else 3) / 30
    uv = np.stack(np.meshgrid([0.05, 0.5, 0.95], np.linspace(0.15, 1, 8)), axis=-1).reshape(-1, 2)
    rows = []
    for time, cloth in zip(times, Model().run(TRUTH, times)):
        places = uv if kind == "markers" else random.uniform(0, 1, (300, 2))
        points = weights_of(places) @ cloth
        rows.append((np.full(len(points), time), points + NOISE * random.standard_normal(points.shape), places))
    times, points, places = (np.concatenate(part) for part in zip(*rows))
    return Measurement(times, points, places if kind == "markers" else None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measurement", nargs="?", help=".csv or .npz; none: a synthetic one")
    parser.add_argument("--cloud", action="store_true", help="synthetic point cloud instead of markers")
    arguments = parser.parse_args()
    if arguments.measurement:
        measured, truth = Measurement.load(arguments.measurement), {}
    else:
        measured, truth = made_up("cloud" if arguments.cloud else "markers"), TRUTH
    values, spreads = fit(measured)
    for name, value in values.items():
        known = f", in truth {truth[name]:.3g}" if truth else ""
        print(f"{name}: {value:.3g} +- {spreads[name]:.1g}{known}")


if __name__ == "__main__":
    main()
