"""Keys of four levels at once: the same hashes as one after the other."""

import numpy as np
import pytest

from aqvc import tiles
from viscache import _core

C_E = (16.0, 8.0, 4.0, 2.0)


def hashes(*, at_once):
    """(2, N, 4): κ and digest of a tile's eye points at four levels, a point light each."""
    eyes = tiles.eye_points(48, 48)
    n = len(eyes["density"])
    resolutions = np.stack(
        [
            _core.aqvc.resolution_eye(eyes["density"].astype(np.float64), c, tiles.RADIUS)
            for c in C_E
        ],
        axis=1,
    )
    lights = np.random.default_rng(1).uniform(-5, 5, (n, 3)).astype(np.float32)
    kappa, digest, seconds = _core.aqvc.level_hashes(
        _core.aqvc.AqvcParameters(),
        tiles.CENTER,
        tiles.RADIUS,
        eyes["position"],
        eyes["normal"],
        resolutions,
        lights,
        at_once=at_once,
    )
    assert seconds > 0
    return np.stack([kappa, digest])


def test_four_levels_at_once_have_the_hashes_of_full_keys():
    one, four = hashes(at_once=False), hashes(at_once=True)
    np.testing.assert_array_equal(four, one)
    eyes = tiles.eye_points(48, 48)
    n = len(eyes["density"])
    lights = np.random.default_rng(1).uniform(-5, 5, (n, 3)).astype(np.float32)
    for level, c_e in enumerate(C_E):
        resolution = _core.aqvc.resolution_eye(
            eyes["density"].astype(np.float64), c_e, tiles.RADIUS
        )
        near = (tiles.CENTER, tiles.RADIUS, eyes["position"], eyes["normal"], resolution)
        far = (tiles.POINT, lights, np.zeros((n, 3)), np.ones(n))
        keys = _core.aqvc.full_keys(_core.aqvc.AqvcParameters(), *near, *far)[0]
        np.testing.assert_array_equal(four[:, :, level].T, _core.aqvc.hash_keys(keys))
    # Levels differ, so that a chain in another's place would be seen
    assert (four[0, :, 0] != four[0, :, 1]).mean() > 0.9


@pytest.mark.parametrize(
    ("shape", "says"),
    [((2, 4), "must have equal lengths"), ((3, 2), "resolutions must have shape")],
)
def test_unequal_lengths_are_refused(shape, says):
    p, three = _core.aqvc.AqvcParameters(), np.zeros((3, 3), np.float32)
    with pytest.raises(ValueError, match=says):
        _core.aqvc.level_hashes(
            p, (0, 0, 0), 1.0, three, three, np.ones(shape), three, at_once=True
        )
