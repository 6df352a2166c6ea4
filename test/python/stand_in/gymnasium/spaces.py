import numpy as np


class Box:
    def __init__(self, low, high, shape, dtype):
        self.low, self.high = (np.full(shape, bound, dtype=dtype) for bound in (low, high))
        self.shape, self.dtype = tuple(shape), np.dtype(dtype)
        self.random = np.random.default_rng(1)

    def sample(self):
        return self.random.uniform(self.low, self.high).astype(self.dtype)

    def __contains__(self, x):
        return (isinstance(x, np.ndarray) and np.can_cast(x.dtype, self.dtype) and x.shape == self.shape
                and bool(np.all(x >= self.low) and np.all(x <= self.high)))
