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
    overrides = {"cloth.columns": 12, "cloth.rows": 12}
    if "pinned" in scene or scene in ("rod.yaml",):
        overrides["cloth.pinned"] = [[0, 0], [11, 0]]
    frames = 60
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
