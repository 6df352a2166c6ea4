#!/usr/bin/python3
"""Two grippers fold a towel: environments of Gymnasium's API, for one towel and for many at once.

    env = FoldEnv()
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(action)

    envs = FoldVectorEnv(16)  # in one clothsim.Batch, all cores
    observations, infos = envs.reset(seed=1)

With Gymnasium installed they are a gymnasium.Env and a gymnasium.vector.VectorEnv; without it they work
as well. Run as a program this folds the towel by a fixed plan and prints the reward.
"""

import collections

import numpy as np

import clothsim

try:
    from gymnasium import Env
    from gymnasium.spaces import Box
    from gymnasium.vector import VectorEnv
except ImportError:
    Box = collections.namedtuple("Box", "low high shape dtype")

    class Env:
        """The part of gymnasium.Env that is used here."""

        np_random = np.random.default_rng()

        def reset(self, *, seed=None, options=None):
            if seed is not None:
                self.np_random = np.random.default_rng(seed)

    class VectorEnv(Env):
        """The part of gymnasium.vector.VectorEnv that is used here."""

try:
    from gymnasium.vector import AutoresetMode
    AUTORESET = {"autoreset_mode": AutoresetMode.NEXT_STEP}
except ImportError:  # Gymnasium before 1.1 has no name for it
    AUTORESET = {}

SCENE = {
    "cloth": {"width": 0.6, "height": 0.6, "columns": 25, "rows": 25, "origin": [0, 0, 0.001],
              "density": 0.4, "ks": 200, "thickness": 0.011, "self_collision": True},
    "colliders": [{"name": "table", "shape": "plane", "friction": 0.8}],
}
VIEW = {"eye": [0.3, -0.6, 0.7], "target": [0.3, 0.35, 0.1]}
GRIPPERS = {"left": (0.0, 0.0, 0.02), "right": (0.6, 0.0, 0.02)}  # frame: initial position [m]
OFF = 0.01  # largest offset of the initial position, along each axis [m]
REACH = 0.03  # radius within which a gripper takes points [m]
STEP = 0.04  # largest motion of a gripper in a step, along each axis [m]
FRAMES = 9  # of simulation a step, 0.1 s
LOWEST, HIGHEST = (-0.5, -0.5, 0.0), (1.1, 1.1, 0.5)  # corners of the space of the grippers [m]
FARTHEST = 2.0  # bound of all observations [m], beyond the reach of a towel held by a gripper
FOLDED = 0.8  # score of a folded towel: thick layers do not reach 1
LONGEST = 100  # steps of an episode

ACTIONS = Box(-1, 1, (2, 4), np.float32)
OBSERVATIONS = Box(-FARTHEST, FARTHEST, (25 * 25 * 3 + 2 * 3 + 2,), np.float32)
METADATA = {"render_modes": ["rgb_array"], "render_fps": 10}


def batch(space, count):
    """The space of `count` environments."""
    return Box(np.min(space.low), np.max(space.high), (count, *space.shape), space.dtype)


class Towel:
    """A towel, two grippers and the score. The caller steps the simulation.

    Observation: points [N, 3], grippers [2, 3] [m] and whether each holds [2], in one row. Action
    [2, 4] in [-1, 1]: for each gripper its motion as a share of STEP, and a value above 0 to hold.
    Reward: increase of the score `info["fold"]`, which is 0 at the start and 1 with one half on the
    other."""

    def __init__(self, start=None):
        self.simulator = clothsim.Simulator(SCENE)
        if start is None:
            self.simulator.step(45)  # the towel comes to rest
        else:
            self.simulator.restore(start)
        self.start = start or self.simulator.save()
        rows = np.arange(25 * 25).reshape(25, 25)
        self.half, self.other = rows[:12].ravel(), rows[:12:-1].ravel()
        self.apart = self.distance()

    def distance(self):
        """Mean distance between points of one half and their counterparts on the other [m]."""
        points = self.simulator.positions
        return np.linalg.norm(points[self.half] - points[self.other], axis=1).mean()

    def fold(self):
        return float(1 - self.distance() / self.apart)

    def observe(self):
        points = self.simulator.positions.ravel()
        return np.concatenate([points, self.places.ravel(), self.holds]).astype(np.float32)

    def reset(self, random, options=None):
        """`random` is a generator: the grippers start within OFF of their initial positions, or within
        options["off"] [m]."""
        off = (options or {}).get("off", OFF)
        self.simulator.restore(self.start)
        self.places = np.array(list(GRIPPERS.values())) + random.uniform(-off, off, (2, 3))
        self.holds = np.zeros(2, dtype=bool)
        for frame, place in zip(GRIPPERS, self.places):
            self.simulator.place_frame(frame, place)
        self.steps, self.last = 0, self.fold()
        return self.observe(), {"fold": self.last}

    def grip(self, index, frame, wanted):
        if wanted and not self.holds[index]:
            try:
                self.simulator.attach(frame, radius=REACH)
            except clothsim.InvalidValue:
                return  # no cloth within reach
        elif self.holds[index] and not wanted:
            self.simulator.detach(frame)
        self.holds[index] = wanted

    def act(self, action):
        """Grips and releases; returns the targets of the frames for the step."""
        action = np.clip(np.asarray(action, dtype=float).reshape(2, 4), -1, 1)
        for index, frame in enumerate(GRIPPERS):
            self.grip(index, frame, action[index, 3] > 0)
        self.places = np.clip(self.places + STEP * action[:, :3], LOWEST, HIGHEST)
        self.steps += 1
        return dict(zip(GRIPPERS, self.places))

    def outcome(self, diverged):
        """The result of Gymnasium's step(). A towel that `diverged` ends its episode."""
        fold, last = self.fold(), self.last
        self.last = fold
        terminated = bool(fold > FOLDED and not self.holds.any())
        truncated = diverged or self.steps >= LONGEST
        return self.observe(), fold - last, terminated, truncated, {"fold": fold}

    def render(self, view):
        """[H, W, 3] uint8."""
        return self.simulator.render(view)[0]


