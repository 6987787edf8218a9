"""Arguments that are no numbers are refused by their name, whatever takes them."""

import numpy as np
import pytest

import viscache as vc
from viscache.settings.checks import checked_floats

POINT, UP = [(0.0, 1.0, 0.0)], [(0.0, 1.0, 0.0)]
CALLS = {
    "positions": lambda bad: vc.Vpls(bad, UP, POINT),
    "normals": lambda bad: vc.Vpls(POINT, bad, POINT),
    "flux": lambda bad: vc.Vpls(POINT, UP, bad),
    "directions": lambda bad: vc.FarEnds.directions(bad),
    "albedo": lambda bad: vc.Sky(sun_direction=(0, 1, 0), albedo=bad),
    "sun_direction": lambda bad: vc.Sky(sun_direction=bad),
}


@pytest.mark.parametrize("bad", ["", "x", b"x", 1j, {}, object(), [[1, 2, 3], [1]]])
@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_number_is_refused_by_name(name, bad):
    with pytest.raises(ValueError, match=f"^{name} must be numbers, got "):
        CALLS[name](bad)


def test_a_light_that_is_no_number_is_refused_by_name():
    maps = vc.VisibilityMapCache("cube_on_plane", vc.MapSettings(m=4, n_startup=10))
    image = vc.Relighting(maps, size=(8, 8), threads=1)
    with pytest.raises(ValueError, match=r"^env must be numbers, got b"):
        image.under(b"x")


def test_numbers_become_floats_of_their_shape():
    assert checked_floats(2, "x").shape == ()
    found = checked_floats([[1, 2], [3, 1e300]], "x")
    assert found.dtype == np.float32 and found.tolist() == [[1, 2], [3, np.inf]]
    assert checked_floats([1e300], "x", np.float64).tolist() == [1e300]


def test_arrays_given_to_vpls_stay_writable():
    given = np.float32(POINT)
    vc.Vpls(given, UP, POINT)
    given[0, 0] = 1  # a copy is frozen, not this one


def test_pictures_that_are_no_numbers_are_refused_by_name():
    with pytest.raises(ValueError, match="must be numbers, got 'x'"):
        vc.metrics.compare("x", np.zeros((4, 4, 3)))
