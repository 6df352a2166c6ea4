#!/usr/bin/env python3
"""A tour of the Python module in cells, as a notebook has them: run it as a whole, or cell by cell.

Each cell ends with its result.
"""

# %% A scene is a file, a text or a dict, with the same keys and the same strict reader.
import pathlib
import tempfile
import threading

import numpy as np

import clothsim
from clothsim import Batch, InvalidValue, Scene, Simulator

TEXT = """
cloth: {columns: 25, rows: 25, density: 5}
colliders:
  - {name: sphere, shape: sphere, center: [0.5, 0.5, 0.2], radius: 0.3, friction: 0.3, frame: sphere}
"""
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "scene.yaml"
    path.write_text(TEXT)
    from_file = Scene(path)
from_text = Scene.parse(TEXT)
from_dict = Scene(from_file.to_dict())
assert repr(from_file) == repr(from_text) == repr(from_dict)
print(from_file)

# %% An invalid value is refused with its key in the scene.
try:
    Scene({"cloth": {"ks": "soft"}})
except InvalidValue as error:
    assert error.key == "cloth.ks"
    print(error)

# %% Frames. Positions and velocities are views of the simulator's memory: no copy, read-only.
simulator = Simulator(from_file)
positions, velocities = simulator.positions, simulator.velocities
before = positions.copy()
last = simulator.step(30)
assert (positions[:, 2] < before[:, 2]).any() and not positions.flags.writeable
assert np.array_equal(Simulator(from_dict).step(30).substeps, last.substeps)
print(last, positions.shape, np.abs(velocities).max())

# %% Set values are checked.
try:
    simulator.positions = np.full_like(positions, np.nan)
except InvalidValue as error:
    print(error)
simulator.velocities = velocities + [0, 0, 0.5]

# %% Topology of the cloth.
topology = simulator.topology
assert topology["triangles"].shape == (2 * 24 * 24, 3)
print({key: getattr(value, "shape", value) for key, value in topology.items()})

# %% Live values, between two frames.
simulator.set(ks=2000, damping=10, collider_friction={"sphere": 0.8})
simulator.step(60)

# %% A restored state continues bit-identically. So do its plain numbers in another simulator.
saved, memory, time = simulator.save(), simulator.memory, simulator.time
here = positions.copy(), velocities.copy()
simulator.step(10)
later = positions.copy()
simulator.restore(saved)
simulator.step(10)
assert np.array_equal(positions, later)
elsewhere = Simulator(from_file)
elsewhere.set(ks=2000, damping=10, collider_friction={"sphere": 0.8})
elsewhere.set_state(*here, time, memory)
elsewhere.step(10)
assert np.array_equal(elsewhere.positions, later)
print("the same bits, twice;", saved.nbytes, "bytes")

# %% Force of the cloth on the sphere, and self-intersections.
simulator.weighs_colliders = True
simulator.step(120)
touch = simulator.contacts["sphere"]
weight = 9.8 * topology["mass"].sum()
assert touch["count"] > 0 and 0 < -touch["force"][2] < 3 * weight
assert len(simulator.intersections()) == simulator.report["intersecting_pairs"]
print("bears", -touch["force"][2] / weight, "of the weight with", touch["count"], "places")

# %% A hand takes a corner, carries it and lets go; the sphere is turned off.
corner = positions[0].copy()
simulator.attach("hand", corner, points=[0])
simulator.step(45, targets={"hand": corner + [0, 0, 0.4]})
assert np.allclose(positions[0], corner + [0, 0, 0.4])
print("the hand bears", -simulator.grips["hand"]["force"][2], "N")
simulator.step(9, targets={"hand": (corner + [0, 0, 0.4], corner + [0, 0, 0.3])})
simulator.detach("hand")
simulator.enable_collider("sphere", False)
simulator.step(9)
assert simulator.contacts["sphere"]["count"] == 0

# %% A report as `simulate` writes it.
print({key: simulator.report[key] for key in ("method", "frames", "energy", "worst_stretch")})

# %% Colour, depth and mask, without a display.
color, depth, mask = simulator.render(
    {"width": 160, "height": 120, "eye": [2, -1.5, 1.2], "target": [0.5, 0.5, 0.3]})
assert color.shape == (120, 160, 3) and depth.shape == mask.shape == (120, 160)
assert (mask == 1).any() and np.isfinite(depth[mask == 1]).all()

# %% The interpreter is free while frames are computed: threads share the cores.
crowd = [Simulator(from_file) for _ in range(4)]
threads = [threading.Thread(target=one.step, args=[20]) for one in crowd]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert all(np.array_equal(one.positions, crowd[0].positions) for one in crowd)

# %% A batch steps many on all cores, into one array.
batch = Batch(crowd)
arrays = batch.step({"sphere": [[0.5, 0.5, 0.2 + 0.01 * i] for i in range(4)]}, frames=10)
assert arrays.shape == (4, 625, 3) and arrays is batch.step()
assert np.array_equal(arrays[2], crowd[2].positions)
print(arrays.shape, "by", batch.threads, "threads")

# %% Everything is documented, with shapes and units.
for name in dir(Simulator):
    assert name.startswith("_") or getattr(Simulator, name).__doc__
print(clothsim.Simulator.positions.__doc__)
print("the tour is done")
