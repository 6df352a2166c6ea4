import numpy as np


class Seeded:
    _np_random = None

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            assert np.issubdtype(type(seed), np.integer) and seed >= 0, seed
            self._np_random = np.random.Generator(np.random.PCG64(int(seed)))

    @property
    def np_random(self):
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random
