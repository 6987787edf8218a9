"""Units of length: the same scene in other units gives the same image."""

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from viscache import _core

SIZE = (32, 32)


def in_units(exponent: int) -> vc.Scene:
    """The Cornell box, 2^exponent times as large; its light is radiance, which stays."""
    given, scaled = _core.description_of(vc.scenes.cornell_box()._core), vc.SceneDescription()
    for m in given.materials:
        scaled.add_material(m["kind"], base_color=m["base_color"], two_sided=m["two_sided"])
    for i, mesh in enumerate(given.meshes):
        arrays = given.mesh_arrays(i)
        scaled.add_mesh(
            arrays["vertices"] * np.float32(2.0**exponent),
            arrays["triangles"],
            material=mesh["material"],
            emission=mesh["emission"],
            emits_two_sided=mesh["emits_two_sided"],
        )
    camera = given.cameras[0]
    origin = np.array(camera["origin"]) * 2.0**exponent
    target = origin + np.array(camera["forward"]) * 2.0**exponent
    scaled.add_camera(
        tuple(origin), tuple(target), up=tuple(camera["up"]), fov_deg=camera["fov_deg"]
    )
    return vc.Scene.from_description(scaled)


def image(scene: vc.Scene, visibility: vc.Exact | vc.Aqvc) -> npt.NDArray[np.float32]:
    return vc.render(scene, vc.Whitted(n_vpls=64), visibility=visibility, size=SIZE).image


@pytest.mark.extreme
@pytest.mark.parametrize("exponent", [-18, -9, 13, 28])
def test_an_image_does_not_depend_on_the_unit_of_length(exponent: int) -> None:
    scene, reference = in_units(exponent), in_units(0)
    assert scene.warnings == []
    for visibility in (vc.Exact(), vc.Aqvc(c_e=6)):
        np.testing.assert_array_equal(image(scene, visibility), image(reference, visibility))


def test_a_scene_in_units_that_do_not_fit_says_so() -> None:
    for exponent in (-40, 36):
        assert "scale it" in " ".join(in_units(exponent).warnings)
