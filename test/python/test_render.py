"""Pictures from Python: what they show, and that they are those of `picture`."""

import pathlib
import subprocess
import sys
import threading

import numpy as np
import PIL.Image
import pytest
from scenes import CLONE, SCENES, busy, free

import clothsim
from clothsim import Simulator, View

PICTURE = pathlib.Path(clothsim.__file__).resolve().parents[3] / "clothsim/picture"
ABOVE = {"width": 64, "height": 48, "field_of_view": 1.0, "eye": [0.5, 0.5, 3], "target": [0.5, 0.5, 1]}


def test_a_flat_cloth_from_above_is_as_far_as_it_is():
    color, depth, mask = Simulator(free()).render(ABOVE)
    assert color.shape == (48, 64, 3) and color.dtype == np.uint8
    assert depth.shape == mask.shape == (48, 64)
    assert (depth.dtype, mask.dtype) == (np.float32, np.uint8)
    cloth = mask == 1
    assert set(np.unique(mask)) == {0, 1}
    assert np.allclose(depth[cloth], 2, atol=1e-3)
    assert np.isinf(depth[~cloth]).all()
    # 1 m at 2 m fills that share of the picture's width; the edge may fall within a pixel.
    f = 64 / 2 / np.tan(0.5)
    assert cloth[24].sum() == pytest.approx(f / 2, abs=1)


def test_pictures_show_what_moved_and_what_is_hidden():
    simulator = Simulator(busy())
    view = View(ABOVE)
    first = simulator.render(view)
    assert 3 in first[2] and 2 not in first[2]  # the ball is below the cloth
    simulator.place_frame("ball", [0.5, 0.5, 1.5])
    simulator.step()
    second = simulator.render(view)
    assert 2 in second[2]
    assert second[1].min() == pytest.approx(1.3, abs=0.01)
    simulator.load(free())
    assert set(np.unique(simulator.render(view)[2])) == {0, 1}


def test_a_picture_is_that_of_the_program(tmp_path):
    file = tmp_path / "picture.png"
    view = CLONE / "config/views/drape.yaml"
    subprocess.run([PICTURE, SCENES / "sphere.yaml", "--seconds", "0.5", "--view", view,
                    "--output", file], check=True)
    simulator = Simulator(SCENES / "sphere.yaml")
    simulator.step(45)
    color, _, _ = simulator.render(view)
    assert np.array_equal(color, np.asarray(PIL.Image.open(file)))


def test_threads_draw_side_by_side():
    simulators = [Simulator(free(3 + i)) for i in range(4)]
    expected = [simulator.render(ABOVE)[1] for simulator in simulators]
    got = [[] for _ in simulators]

    def work(i):
        for _ in range(5):
            got[i].append(simulators[i].render(ABOVE)[1])
    threads = [threading.Thread(target=work, args=[i]) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for depth, all_of_one in zip(expected, got):
        assert len(all_of_one) == 5
        assert all(np.array_equal(depth, other) for other in all_of_one)


@pytest.mark.parametrize("view, key", [
    ({"widht": 3}, "widht"), ({"width": -1}, "width"), ({"colliders": {"wall": {}}}, "colliders.wall"),
    ({"cloth": {"texture": "none.png", "shader": "bump"}}, "cloth.texture"), (5, ""),
    ("none.yaml", "none.yaml"), ({"eye": [0, 0, 0], "target": [0, 0, 0]}, None)])
def test_views_that_cannot_be_are_refused(view, key):
    with pytest.raises(clothsim.InvalidValue) as caught:
        Simulator(free()).render(view)
    if key is not None:
        assert caught.value.key == key


def test_a_forked_process_is_told():
    program = """
import os, clothsim
simulator = clothsim.Simulator({"cloth": {"columns": 3, "rows": 3}})
simulator.render()
if os.fork() == 0:
    try:
        simulator.step()
        simulator.render()
    except RuntimeError as error:
        os._exit(7 if "spawn" in str(error) else 1)
    os._exit(0)
raise SystemExit(os.waitstatus_to_exitcode(os.wait()[1]))
"""
    assert subprocess.run([sys.executable, "-c", program], timeout=100).returncode == 7


def test_the_first_use_of_the_simulator_loads_no_opengl():
    program = """
import clothsim
clothsim.Simulator({"cloth": {}}).step()
assert "libEGL" not in open("/proc/self/maps").read()
clothsim.View()
assert "libEGL" in open("/proc/self/maps").read()
"""
    subprocess.run([sys.executable, "-c", program], check=True)
