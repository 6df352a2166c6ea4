"""External forces on points, and internal forces of the cloth: against Newton's and Hooke's laws."""

import pickle

import numpy as np
import pytest
from scenes import free, hanging, same_state

import clothsim
from clothsim import InvalidValue, Simulator

METHODS = ["verlet", "symplectic_euler", "rk4", "implicit_euler", "bdf2", "xpbd"]
G = 9.8  # [m/s^2]


def loose(method="auto", **cloth):
    """Points without springs and gravity."""
    return {"cloth": {"columns": 3, "rows": 3, "damping": 0, "strain_limit": "off",
                      "springs": {"structural": False, "shear": False, "bending": False}, **cloth},
            "simulation": {"gravity": [0, 0, 0], "method": method, "frames_per_second": 100}}


@pytest.mark.parametrize("method", METHODS)
def test_a_free_point_goes_as_newton_has_it(method):
    simulator = Simulator(loose(method))
    mass, start = simulator.topology["mass"], np.array(simulator.positions)
    forces = np.arange(27.0).reshape(9, 3)
    simulator.forces = forces
    assert np.array_equal(simulator.forces, forces)
    simulator.step(50)
    acceleration = forces / mass[:, None]
    assert np.allclose(simulator.positions, start + acceleration * 0.5 ** 2 / 2, atol=1e-12)
    assert np.allclose(simulator.velocities, acceleration * 0.5, atol=1e-12)
    simulator.forces = None
    before = np.array(simulator.velocities)
    simulator.step(5)
    assert simulator.forces is None and np.allclose(simulator.velocities, before, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_pushed_cloth_has_the_momentum_that_it_was_given(method):
    scene = free(8, damping=0, ks=200)
    scene["simulation"] = {"gravity": [0, 0, 0], "method": method}
    simulator = Simulator(scene)
    forces = np.zeros((64, 3))
    forces[[0, 9, 63]] = [[0, 0, 5], [1, 0, 2], [0, -3, 0]]
    simulator.forces = forces
    simulator.step(45)
    momentum = (simulator.topology["mass"][:, None] * simulator.velocities).sum(axis=0)
    assert np.allclose(momentum, forces.sum(axis=0) * 0.5, rtol=1e-9)
    assert simulator.report["recoveries"] == 0


def test_a_force_that_carries_the_weight_carries_it():
    simulator = Simulator(free(10))
    start = np.array(simulator.positions)
    simulator.forces = G * simulator.topology["mass"][:, None] * [0, 0, 1]
    simulator.step(90)
    assert np.allclose(simulator.positions, start, atol=1e-9)


def test_ground_and_hands_feel_it():
    scene = free(8, origin=[0, 0, 0.001], damping=5)
    scene["colliders"] = [{"name": "ground", "shape": "plane", "friction": 0.5}]
    simulator = Simulator(scene)
    simulator.weighs_colliders = True
    weight = G * simulator.topology["mass"].sum()
    simulator.forces = np.full((64, 3), [0, 0, -0.5])
    simulator.step(90)
    assert np.allclose(simulator.contacts["ground"]["force"], [0, 0, -weight - 32], rtol=1e-3, atol=1e-2)

    simulator = Simulator(hanging(8, damping=20))
    simulator.attach("hand", [0, 0, 1], points=[56, 63])
    forces = np.zeros((64, 3))
    forces[56] = [0, 0, -7]  # a held point
    simulator.forces = forces
    simulator.step(400)
    with_push = simulator.grips["hand"]["force"]
    simulator.forces = None
    simulator.step(400)
    assert np.allclose(with_push - simulator.grips["hand"]["force"], [0, 0, -7], atol=0.05)


def test_a_strong_push_is_no_blow_up_and_keeps_the_strain_limit():
    simulator = Simulator(hanging(10, density=0.2, strain_limit=0.05))
    forces = np.zeros((100, 3))
    forces[90:] = [0, 2, 0]  # 200 times its weight, at the lower edge
    simulator.forces = forces
    simulator.step(90)
    assert simulator.report["recoveries"] == 0
    assert simulator.report["worst_stretch"] < 0.06


def test_reset_ends_them_and_states_keep_them():
    simulator = Simulator(free(5))
    simulator.forces = np.full((25, 3), 0.5)
    simulator.step(3)
    state, other = simulator.save(), pickle.loads(pickle.dumps(simulator))
    simulator.step(10)
    other.step(10)
    assert same_state(simulator, other)
    simulator.reset()
    assert simulator.forces is None
    simulator.restore(state)
    simulator.step(10)
    assert same_state(simulator, other)
    assert state.nbytes >= 25 * 3 * 8 * 3


@pytest.mark.parametrize("forces, message", [
    ([[0, 0, 1]], r"^forces: got .*\[1, 3\].*\[9, 3\]"),
    (np.full((9, 3), np.nan), r"forces.0.0: got nan"),
    (np.full((9, 3), 2e6), r"^forces.0.0: got 2e\+06.* 1e\+06 \[N\]"),
    ("much", "forces"),
])
def test_what_is_no_force_is_refused(forces, message):
    simulator = Simulator(loose())
    simulator.forces = np.ones((9, 3))
    with pytest.raises(InvalidValue, match=message):
        simulator.forces = forces
    assert np.array_equal(simulator.forces, np.ones((9, 3)))


# Each cross-section of a strip that hangs from its upper edge carries the weight below it.

COLUMNS, ROWS = 6, 13


def strip(method="auto", **cloth):
    scene = {"cloth": {"width": 0.5, "height": 1.2, "columns": COLUMNS, "rows": ROWS, "density": 2,
                       "damping": 10, "pinned": [[c, 0] for c in range(COLUMNS)], **cloth},
             "simulation": {"method": method}}
    simulator = Simulator(scene)
    simulator.step(1200)
    assert np.abs(simulator.velocities).max() < 1e-3
    return simulator


STRIPS = [("verlet", {"ks": 300, "strain_limit": "off"}), ("implicit_euler", {"ks": 300, "strain_limit": "off"}),
          ("bdf2", {"ks": 3000, "strain_limit": "off"}), ("verlet", {"ks": 100, "strain_limit": 0.02}),
          ("auto", {"fabric": "felt", "damping": 10})]


@pytest.mark.parametrize("method, cloth", STRIPS)
def test_a_cut_carries_the_weight_below(method, cloth):
    simulator = strip(method, **cloth)
    topology, tensions, x = simulator.topology, simulator.tensions, simulator.positions
    a, b = topology["springs"].T
    way = x[a] - x[b]
    up = tensions * way[:, 2] / np.linalg.norm(way, axis=1)
    for row in range(ROWS - 1):
        crossing = (a // COLUMNS <= row) & (b // COLUMNS > row)
        weight = G * topology["mass"][(row + 1) * COLUMNS:].sum()
        assert up[crossing].sum() == pytest.approx(weight, rel=0.02), row


@pytest.mark.parametrize("method, cloth", STRIPS)
def test_stress_along_it_is_the_weight_below_by_its_width(method, cloth):
    simulator = strip(method, **cloth, springs={"bending": False})
    stress = simulator.stress.reshape(ROWS - 1, -1, 3)
    for row, cells in enumerate(stress):
        weight = G * simulator.topology["mass"][(row + 1) * COLUMNS:].sum()
        assert cells[:, 1].mean() == pytest.approx(weight / 0.5, rel=0.04), row
        assert abs(cells[:, 2].mean()) < 0.03 * weight


def test_tensions_and_stress_of_an_even_stretch():
    columns, wide, ks, strain = 9, 0.1, 700, 1e-4
    simulator = Simulator(free(columns, width=0.8, height=0.8, ks=ks))
    assert np.allclose(simulator.tensions, 0, atol=1e-9) and simulator.tensions.shape == (
        len(simulator.topology["springs"]),)
    simulator.positions = simulator.positions * [1 + strain, 1, 1]
    topology = simulator.topology
    along = topology["springs"][:, 1] - topology["springs"][:, 0] == 1
    assert np.allclose(simulator.tensions[along], ks * strain * wide, rtol=1e-6)
    # For each cell: one spring along it, two across it and one over two cells, of 0.2 ks.
    inner = simulator.stress.reshape(columns - 1, columns - 1, 2, 3)[2:-2, 2:-2].mean(axis=(0, 1, 2))
    diagonals = 2 * ks * strain / 2  # each T / L = ks strain / 2
    assert inner[0] == pytest.approx(ks * strain + 4 * 0.2 * ks * strain + diagonals, rel=1e-3)
    assert inner[1] == pytest.approx(diagonals, rel=1e-3) and abs(inner[2]) < 1e-9


def test_a_spring_that_is_pushed_together_pushes():
    simulator = Simulator(free(3, ks=100))
    simulator.positions = simulator.positions * 0.9
    assert (simulator.tensions < 0).all() and (simulator.stress[:, :2] < 0).all()
    rope = Simulator({"cloth": {"columns": 5, "rows": 1}})
    assert rope.tensions.shape == (7,) and rope.stress.shape == (0, 3)
