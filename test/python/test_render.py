"""Pictures from Python: their content, and that they equal those of `picture`."""

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


def test_all_images_are_there_by_name():
    simulator = Simulator(busy())
    color, depth, mask = simulator.render(ABOVE)
    images = simulator.render(ABOVE, images="all")
    shapes = {"color": (48, 64, 3), "depth": (48, 64), "mask": (48, 64), "uv": (48, 64, 2),
              "normals": (48, 64, 3), "flow": (48, 64, 2), "visible_points": (100,)}
    assert {name: image.shape for name, image in images.items()} == shapes
    assert np.array_equal(images["color"], color)
    assert np.array_equal(images["depth"], depth) and np.array_equal(images["mask"], mask)
    cloth = mask == 1
    assert np.isfinite(images["uv"][cloth]).all() and np.isnan(images["uv"][~cloth]).all()
    assert np.allclose(images["normals"][cloth], [0, 0, -1], atol=1e-6)  # towards the camera
    assert np.array_equal(images["visible_points"], np.arange(100))
    assert np.isnan(images["flow"]).all()  # since there was no picture before
    some = simulator.render(ABOVE, ["mask", "uv"])
    assert list(some) == ["mask", "uv"] and np.array_equal(some["uv"], images["uv"], equal_nan=True)


def test_flow_is_of_each_simulator_alone():
    """A cloth that goes 0.1 m to the right at 2 m from the camera moves by f 0.1 / 2 pixels."""
    pixels = 64 / 2 / np.tan(0.5) * 0.05
    simulators = [Simulator(free()) for _ in range(3)]
    for simulator in simulators:
        assert np.isnan(simulator.render(ABOVE, ["flow"])["flow"]).all()
    for way, simulator in enumerate(simulators):
        simulator.positions = simulator.positions + [0.1 * way, 0, 0]
    for way, simulator in enumerate(simulators):  # in turn with others, and with pictures without flow
        simulator.render(ABOVE)
        simulators[way - 1].render(ABOVE, ["mask"])
        images = simulator.render(ABOVE, ["flow", "mask"])
        flow = images["flow"][images["mask"] == 1]
        assert np.allclose(flow[:, 0], way * pixels, atol=1e-3) and np.allclose(flow[:, 1], 0, atol=1e-3)
    again = simulators[2].render(ABOVE, ["flow", "mask"])
    assert np.allclose(again["flow"][again["mask"] == 1], 0, atol=1e-4)
    simulators[2].load(free())
    assert np.isnan(simulators[2].render(ABOVE, ["flow"])["flow"]).all()


@pytest.mark.parametrize("images, message", [
    ("depht", "all.*list"), (["depht"], "got \"depht\".*color, depth"),
    (7, "got .*int")])
def test_images_that_there_are_not_are_refused(images, message):
    with pytest.raises(clothsim.InvalidValue, match=message) as caught:
        Simulator(free()).render(ABOVE, images)
    assert caught.value.key == "images"
