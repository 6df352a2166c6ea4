"""Many simulators at once, and many threads at one simulator: errors are reported, nothing crashes."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from scenes import busy, free

import clothsim
from clothsim import Batch, Simulator


def in_threads(count, work):
    """Runs work(i) in `count` threads at once and raises their exceptions."""
    errors = []

    def run(i):
        try:
            work(i)
        except Exception as error:
            errors.append(error)
    threads = [threading.Thread(target=run, args=[i]) for i in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


# ---- A batch

def test_the_arrays_are_there_once():
    simulators = [Simulator(free(4 )) for _ in range(3)]
    batch = Batch(simulators)
    positions = batch.positions
    assert positions.shape == batch.velocities.shape == (3, 16, 3)
    assert positions.flags.c_contiguous and not positions.flags.writeable
    assert batch.simulators == tuple(simulators)
    assert np.array_equal(positions[1], simulators[1].positions)
    assert batch.step() is positions and batch.positions is positions
    simulators[1].reset()
    assert not np.array_equal(positions[1], simulators[1].positions)
    batch.read()
    assert np.array_equal(positions[1], simulators[1].positions)
    del batch, simulators
    gc.collect()
    assert np.isfinite(positions).all()


def test_a_batch_that_cannot_be_is_refused():
    one, other = Simulator(free(4)), Simulator(free(5))
    for simulators, threads, key in [
            ([], None, "simulators"), ([one, other], None, "simulators.1"),
            ([one, one], None, "simulators.1"), ([one, 5], None, "simulators.1"),
            ([one], 0, "threads"), ([one], 65, "threads")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            Batch(simulators, threads)
        assert caught.value.key == key


def test_actions_that_cannot_be_step_none():
    batch = Batch([Simulator(busy()) for _ in range(3)])
    before = batch.positions.copy()
    good = {"ball": [0.5, 0.5, 0.8]}
    for actions, key in [
            ([good], "actions"), ([good, good, {"bal": [0, 0, 0]}], "actions.2.bal"),
            ([good, None, {"ball": [0, 0, float("nan")]}], "actions.2.ball.position.2"),
            ({"ball": np.zeros((2, 3))}, "actions.ball"), ({"ball": 5}, "actions"),
            ({"ball": np.zeros((3, 4))}, "actions.0.ball"), ("abc", "actions"), (5, "actions"),
            ([good, 5, good], "actions.1")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            batch.step(actions)
        assert caught.value.key == key
    with pytest.raises(clothsim.InvalidValue):
        batch.step(frames=0)
    assert [simulator.time for simulator in batch.simulators] == [0, 0, 0]
    assert np.array_equal(batch.positions, before)
    assert batch.simulators[0].colliders["ball"]["pose"][2] == 0.75


def test_a_scene_of_other_points_is_told():
    batch = Batch([Simulator(free(4)) for _ in range(2)])
    batch.simulators[1].load(free(6))
    for call in (batch.step, batch.read):
        with pytest.raises(clothsim.InvalidValue) as caught:
            call()
        assert caught.value.key == "simulators.1"
    batch.simulators[1].load(free(4))
    batch.step()


def wild():
    """Diverges: the substeps are far beyond the stability limit of the springs."""
    return {"cloth": {"columns": 4, "rows": 4, "ks": 1e6, "density": 0.01, "strain_limit": "off",
                      "pinned": [[0, 0]]},
            "simulation": {"method": "verlet", "substeps": 1}}


def test_those_that_diverge_do_not_stop_the_others():
    batch = Batch([Simulator(free(4)), Simulator(wild()), Simulator(free(4)), Simulator(wild())])
    with pytest.raises(clothsim.Diverged) as caught:
        batch.step(frames=30)
    assert caught.value.environments == [1, 3]
    assert [round(simulator.time * 90) for simulator in batch.simulators][::2] == [30, 30]
    assert np.isfinite(batch.positions).all() and np.isfinite(batch.velocities).all()
    for i, simulator in enumerate(batch.simulators):
        assert np.array_equal(batch.positions[i], simulator.positions)
    with pytest.raises(clothsim.Diverged):
        Simulator(wild()).step(30)


# ---- Threads

def test_threads_take_turns_at_one_simulator():
    simulator = Simulator(busy())
    in_threads(6, lambda _: [simulator.step() for _ in range(20)])
    assert simulator.report["frames"] == 120
    twin = Simulator(busy())
    twin.step(120)
    assert np.array_equal(simulator.positions, twin.positions)


def test_threads_that_do_all_at_once():
    shared = [Simulator(busy()) for _ in range(3)]
    batches = [Batch(shared, 2), Batch(shared[::-1], 1)]
    saved = shared[0].save()
    calls = [
        lambda s, r: s.step(2), lambda s, r: s.positions.sum(), lambda s, r: s.report,
        lambda s, r: s.load(busy()), lambda s, r: s.restore(saved), lambda s, r: s.set(ks=200),
        lambda s, r: s.reset(), lambda s, r: s.memory, lambda s, r: s.topology, lambda s, r: s.grips,
        lambda s, r: s.attach("finger", [1, 1, 1], radius=0.3), lambda s, r: s.detach(),
        lambda s, r: s.intersections(), lambda s, r: batches[r % 2].step(),
        lambda s, r: batches[r % 2].read(), lambda s, r: s.set_state(time=1.0),
        lambda s, r: s.enable_collider("ball", r % 3 > 0),
        lambda s, r: s.step(1, {"ball": [0.5, 0.5, 0.7]})]

    def work(i):
        rng = np.random.default_rng(i)
        views = []
        for _ in range(150):
            simulator = shared[rng.integers(len(shared))]
            views.append(simulator.positions)
            try:
                calls[rng.integers(len(calls))](simulator, int(rng.integers(1000)))
            except clothsim.InvalidValue:
                pass  # as where another thread has attached the points
        assert all(np.isfinite(view).all() for view in views)
    in_threads(4, work)


def test_the_gil_is_free_while_it_computes():
    simulator = Simulator(busy())
    ticks = 0
    done = threading.Event()

    def count():
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0)
    thread = threading.Thread(target=count)
    thread.start()
    before = ticks
    simulator.step(300)
    during = ticks - before
    done.set()
    thread.join()
    assert during > 1  # a call could come between before and after


def test_a_signal_ends_a_long_call():
    program = """
