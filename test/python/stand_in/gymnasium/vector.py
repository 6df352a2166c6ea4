import enum

from gymnasium.seeding import Seeded


class AutoresetMode(enum.Enum):
    NEXT_STEP = "NextStep"


class VectorEnv(Seeded):
    metadata = {}
    spec = None
    render_mode = None
    closed = False

    def close(self, **kwargs):
        self.closed = True
