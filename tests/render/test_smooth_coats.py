"""Lights without an extent do not show in the mirror of a smooth coat; lights with one do."""

import numpy as np
import pytest

import viscache as vc
from viscache._core import CoatKind, MaterialKind

CORNERS = np.array([[-3, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]], np.float32)
FACES = np.array([[0, 2, 1], [0, 3, 2]], np.uint32)
#: Mirror image of the camera's view: all lights stand there.
ABOVE = np.array([0, 3, -3], np.float32)
CAMERA = vc.look_at(origin=(0, 3, 3), target=(0, 0, 0))


LIGHTS = {
    "point": lambda d: d.add_point_light(ABOVE, (9, 9, 9)),
    "spot": lambda d: d.add_point_light(ABOVE, (9, 9, 9), axis=(0, -1, 1), cone_deg=(30, 40)),
    "direction": lambda d: d.add_directional_light((0, 1, -1), (2, 2, 2)),
    "globe": lambda d: d.add_sphere_light(ABOVE, 0.5, (9, 9, 9)),
    "sky": lambda d: d.set_environment((1, 1, 1)),
}


def picture(light, integrator=None, **material):
    """A floor that reflects a light into the camera, without the light itself."""
    d = vc.SceneDescription()
    look = {"base_color": (0.5, 0.5, 0.5), "specular": (1, 1, 1), "roughness": 0.02}
    d.add_material(MaterialKind.GLOSSY, **look | {"coat": CoatKind.SMOOTH} | material)
    d.add_mesh(CORNERS, FACES)
    LIGHTS[light](d)
    scene = vc.Scene.from_description(d)
    integrator = integrator or vc.Direct()
    return vc.render(scene, integrator, camera=CAMERA, size=(16, 16), spp=16)


@pytest.mark.parametrize("light", ["point", "spot", "direction"])
def test_a_light_without_an_extent_leaves_the_diffuse_part_alone(light):
    made = picture(light).image
    assert made.mean() > 0
    assert np.array_equal(made, picture(light, specular=(0, 0, 0)).image)
    # Power: microfacets of the same roughness show the light
    assert picture(light, coat=CoatKind.ROUGH).image.max() > 3 * made.max()


def mirrored(light, **material):
    """The light of the mirror alone: what the base reflects differs between coats by 2.7 %."""
    made, diffuse = (
        picture(light, **material | look).image for look in ({}, {"specular": (0, 0, 0)})
    )
    assert made.mean() > 1.03 * diffuse.mean()
    return float(made.mean(dtype=float) - diffuse.mean(dtype=float))


@pytest.mark.parametrize("light, tolerance", [("globe", 0.02), ("sky", 0.003)])
def test_a_light_with_an_extent_shows(light, tolerance):
    """As much as in microfacets of the same roughness, within four deviations over seeds."""
    made = mirrored(light)
    assert made == pytest.approx(mirrored(light, coat=CoatKind.ROUGH), rel=tolerance)
    # Power: a mirror of another index
    assert made != pytest.approx(mirrored(light, coat=CoatKind.ROUGH, eta=1.55), rel=tolerance)


def test_shared_directions_of_a_sky_show_too():
    shared = vc.Direct(environment="shared", n_environment=1024)
    made = picture("sky", shared, roughness=0.2).image.mean()
    assert made > 1.03 * picture("sky", shared, specular=(0, 0, 0)).image.mean()


def test_frames_of_bidirectional_paths_say_that_they_show_such_lights():
    paths = vc.Bdpt(max_depth=2)
    made = picture("point", paths)
    assert made.image.max() > 3 * picture("point").image.max()
    assert [w for w in made.warnings if "smooth coats" in w]
    for frame in (
        picture("point"),
        picture("globe", paths),
        picture("point", paths, coat=CoatKind.ROUGH),
    ):
        assert not [w for w in frame.warnings if "smooth coats" in w]
