"""No array, colour or matrix may be complex: NumPy would drop imaginary parts with a warning."""

import warnings

import numpy as np
import pytest

import viscache as vc
from codebase.repository import sources
from viscache.base import tonemap
from viscache.base.real_numbers import real_array
from viscache.correlation import pairs

CORNERS, ONE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), [[0, 1, 2]]
POINTS, UP, SQUARE = CORNERS + 0.5, [[0.0, 0, 1]] * 3, [[0.0, 0], [1, 0], [0, 1]]
COLOR, IMAGE = np.array([0.2, 0.4, 0.6]), np.ones((2, 4, 3))
PLACE, BITS = np.eye(4), np.ones((3, 1), np.uint64)


def described(method, *before):
    """A method of a new description, after some arguments."""
    return lambda *more, **named: getattr(vc.SceneDescription(), method)(*before, *more, **named)


def scene():
    return vc.scenes.cube_on_plane()


#: What takes numbers, the numbers, and the call.
DOORS = {
    "add_mesh vertices": (CORNERS, lambda v: described("add_mesh")(v, ONE)),
    "add_mesh triangles": (np.array(ONE), described("add_mesh", CORNERS)),
    "add_mesh normals": (UP, lambda v: described("add_mesh", CORNERS, ONE)(normals=v)),
    "add_mesh uvs": (SQUARE, lambda v: described("add_mesh", CORNERS, ONE)(uvs=v)),
    "add_mesh colors": (CORNERS, lambda v: described("add_mesh", CORNERS, ONE)(colors=v)),
    "add_mesh emission": (COLOR, lambda v: described("add_mesh", CORNERS, ONE)(emission=v)),
    "add_material base_color": (COLOR, lambda v: described("add_material")(base_color=v)),
    "add_material specular": (COLOR, lambda v: described("add_material")(specular=v)),
    "add_material metal_k": (COLOR, lambda v: described("add_material")(metal_k=v)),
    "add_instance": (PLACE, described("add_instance", [0])),
    "add_point_light position": (COLOR, lambda v: described("add_point_light")(v, (1, 1, 1))),
    "add_point_light intensity": (COLOR, described("add_point_light", (0, 0, 0))),
    "add_point_light axis": (COLOR, lambda v: described("add_point_light", COLOR, COLOR)(axis=v)),
    "add_point_lights positions": (POINTS, lambda v: described("add_point_lights")(v, POINTS)),
    "add_point_lights intensities": (POINTS, described("add_point_lights", POINTS)),
    "add_directional_light": (COLOR, described("add_directional_light", (0, 1, 0))),
    "add_sphere_light": (COLOR, described("add_sphere_light", (0, 0, 0), 1.0)),
    "add_image": (IMAGE, described("add_image")),
    "set_environment scale": (COLOR, described("set_environment")),
    "set_environment to_world": (PLACE, lambda v: described("set_environment")(to_world=v)),
    "add_camera": (COLOR, described("add_camera", (0, 0, 0))),
    "from_arrays vertices": (CORNERS, lambda v: vc.Scene.from_arrays(v, ONE)),
    "from_arrays normals": (UP, lambda v: vc.Scene.from_arrays(CORNERS, ONE, normals=v)),
    "from_arrays colors": (CORNERS, lambda v: vc.Scene.from_arrays(CORNERS, ONE, colors=v)),
    "from_arrays base_color": (COLOR, lambda v: vc.Scene.from_arrays(CORNERS, ONE, base_color=v)),
    "from_arrays material": (COLOR, lambda v: vc.Scene.from_arrays([(CORNERS, ONE, v)])),
    "from_arrays env": (COLOR, lambda v: vc.Scene.from_arrays(CORNERS, ONE, env=v)),
    "with_environment pixels": (IMAGE, lambda v: scene().with_environment(v)),
    "sweep env": (
        COLOR,
        lambda v: vc.sweep("cube_on_plane", "direct", size=(4, 4), over={"c_e": [4]}, env=v),
    ),
    "look_at": (COLOR, lambda v: vc.look_at(v, (0, 0, 0))),
    "orthographic": (COLOR, lambda v: vc.orthographic(v, (0, 0, 0), height=2)),
    "visible": (POINTS, lambda v: scene().visible(v, POINTS + 1)),
    "visible_matrix": (POINTS, lambda v: scene().visible_matrix(POINTS, v)),
    "occluded directions": (UP, lambda v: scene().occluded(POINTS, v)),
    "occluded t_max": (np.ones(3), lambda v: scene().occluded(POINTS, UP, v)),
    "intersect": (POINTS, lambda v: scene().intersect(v, UP)),
    "EyePoints": (POINTS, lambda v: vc.EyePoints(v, UP)),
    "EyePoints density": (np.ones(3), lambda v: vc.EyePoints(POINTS, UP, density=v)),
    "FarEnds.points": (POINTS, vc.FarEnds.points),
    "FarEnds.directions": (UP, vc.FarEnds.directions),
    "Vpls flux": (POINTS, lambda v: vc.Vpls(POINTS, UP, v)),
    "Sky sun_direction": ([0.0, 1, 0], lambda v: vc.Sky(sun_direction=v)),
    "Sky albedo": (COLOR, lambda v: vc.Sky(sun_direction=(0, 1, 0), albedo=v)),
    "Sky.radiance": (UP, vc.Sky(sun_direction=(0, 1, 0)).radiance),
    "Frame layers": (IMAGE, lambda v: vc.Frame(layers={"color": v})),
    "metrics": (IMAGE, lambda v: vc.metrics.compare(v, IMAGE)),
    "tonemap.to_srgb8": (IMAGE, tonemap.to_srgb8),
    "tonemap.difference8": (IMAGE, lambda v: tonemap.difference8(IMAGE, v)),
    "aligned_occlusion": (POINTS, lambda v: vc.aligned_occlusion(scene(), v, UP)),
    "correlation positions": (
        POINTS,
        lambda v: pairs.spatial_map(BITS, v, UP, d_max=1.0, theta_max_deg=9.0),
    ),
}
WAYS = {
    "array": lambda v: np.asarray(v) + 0j,
    "single precision": lambda v: np.asarray(v).astype(np.complex64),
    "list": lambda v: (np.asarray(v) + 0j).tolist(),
    "list of NumPy's numbers": lambda v: list(np.asarray(v) + 0j),
    "objects": lambda v: (np.asarray(v) + 0j).astype(object),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("door", DOORS)
def test_complex_numbers_are_refused(door, way):
    given, call = DOORS[door]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # as in most programs: no warning ends the call
        call(given)  # the call itself is right
        with pytest.raises((ValueError, TypeError), match=r"must be .*(number|integer|pixels)"):
            call(WAYS[way](given))


def test_real_arrays_keep_their_type():
    for given in (np.arange(3), np.float32([1, 2]), [[1, 2.5]], np.array([1, None], object)):
        found = real_array(given, "x")
        assert found.dtype == np.asarray(given).dtype and found.tolist() == list(
            np.asarray(given).tolist()
        )


def test_bindings_have_no_other_conversion_of_numbers():
    """Arrays of floats, colours and points go through cpp/bindings/real_numbers.h alone."""
    found = sources(".h", ".cpp", under="cpp/bindings/")
    of_tests = sources(".h", ".cpp", under="tests/core/")
    assert len(found) > 50 and len(of_tests) > 10
    for path, text in (found | of_tests).items():
        if path.endswith("/real_numbers.h"):
            continue
        assert "pybind11/stl.h" not in text, path
        for number in ("float", "double"):
            assert f"py::array_t<{number}, py::array::c_style | py::array::forcecast>" not in text
            assert f"py::array_t<{number}, py::array::forcecast>" not in text
