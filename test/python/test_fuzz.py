"""Any value from Python is accepted or refused by an exception, and simulators go on."""

import os
import random

import numpy as np
import pytest
from scenes import SCENES, busy, free

from clothsim import Batch, Scene, Simulator, View

SEEDS = range(int(os.environ.get("FUZZ_FROM", 0)), int(os.environ.get("FUZZ_TO", 12)))
CALLS = 250


class Broken:
    """Looks like an array and raises when it is read."""

    def __len__(self):
        raise LookupError

    def __getitem__(self, key):
        raise LookupError

    def __array__(self, dtype=None):
        raise LookupError

    def tolist(self):
        raise LookupError


class Endless:
    def tolist(self):
        return self

    def __fspath__(self):
        return 5


def nested(depth):
    value = []
    for _ in range(depth):
        value = [value]
    return value


LOOP = []
LOOP.append(LOOP)
SIMULATOR = Simulator(free(3))


def garbage(rng):
    """Any value, many of them almost right."""
    number = rng.choice([0, 1, -1, 3, 7, 0.5, -0.0, 1e-3, 1e9, 1e308, float("nan"), float("inf"), True,
                         np.float32(2), np.int64(-3), 2**40, 10**40])
    shape = rng.choice([(), (0,), (3,), (7,), (2, 3), (2, 7), (9, 3), (3, 9), (100, 3), (2, 2, 3),
                        (0, 3), (3, 0)])
    array = np.random.default_rng(rng.getrandbits(32)).standard_normal(shape)
    return rng.choice([
        lambda: None, lambda: number, lambda: number, lambda: array, lambda: array,
        lambda: np.full(shape, number), lambda: [number] * rng.choice([0, 1, 2, 3, 7]),
        lambda: (number,) * 3, lambda: [0.5, 0.5, 0.7], lambda: [0.5, 0.5, 0.7, 0, 0, 0, 1],
        lambda: array.T, lambda: array[::-1], lambda: array.astype(complex),
        lambda: array.astype(object), lambda: np.zeros(3, [("x", float)]), lambda: np.array("abc"),
        lambda: array > 0, lambda: [[1, 2], [3]], lambda: nested(60), lambda: LOOP,
        lambda: rng.choice(["", "ball", "hand", "off", "auto", "\0", "\ud800", "é" * 5000, "a.b=[",
                            str(SCENES / "sphere.yaml"), "/dev/zero", "/"]),
        lambda: b"bytes", lambda: {}, lambda: {number: number}, lambda: {"ball": number},
        lambda: {"ball": array, "hand": [0, 0, 1]}, lambda: {"ks": number}, lambda: {"cloth": number},
        lambda: [{"ball": array}, None], lambda: SIMULATOR, lambda: SIMULATOR.save(),
        lambda: SIMULATOR.positions, lambda: Broken(), lambda: Endless(), lambda: free, lambda: Scene,
    ])()


KEYS = ["cloth.ks", "cloth.pinned", "cloth.columns", "cloth.springs", "cloth", "colliders",
        "colliders.0", "colliders.0.shape", "colliders.7", "simulation", "simulation.method",
        "simulation.method_parameters", "simulation.gravity", "", ".", "cloth.a.b.c.d"]
VALUES = ["ks", "density", "damping", "strain_limit", "springs", "gravity", "substeps", "method",
          "method_parameters", "tolerance", "columns", "nothing"]


def small(value):
    """Leaves out values that are valid and take minutes."""
    too_many = isinstance(value, (int, float, np.number)) and abs(value) > 100
    return None if too_many else value


def call(rng, simulator, batch):
    def g():
        return garbage(rng)
    return rng.choice([
        lambda: Scene(g(), rng.choice([{}, {rng.choice(KEYS): g()}, g()])),
        lambda: Scene(busy(), {rng.choice(KEYS): small(g())}),
        lambda: Scene.parse(g()), lambda: Simulator(g()), lambda: simulator.load(g()),
        lambda: View(g(), {rng.choice(["width", "eye", "cloth.shader", "colliders"]): small(g())}),
        lambda: simulator.step(rng.choice([-1, 0, 1, 2, None, "1", 1.5, 10**40]), g()),
        lambda: simulator.step(1, {rng.choice(["ball", "hand", "other"]): g()}),
        lambda: simulator.step(1, {"ball": (g(), g())}),
        lambda: setattr(simulator, "positions", g()), lambda: setattr(simulator, "velocities", g()),
        lambda: simulator.set_state(g(), g(), g(), g()), lambda: simulator.set_state(memory=g()),
        lambda: simulator.set_state(memory=np.where(np.arange(len(simulator.memory)) == rng.randrange(
            len(simulator.memory)), small(g()), simulator.memory)),
        lambda: simulator.set(**{rng.choice(VALUES): g()}), lambda: simulator.restore(g()),
        lambda: simulator.attach(g(), g(), g(), g(), g()),
        lambda: simulator.attach("finger", [1, 1, 1], g()),
        lambda: simulator.attach("finger", g(), radius=g(), tear_force=g()),
        lambda: simulator.attach(g(), g(), [{"near": g()}, g()], g(), g(), g(), g()),
        lambda: simulator.attach("finger", [1, 1, 1], [{rng.choice(["near", "uv", "side"]): g()}, small(g())]),
        lambda: simulator.detach(g(), g(), g()), lambda: simulator.detach(g(), g()), lambda: simulator.detach(),
        lambda: simulator.enable_collider(g(), g()), lambda: simulator.enable_collider("ball", False),
        lambda: simulator.place_frame(g(), g()), lambda: simulator.place_frame("ball", g()),
        lambda: simulator.reset(), lambda: simulator.step(), lambda: Batch(g(), g()),
        lambda: Batch([simulator, g()]), lambda: batch.step(g()),
        lambda: batch.step({"ball": g()}), lambda: batch.step([{"ball": g()}, g()]),
        lambda: batch.read(), lambda: (simulator.report, simulator.grips, simulator.topology),
    ])


# Exceptions of Python, beside our own: a refusal under any name. Broken raises LookupError.
REFUSALS = (ValueError, TypeError, RuntimeError, LookupError, OverflowError)


@pytest.mark.filterwarnings("ignore")  # numpy's warning on a cast of complex numbers
@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_breaks_a_simulator(seed):
    rng = random.Random(seed)
    simulator, other = Simulator(busy()), Simulator(busy())
    batch = Batch([simulator, other])
    refused = 0
    for _ in range(CALLS):
        views = simulator.positions, simulator.velocities
        try:
            call(rng, simulator, batch)()
        except REFUSALS:
            refused += 1
        for array in (*views, simulator.positions, simulator.velocities, batch.positions):
            assert np.isfinite(array).all()
    assert 0.2 * CALLS < refused < CALLS  # some are accepted, too
    simulator.load(busy())
    twin = Simulator(busy())
    simulator.step(3)
    twin.step(3)
    assert np.array_equal(simulator.positions, twin.positions)
