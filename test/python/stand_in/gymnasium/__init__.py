"""The part of Gymnasium 1.1 that environments use, with those checks of its env_checker that can be made
here: Debian has no package of it."""

from gymnasium import spaces, vector  # noqa: F401
from gymnasium.seeding import Seeded


class Env(Seeded):
    metadata = {"render_modes": []}
    render_mode = None
    spec = None

    def close(self):
        pass

    @property
    def unwrapped(self):
        return self
