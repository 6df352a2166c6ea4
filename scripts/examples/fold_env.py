#!/usr/bin/python3
"""Two grippers fold a towel: an environment with Gymnasium's API, which it does not need.

    env = FoldEnv()
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(action)

Run as a program it folds the towel by a fixed plan and prints the reward.
"""

import collections

import numpy as np

import clothsim

try:
    from gymnasium.spaces import Box
except ImportError:
    Box = collections.namedtuple("Box", "low high shape dtype")

SCENE = {
    "cloth": {"width": 0.6, "height": 0.6, "columns": 25, "rows": 25, "origin": [0, 0, 0.001],
              "density": 0.4, "ks": 200, "thickness": 0.011, "self_collision": True},
    "colliders": [{"name": "table", "shape": "plane", "friction": 0.8}],
}
GRIPPERS = {"left": (0.0, 0.0, 0.02), "right": (0.6, 0.0, 0.02)}  # frame: where it starts [m]
REACH = 0.03  # a gripper takes what is this near [m]
STEP = 0.04  # that it goes in a step at most, along each axis [m]
FRAMES = 9  # of simulation a step, 0.1 s
HIGHEST = 0.5  # a gripper stays within this of the table [m]
FOLDED = 0.8  # counts as folded: layers that are thick do not get to 1
LONGEST = 100  # steps


class FoldEnv:
    """Observation: points [N, 3], grippers [2, 3] [m] and whether each holds [2], in one row. Action
    [2, 4] in [-1, 1]: for each gripper its way as a share of STEP, and above 0 to hold. Reward: what
    the fold got better, `info["fold"]`: 0 as it lay at first, 1 with one half on the other."""

    action_space = Box(-1, 1, (2, 4), np.float32)
    observation_space = Box(-np.inf, np.inf, (25 * 25 * 3 + 2 * 3 + 2,), np.float32)
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}
    render_mode = "rgb_array"

    def __init__(self, view=None):
        self.simulator = clothsim.Simulator(SCENE)
        self.view = clothsim.View(view or {"eye": [0.3, -0.6, 0.7], "target": [0.3, 0.35, 0.1]})
        self.simulator.step(45)  # it comes to rest
        self.start = self.simulator.save()
        rows = np.arange(25 * 25).reshape(25, 25)
        self.half, self.other = rows[:12].ravel(), rows[:12:-1].ravel()
        self.apart = 1.0
        self.apart = self.distance()

    def distance(self):
        """Between a point of one half and where it would lie on the other, on average [m]."""
        points = self.simulator.positions
        return np.linalg.norm(points[self.half] - points[self.other], axis=1).mean()

    def fold(self):
        return 1 - self.distance() / self.apart

    def observe(self):
        points = self.simulator.positions.ravel()
        return np.concatenate([points, self.places.ravel(), self.holds]).astype(np.float32)

    def reset(self, *, seed=None, options=None):
        self.simulator.restore(self.start)
        noise = np.random.default_rng(seed).uniform(-0.01, 0.01, (2, 3)) if seed is not None else 0
        self.places = np.array(list(GRIPPERS.values())) + noise
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
                return  # there is no cloth
        elif self.holds[index] and not wanted:
            self.simulator.detach(frame)
        self.holds[index] = wanted

    def step(self, action):
        action = np.clip(np.asarray(action, dtype=float).reshape(2, 4), -1, 1)
        for index, frame in enumerate(GRIPPERS):
            self.grip(index, frame, action[index, 3] > 0)
        self.places += STEP * action[:, :3]
        self.places[:, 2] = np.clip(self.places[:, 2], 0, HIGHEST)
        self.simulator.step(FRAMES, dict(zip(GRIPPERS, self.places)))
        self.steps += 1
        fold, last = self.fold(), self.last
        self.last = fold
        done = bool(fold > FOLDED and not self.holds.any())
        return self.observe(), fold - last, done, self.steps >= LONGEST, {"fold": fold}

    def render(self):
        """[H, W, 3] uint8."""
        return self.simulator.render(self.view)[0]


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
    env.reset()
    total, done = 0.0, False
    for action in plan():
        _, reward, done, _, info = env.step(action)
        total += reward
    print(f"folded: {info['fold']:.2f}, return {total:.2f}, {'done' if done else 'not done'}")


if __name__ == "__main__":
    main()
