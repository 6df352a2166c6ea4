"""Equal scenes give equal bits: in this process, in `simulate`, with threads and beside others."""

import pathlib
import subprocess
import threading

import numpy as np
import pytest
import scenes
import yaml

import clothsim
from clothsim import Batch, Simulator

# Beside the package in the build: lib/python3/dist-packages/clothsim and lib/clothsim.
SIMULATE = pathlib.Path(clothsim.__file__).resolve().parents[3] / "clothsim/simulate"


@pytest.mark.parametrize("scene", [
    *sorted(path.name for path in scenes.SCENES.glob("*.yaml"))])
def test_a_run_is_that_of_simulate(scene, tmp_path):
    text = (scenes.SCENES / scene).read_text()
    is_grid = not any(key in text for key in ("mesh:", "pattern:", "cloths:"))
    overrides = {"cloth.columns": 12, "cloth.rows": 12} if is_grid else {}
    if is_grid and "pinned:" in text:
        overrides["cloth.pinned"] = [[0, 0], [11, 0]]
    frames = 60 if overrides else 20
    simulator = Simulator(clothsim.Scene(scenes.SCENES / scene, overrides))
    simulator.step(frames)
    sets = [part for key, value in overrides.items() for part in ("--set", f"{key}={value}")]
    subprocess.run([SIMULATE, scenes.SCENES / scene, "--seconds", str(frames / 90), *sets,
                    "--output", tmp_path], check=True, stdout=subprocess.DEVNULL)
    table = np.loadtxt(tmp_path / "final.csv", delimiter=",", skiprows=1)
    assert np.array_equal(simulator.positions, table[:, :3])
    assert np.array_equal(simulator.velocities, table[:, 3:])

    theirs = yaml.safe_load((tmp_path / "report.yaml").read_text())
    ours = simulator.report
    assert ours.keys() == theirs.keys()
    for key in theirs.keys() - {"wall_seconds", "cpu_seconds", "scene", "overrides"}:
        value = "off" if theirs[key] is False and key == "self_collision" else theirs[key]  # YAML 1.1
        assert ours[key] == value, key
    assert ours["scene"] == str(scenes.SCENES / scene)


MOTIONS = [
    {"time": 0, "frame": "finger", "position": [1, 1, 1]},
    {"time": 0.05, "attach": "finger", "radius": 0.2},
    {"time": 0.4, "frame": "finger", "position": [0.8, 0.8, 1.3], "rpy": [0, 0, 0.5]},
    {"time": 0.2, "frame": "ball", "position": [0.5, 0.5, 0.75]},
    {"time": 0.5, "frame": "ball", "position": [0.4, 0.5, 0.85]},
    {"time": 0.3, "set": {"damping": 20}},
    {"time": 0.45, "detach": "finger"},
]


def test_motions_are_played_as_by_simulate(tmp_path):
    scene = {**scenes.busy(), "motions": MOTIONS}
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene))
    subprocess.run([SIMULATE, tmp_path / "scene.yaml", "--seconds", "0.6", "--output", tmp_path],
                   check=True, stdout=subprocess.DEVNULL)
    table = np.loadtxt(tmp_path / "final.csv", delimiter=",", skiprows=1)
    simulator = Simulator(tmp_path / "scene.yaml")
    simulator.step(20)
    saved = simulator.save()
    simulator.step(34)
    assert np.array_equal(simulator.positions, table[:, :3])
    assert not np.array_equal(simulator.positions, run_without_motions(54))

    simulator.set(damping=5.4)  # live values are not part of the saved state
    simulator.restore(saved)
    simulator.step(34)
    assert np.array_equal(simulator.positions, table[:, :3])
    simulator.set(damping=5.4)
    simulator.reset()
    simulator.step(54)
    assert np.array_equal(simulator.positions, table[:, :3])


def run_without_motions(frames):
    simulator = Simulator(scenes.busy())
    simulator.step(frames)
    return simulator.positions


def test_files_of_motions_are_beside_the_scene(tmp_path):
    scene = {**scenes.busy(), "motions": [{"frame": "ball", "file": "way.csv"}]}
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(scene))
    with pytest.raises(clothsim.InvalidValue):
        Simulator(path)
    (tmp_path / "way.csv").write_text("time,x,y,z\n0,0.5,0.5,0.6\n0.5,0.5,0.5,0.9\n")
    simulator = Simulator(path)
    simulator.step(45)
    assert np.allclose(simulator.colliders["ball"]["pose"][:3], [0.5, 0.5, 0.9])


def test_threads_of_python_do_not_change_bits():
    def run(simulator):
        for i in range(30):
            simulator.step(targets={"ball": [0.5, 0.5, 0.75 + 0.005 * i]})
    alone = Simulator(scenes.busy())
    run(alone)
    beside = [Simulator(scenes.busy(threads=1 + i % 2)) for i in range(6)]
    threads = [threading.Thread(target=run, args=[simulator]) for simulator in beside]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for simulator in beside:
        assert np.array_equal(simulator.positions, alone.positions)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_a_batch_computes_what_each_would_alone(threads):
    count = 7
    batch = Batch([Simulator(scenes.busy(seed=i)) for i in range(count)], threads)
    alone = [Simulator(scenes.busy(seed=i)) for i in range(count)]
    assert batch.threads == threads and len(batch) == count
    rng = np.random.default_rng(1)
    for step in range(20):
        balls = [0.5, 0.5, 0.75] + 0.02 * rng.standard_normal((count, 3))
        positions = batch.step({"ball": balls} if step % 2 else [{"ball": b} for b in balls], 2)
        for simulator, ball in zip(alone, balls):
            simulator.step(2, {"ball": ball})
    assert positions is batch.positions
    for i, simulator in enumerate(alone):
        assert np.array_equal(positions[i], simulator.positions)
        assert np.array_equal(batch.velocities[i], simulator.velocities)
        assert np.array_equal(batch.simulators[i].positions, simulator.positions)
