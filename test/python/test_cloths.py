"""Several cloths in a scene, by name."""

import pickle

import numpy as np
import pytest

import clothsim
from scenes import SCENES


@pytest.fixture
def napkins():
    return clothsim.Simulator(str(SCENES / "napkins.yaml"))


def test_each_cloth_has_its_points(napkins):
    lower, upper = napkins.cloths["lower"], napkins.cloths["upper"]
    assert list(napkins.cloths) == ["lower", "upper"]
    assert (lower.name, lower.points, upper.points) == ("lower", range(441), range(441, 882))
    assert (lower.triangles, upper.triangles) == (range(800), range(800, 1600))
    corners = napkins.topology["triangles"][upper.triangles]
    assert corners.min() == 441 and corners.max() == 881
    napkins.step(3)
    for cloth in (lower, upper):
        np.testing.assert_array_equal(cloth.positions, napkins.positions[cloth.points])
        np.testing.assert_array_equal(cloth.velocities, napkins.velocities[cloth.points])
    assert not upper.positions.flags.writeable


def test_a_view_follows_the_simulation(napkins):
    upper = napkins.cloths["upper"]
    before = upper.positions.copy()
    napkins.step(5)
    assert upper.positions[:, 2].mean() < before[:, 2].mean()


def test_one_cloth_has_no_names():
    assert clothsim.Simulator({"cloth": {"columns": 3, "rows": 3}}).cloths == {}


def test_a_cloth_of_another_scene_is_refused(napkins):
    upper = napkins.cloths["upper"]
    napkins.load({"cloth": {"columns": 3, "rows": 3}})
    with pytest.raises(clothsim.InvalidValue, match="cloths.*upper.*loaded"):
        upper.points


def test_live_values_change_all_and_come_back(napkins):
    scene = napkins.topology["mass"].sum()
    napkins.set(density=0.38)
    assert napkins.topology["mass"].sum() == pytest.approx(2 * scene)
    napkins.reset_values()
    assert napkins.topology["mass"].sum() == pytest.approx(scene)


def test_each_cloth_has_its_id_in_the_mask(napkins):
    mask = napkins.render({"width": 200, "height": 150, "eye": [0.15, 0.15, 1.0], "target": [0.15, 0.1501, 0]})[2]
    assert set(np.unique(mask)) == {1, 2, 3}  # lower, table, upper
    # The upper one covers the lower one but for two strips at its edges of 0.01 and 0.02 m.
    assert 0.05 < np.sum(mask == 1) / np.sum(mask == 3) < 0.15


def test_cloths_have_the_order_of_the_scene():
    cloth = {"fabric": "felt", "columns": 3, "rows": 3, "width": 0.1, "height": 0.1}
    simulator = clothsim.Simulator({"cloths": [
        {**cloth, "name": name, "origin": [0.2 * i, 0, 0]} for i, name in enumerate(("c", "a", "b"))]})
    assert list(simulator.cloths) == ["c", "a", "b"]
    mask = simulator.render({"width": 300, "height": 60, "eye": [0.25, 0.05, 0.8], "target": [0.25, 0.0501, 0],
                             "field_of_view": 0.9})[2]
    row = mask[30]
    assert [n for n, before in zip(row[1:], row) if n != before and n] == [1, 2, 3]


def test_a_pickled_simulator_goes_on_with_its_values(napkins):
    napkins.set(density=0.3)
    napkins.step(10)
    other = pickle.loads(pickle.dumps(napkins))
    for simulator in (napkins, other):
        simulator.step(10)
    np.testing.assert_array_equal(napkins.positions, other.positions)


def test_a_hand_holds_points_of_one_cloth():
    scene = clothsim.Scene(str(SCENES / "napkins.yaml"), {"motions": []})
    simulator = clothsim.Simulator(scene)
    lower, upper = simulator.cloths["lower"], simulator.cloths["upper"]
    held = simulator.attach("mine", [0.01, 0.02, 0], points=[0, [1, 0], {"near": [0.04, 0.02, 0.002]}], cloth="upper")
    assert held == list(upper.points)[:3]
    assert simulator.attach("mine", points=range(4, 6), cloth="upper") == list(upper.points)[4:6]
    start = lower.positions.copy()
    for i in range(10):
        simulator.step(9, targets={"mine": [0.01, 0.02, 0.02 * (i + 1)]})
    assert upper.positions[:, 2].max() > 0.15
    moved = np.linalg.norm(lower.positions - start, axis=1)
    assert moved.max() < 0.005


def test_live_values_of_one_cloth(napkins):
    one, both = {"lower": {"friction": 0.1}}, {"cloths": {"upper": {"friction": 0.2, "density": 0.5}}, "friction": 0.3}
    napkins.set(cloths=one)
    napkins.set(**both)
    napkins.step(10)
    twin = clothsim.Simulator(str(SCENES / "napkins.yaml"))
    twin.set(friction=0.3)
    twin.set(cloths={"upper": {"density": 0.5}})
    twin.set(cloths={"upper": {"friction": 0.2}})
    twin.step(10)
    np.testing.assert_array_equal(napkins.positions, twin.positions)
    plain = clothsim.Simulator(str(SCENES / "napkins.yaml"))
    plain.step(10)
    assert not np.array_equal(napkins.positions, plain.positions)
    with pytest.raises(clothsim.InvalidValue, match=r"cloths\.upper\.friction: got -1"):
        napkins.set(cloths={"upper": {"friction": -1}})
    with pytest.raises(clothsim.InvalidValue, match="cloths.nobody.*lower, upper"):
        napkins.set(cloths={"nobody": {"friction": 1}})