class FoldEnv(Env):
    """One towel: see Towel."""

    action_space = ACTIONS
    observation_space = OBSERVATIONS
    metadata = METADATA

    def __init__(self, render_mode="rgb_array", view=None):
        self.render_mode = render_mode
        self.view = clothsim.View(view or VIEW)
        self.towel = Towel()
        self.simulator = self.towel.simulator

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.towel.reset(self.np_random, options)

    def step(self, action):
        diverged = False
        try:
            self.simulator.step(FRAMES, self.towel.act(action))
        except clothsim.Diverged:
            diverged = True
        return self.towel.outcome(diverged)

    def render(self):
        return self.towel.render(self.view)


class FoldVectorEnv(VectorEnv):
    """Many towels, stepped by all cores. A towel whose episode has ended is reset in the following step,
    for any action (AutoresetMode.NEXT_STEP)."""

    metadata = {**METADATA, **AUTORESET}
    single_action_space = ACTIONS
    single_observation_space = OBSERVATIONS

    def __init__(self, num_envs, render_mode="rgb_array", view=None, threads=None):
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.view = clothsim.View(view or VIEW)
        self.action_space = batch(ACTIONS, num_envs)
        self.observation_space = batch(OBSERVATIONS, num_envs)
        first = Towel()
        self.towels = [first, *(Towel(first.start) for _ in range(num_envs - 1))]
        self.batch = clothsim.Batch([towel.simulator for towel in self.towels], threads)
        self.randoms = [np.random.default_rng() for _ in self.towels]
        self.ended = np.zeros(num_envs, dtype=bool)

    def reset(self, *, seed=None, options=None):
        """`seed` is a list with one for each towel, or an int: then towel i has seed + i, as in
        SyncVectorEnv."""
        super().reset(seed=seed if seed is None or np.isscalar(seed) else seed[0])
        seeds = np.arange(self.num_envs) + seed if np.isscalar(seed) else seed
        if seeds is not None:
            self.randoms = [np.random.default_rng(one) for one in seeds]
        self.ended[:] = False
        results = [towel.reset(random, options)
                   for towel, random in zip(self.towels, self.randoms)]
        observations, infos = zip(*results)
        return np.stack(observations), self.gather(infos)

    def step(self, actions):
        goes_on = ~self.ended
        diverged = np.zeros(self.num_envs, dtype=bool)
        try:
            self.batch.step([towel.act(action) if lives else None for towel, action, lives in
                             zip(self.towels, actions, goes_on)], FRAMES)
        except clothsim.Diverged as error:
            diverged[error.environments] = True
        results = [towel.outcome(bool(failed)) if lives else
                   self.start_anew(towel, random) for towel, random, lives, failed in
                   zip(self.towels, self.randoms, goes_on, diverged)]
        observations, rewards, terminated, truncated, infos = zip(*results)
        terminated, truncated = np.array(terminated), np.array(truncated)
        self.ended = terminated | truncated
        return (np.stack(observations), np.array(rewards, dtype=float), terminated, truncated,
                self.gather(infos))

    def start_anew(self, towel, random):
        observation, info = towel.reset(random)
        return observation, 0.0, False, False, info

    def gather(self, infos):
        """A mask beside each key marks the towels that have it, as in Gymnasium."""
        return {"fold": np.array([info["fold"] for info in infos]),
                "_fold": np.ones(self.num_envs, dtype=bool)}

    def render(self):
        return tuple(towel.render(self.view) for towel in self.towels)


def plan():
    """Takes two corners, lifts them over the middle to the far edge, lets go."""
    angles = np.linspace(0, np.pi, 31)
    way = 0.3 * np.stack([1 - np.cos(angles), np.sin(angles)], axis=1)  # y, z
    for dy, dz in np.diff(way, axis=0):
        yield np.tile([0, dy / STEP, dz / STEP, 1], (2, 1))
    for _ in range(10):
        yield np.zeros((2, 4))


def main():
    env = FoldEnv()
    env.reset(options={"off": 0})
    total, done = 0.0, False
    for action in plan():
        _, reward, done, _, info = env.step(action)
        total += reward
    print(f"folded: {info['fold']:.2f}, return {total:.2f}, {'done' if done else 'not done'}")


if __name__ == "__main__":
    main()
