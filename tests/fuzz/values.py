"""Numbers and arrays of every kind that a caller may pass."""

import random

import numpy as np

FLOATS = [
    *(0.0, -0.0, 1.0, -1.0, 0.5, 1e-3, 1e-6, 1e-20, 1e-38, 1e-45, 1e-300, 1e3, 1e6, 1e10, 1e16),
    *(1.0000001e16, 1e20, 3.4e38, 1e39, 1e300, float("inf"), float("-inf"), float("nan")),
]
WHOLE = [-1, 0, 1, 2, 3, 8, 2**24, 2**31 - 1, 2**31, -(2**31), 2**32, 2**63, 2**64, -(2**63)]
STRANGE = [None, True, "", "3", "x", b"x", [], {}, (), object(), 1j, np.float16(2), 1.5]


class Dice:
    """A generator with a share of wild values: 0 gives what a sane caller might pass."""

    def __init__(self, random_: random.Random) -> None:
        self.random = random_
        self.wild = random_.choice([0.0, 0.0, 0.01, 0.05, 0.3])

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def is_wild(self) -> bool:
        return self.chance(self.wild)

    def pick(self, *values):
        return self.random.choice(values)

    def numpy(self) -> np.random.Generator:
        return np.random.default_rng(self.random.getrandbits(32))

    def number(self):
        """A float near 1, or any other."""
        if self.is_wild():
            return self.random.choice(FLOATS + WHOLE + STRANGE)
        return self.pick(self.random.uniform(-2, 2), self.random.random(), self.pick(1, 2, 3, 8))

    def real(self, low: float, high: float):
        """A float of a range, its ends among them, or any other."""
        if self.is_wild():
            return self.random.choice([*FLOATS, *STRANGE, np.nextafter(low, -1e9), -high])
        if self.chance(0.3):
            return self.pick(low, high)
        if low > 0:
            return float(np.exp(self.random.uniform(np.log(low), np.log(high))))
        return self.random.uniform(low, high)

    def whole(self, low: int, high: int):
        """An integer of a range, its ends among them, or any other."""
        if self.is_wild():
            return self.random.choice([*WHOLE, *STRANGE, low - 1, high + 1])
        return self.pick(low, high, self.random.randint(low, high), min(high, low + 1))

    def array(self, shape: tuple[int, ...], unit: bool = False):
        """Coordinates of any size and type; directions of length 1 with `unit`."""
        rng = self.numpy()
        values = rng.uniform(-1, 1, shape)
        if unit and values.size:
            values /= np.linalg.norm(values, axis=-1, keepdims=True)
            if self.chance(0.3):
                values[...] = self.pick((0, 0, 1), (0, -1, 0), (1, 0, -0.0))
        elif self.chance(0.3):
            values = values * self.pick(1e-45, 1e-38, 1e-19, 1e-6, 1e6, 1e10)
        elif self.chance(0.3):
            values = np.round(values) + self.pick(0, 1e3, 1e6)
        return self._as_wild_array(values, rng) if self.is_wild() else self._as_array(values)

    def _as_array(self, values):
        kind = self.random.randrange(6)
        if kind == 0:
            return values
        if kind == 1:
            return values.astype(">f4")
        if kind == 2:
            return np.asfortranarray(values)
        if kind == 3:
            return np.repeat(values, 2, axis=0)[::2]
        return values.astype(np.float32)

    def _as_wild_array(self, values, rng: np.random.Generator):
        kind = self.random.randrange(14)
        with np.errstate(all="ignore"):
            if kind < 4:
                values = values.copy()
                values[rng.random(values.shape) < self.pick(0.05, 0.3, 1)] = self.random.choice(
                    FLOATS
                )
                return values.astype(self.pick(np.float32, np.float64))
            makers = [
                lambda: values.astype(np.float16),
                lambda: values.astype(object),
                lambda: values.tolist(),
                lambda: np.ma.masked_array(values, mask=rng.random(values.shape) < 0.3),
                lambda: values[..., :2],
                lambda: values[None],
                lambda: values.ravel(),
                lambda: values.astype(np.longdouble),
                lambda: np.empty((0, *values.shape[1:])),
                lambda: self.random.choice(STRANGE),
            ]
            return makers[kind - 4]()
