"""A sky for the tests of shared directions, and its light in a frame."""

import numpy as np

import viscache as vc


def gradient():
    """Brighter on one side, with one bright patch that few samples meet."""
    rows, columns = np.mgrid[0:32, 0:64]
    sky = np.stack([1 + columns / 16, 2 - rows / 32, 0 * rows + 0.5], -1).astype(np.float32)
    sky[8:10, 20:23] = 30
    return sky


def light(frame: vc.Frame):
    return np.asarray(frame.layers["environment"], np.float64)


def with_sets(n: int, sets: int, **more) -> vc.Direct:
    """Directions in sets that the eye points of a pixel ask in turns."""
    return vc.Direct(environment="shared", n_environment=n, interleave=sets, n_area=0, **more)
