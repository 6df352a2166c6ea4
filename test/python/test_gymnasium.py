"""The environments of scripts/examples/fold_env.py against Gymnasium: its own checker where it is
installed, else a stand-in with the same rules."""

import importlib
import importlib.util
import pathlib
import sys

import numpy as np
import pytest
from scenes import CLONE

import clothsim

STAND_IN = pathlib.Path(__file__).parent / "stand_in"
HAS_GYMNASIUM = importlib.util.find_spec("gymnasium") is not None


@pytest.fixture(params=["gymnasium", "nothing"])
def fold_env(request, monkeypatch):
    """The module, imported with Gymnasium or its stand-in, and with neither."""
    monkeypatch.syspath_prepend(CLONE / "scripts/examples")
    for name in [name for name in sys.modules if name.split(".")[0] in ("gymnasium", "fold_env")]:
        monkeypatch.delitem(sys.modules, name)
    if request.param == "nothing":
        monkeypatch.setitem(sys.modules, "gymnasium", None)  # an import of it fails
    elif not HAS_GYMNASIUM:
        monkeypatch.syspath_prepend(STAND_IN)
    yield importlib.import_module("fold_env")
    for name in [name for name in sys.modules if name.split(".")[0] in ("gymnasium", "fold_env")]:
        del sys.modules[name]


def within(space, x):
    return x.shape == space.shape and x.dtype == space.dtype and np.all(x >= space.low) and \
        np.all(x <= space.high)


def some_actions(count, steps):
    """The plan's actions, slightly changed: they crumple no towel, which would be slow to simulate."""
    import fold_env
    random = np.random.default_rng(1)
    for action in list(fold_env.plan())[:steps]:
        yield (action + random.uniform(-0.1, 0.1, (count, 2, 4))).clip(-1, 1).astype(np.float32)


def test_the_environment_is_one_of_gymnasium(fold_env):
    gymnasium = sys.modules.get("gymnasium")
    env, envs = fold_env.FoldEnv(), fold_env.FoldVectorEnv(2)
    if gymnasium is None:
        assert type(env.action_space).__module__ == "fold_env"
        return
    assert isinstance(env, gymnasium.Env) and isinstance(envs, gymnasium.vector.VectorEnv)
    assert isinstance(env.action_space, gymnasium.spaces.Box)
    assert envs.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.NEXT_STEP
    env.close()
    envs.close()
    assert envs.closed


@pytest.mark.skipif(not HAS_GYMNASIUM, reason="Gymnasium is not installed")
@pytest.mark.filterwarnings("error")
@pytest.mark.filterwarnings("ignore:.*not having a spec.*")
def test_gymnasium_finds_nothing_wrong():
    from gymnasium.utils.env_checker import check_env
    sys.path.insert(0, str(CLONE / "scripts/examples"))
    import fold_env
    check_env(fold_env.FoldEnv())


def test_what_the_checker_asks_of_reset(fold_env):
    env = fold_env.FoldEnv()
    first, info = env.reset(seed=123)
    assert within(env.observation_space, first) and isinstance(info, dict)
    state = env.np_random.bit_generator.state
    again, _ = env.reset(seed=123)
    assert np.array_equal(first, again) and env.np_random.bit_generator.state == state
    other, _ = env.reset(seed=456)
    assert not np.array_equal(first, other) and env.np_random.bit_generator.state != state
    without_a_seed, _ = env.reset(options={})
    assert not np.array_equal(other, without_a_seed)  # the generator goes on


def test_what_the_checker_asks_of_step(fold_env):
    env = fold_env.FoldEnv()
    env.reset(seed=1)
    for actions in some_actions(1, 10):
        observation, reward, terminated, truncated, info = env.step(actions[0])
        assert within(env.observation_space, observation)
        assert isinstance(reward, float) and np.isfinite(reward)
        assert terminated is False and truncated is False and isinstance(info["fold"], float)
    assert env.render().dtype == np.uint8 and env.render_mode in env.metadata["render_modes"]


def test_grippers_stay_in_their_space(fold_env):
    env = fold_env.FoldEnv()
    env.reset(seed=1)
    for step in range(fold_env.LONGEST):
        observation, _, _, truncated, _ = env.step([[1, 1, 1, -1]] * 2)
    assert truncated and within(env.observation_space, observation)
    assert np.array_equal(env.towel.places, np.tile(fold_env.HIGHEST, (2, 1)))


def test_many_are_as_one_by_one(fold_env):
    count = 3
    envs = fold_env.FoldVectorEnv(count, threads=2)
    assert envs.action_space.shape == (count, 2, 4)
    assert envs.single_observation_space.shape == fold_env.OBSERVATIONS.shape
    observations, infos = envs.reset(seed=7)
    singles = [fold_env.FoldEnv() for _ in range(count)]
    firsts = [env.reset(seed=7 + i)[0] for i, env in enumerate(singles)]
    assert np.array_equal(observations, np.stack(firsts))
    assert within(envs.observation_space, observations) and infos["_fold"].all()
    by_list, _ = envs.reset(seed=[7, 8, 9])
    assert np.array_equal(observations, by_list)
    for actions in some_actions(count, 8):
        observations, rewards, terminated, truncated, infos = envs.step(actions)
        assert rewards.shape == terminated.shape == truncated.shape == (count,)
        assert terminated.dtype == truncated.dtype == bool
        for i, env in enumerate(singles):
            observation, reward, _, _, info = env.step(actions[i])
            assert np.array_equal(observations[i], observation)
            assert rewards[i] == reward and infos["fold"][i] == info["fold"]
    assert [image.shape for image in envs.render()] == [(480, 640, 3)] * count


def test_one_that_has_ended_starts_anew_in_the_next_step(fold_env):
    envs = fold_env.FoldVectorEnv(2)
    envs.reset(seed=1)
    envs.towels[1].steps = fold_env.LONGEST - 1
    actions = np.zeros((2, 2, 4))
    *_, truncated, _ = envs.step(actions)
    assert list(truncated) == [False, True]
    observations, rewards, terminated, truncated, infos = envs.step(np.ones((2, 2, 4)))
    assert not terminated.any() and not truncated.any()
    assert rewards[1] == 0 and infos["fold"][1] == pytest.approx(0, abs=1e-9)
    points = observations[1][:25 * 25 * 3].reshape(-1, 3)
    assert np.ptp(points[:, 2]) < 0.01  # it lies flat, as at the start
    assert envs.towels[1].steps == 0 and envs.towels[0].steps == 2


def test_one_that_diverges_ends_its_episode(fold_env, monkeypatch):
    env = fold_env.FoldEnv()
    env.reset(seed=1)

    class Broken:
        positions = env.simulator.positions

        def step(self, frames, targets):
            raise clothsim.Diverged("lost")
    env.simulator = Broken()
    *_, terminated, truncated, _ = env.step(np.zeros((2, 4)))
    assert truncated and not terminated

    envs = fold_env.FoldVectorEnv(2)
    envs.reset(seed=1)

    class BrokenBatch:
        def step(self, actions, frames):
            error = clothsim.Diverged("lost")
            error.environments = [1]
            raise error
    envs.batch = BrokenBatch()
    *_, truncated, _ = envs.step(np.zeros((2, 2, 4)))
    assert list(truncated) == [False, True]