import signal, sys, clothsim
simulator = clothsim.Simulator({"cloth": {"columns": 30, "rows": 30}})
batch = clothsim.Batch([clothsim.Simulator({"cloth": {}}) for _ in range(2)])
def again(number, frame):
    try:
        simulator.step()
    except RuntimeError as error:
        print("refused:", error, flush=True)
    raise KeyboardInterrupt
signal.signal(signal.SIGINT, again)
for step in (lambda: simulator.step(10**9), lambda: batch.step(frames=10**9)):
    try:
        print("go", flush=True)
        step()
    except KeyboardInterrupt:
        print("ended", flush=True)
signal.signal(signal.SIGINT, signal.SIG_IGN)
simulator.step(3)
batch.step()
print(simulator.time > 0, flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    heard = []
    for line in child.stdout:
        heard.append(line.split(":")[0].strip())
        if heard[-1] == "go":
            time.sleep(0.2)
            child.send_signal(signal.SIGINT)
    assert child.wait() == 0
    assert heard == ["go", "refused", "ended", "go", "ended", "True"]


@pytest.mark.parametrize("call", ["simulator.step(10**9)", "batch.step(frames=10**9)",
                                  "simulator.report", "simulator.time", "simulator.render(view)",
                                  "simulator.intersections()"])
def test_python_may_end_while_threads_compute(call):
    program = f"""
import atexit, threading, time, clothsim
atexit.register(lambda: print("last words", simulator.step(2).substeps > 0, flush=True))
simulator = clothsim.Simulator({{"cloth": {{"columns": 20, "rows": 20}}}})
batch = clothsim.Batch([clothsim.Simulator({{"cloth": {{}}}}) for _ in range(2)])
view = {{"width": 16, "height": 12}}
def work():
    while True:
        try:
            {call}
        except RuntimeError:
            pass
for _ in range(3):
    threading.Thread(target=work, daemon=True).start()
time.sleep(0.3)
"""
    for _ in range(3):
        done = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert done.returncode == 0
        assert done.stdout.strip().endswith("last words True")


def test_simulators_come_and_go_without_a_trace():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def use():
        batch = Batch([Simulator(busy()) for _ in range(4)])
        batch.step(frames=3)
        return batch.simulators[0].positions[:, 2], batch.simulators[1].save()
    for _ in range(20):
        use()
    before = resident()
    for _ in range(100):
        use()
    gc.collect()
    assert resident() - before < 100 * 4 * 20_000  # a new simulator in each round would use far more
