#!/usr/bin/python3
"""Finds stiffness and damping of a cloth from a recording of its motion, by scipy's least squares.

The recording is synthetic, with noise as from a motion capture: times [T] [s] and markers
[T, M, 3] [m], those of some points of a cloth that swings from two corners.
"""

import numpy as np
import scipy.optimize

import clothsim

SCENE = {
    "cloth": {"columns": 15, "rows": 15, "pinned": [[0, 0], [14, 0]], "density": 0.3,
              "strain_limit": "off"},
    # Steps that do not depend on the sought values, so that the residual is smooth.
    "simulation": {"method": "verlet", "substeps": 20},
}
MARKERS = [104, 112, 119, 210, 217, 224]  # points
FRAMES, EVERY = 90, 5  # recorded
NOISE = 1e-3  # [m]
TRUTH = {"ks": 60.0, "damping": 1.5}  # [N/m], [1/s]
GUESS = {"ks": 200.0, "damping": 5.0}
LEAST, MOST = (1.0, 0.01), (1000.0, 50.0)  # stiffer cloth would need more substeps


class Model:
    """A run from rest with other values, again and again in one simulator."""

    def __init__(self):
        self.simulator = clothsim.Simulator(SCENE)
        self.start = self.simulator.save()

    def motion(self, ks, damping):
        """Markers [T, M, 3] [m]."""
        self.simulator.set(ks=ks, damping=damping)
        self.simulator.restore(self.start)
        motion = []
        for _ in range(FRAMES // EVERY):
            self.simulator.step(EVERY)
            motion.append(self.simulator.positions[MARKERS])
        return np.array(motion)


def identify(recording):
    """The values that reproduce the recording best, and one standard deviation of each."""
    model = Model()

    def residual(logarithms):  # of the values, which makes them positive and of the same scale
        return (model.motion(*np.exp(logarithms)) - recording).ravel()
    found = scipy.optimize.least_squares(residual, np.log(list(GUESS.values())), diff_step=1e-4,
                                         bounds=np.log([LEAST, MOST]))
    variance = 2 * found.cost / (recording.size - len(GUESS))
    spread = np.sqrt(np.diag(variance * np.linalg.inv(found.jac.T @ found.jac)))
    values = np.exp(found.x)
    return dict(zip(GUESS, values)), dict(zip(GUESS, values * spread)), found.nfev


def main():
    recording = Model().motion(**TRUTH)
    recording += NOISE * np.random.default_rng(1).standard_normal(recording.shape)
    values, spreads, runs = identify(recording)
    for name, value in values.items():
        print(f"{name}: {value:.3f} +- {spreads[name]:.3f}, in truth {TRUTH[name]}")
    print(f"{runs} evaluations")


if __name__ == "__main__":
    main()
