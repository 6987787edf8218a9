"""Glossy sheets that light passes, and the tint of glass."""

import numpy as np
import pytest

import viscache as vc

VIEW = vc.look_at((0.1, 0.1, 3), (0.1, 0.1, 0), up=(0, 1, 0), fov_deg=25)
SKY = np.ones((4, 8, 3), np.float32)


def quad(d, material, z=0.0, size=1.0):
    corners = np.float32([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * size
    number = d.add_material(**material)
    corners[:, 2] = z
    return d.add_mesh(corners, np.uint32([[0, 1, 2], [0, 2, 3]]), material=number)


def sheet(base, passed, **more):
    """Without a lobe, unless it is given."""
    return {
        "kind": vc._core.MaterialKind.GLOSSY,
        "coat": vc._core.CoatKind.FRESNEL_MIX,
        "thin": True,
        "base_color": (base,) * 3,
        "transmission": (passed,) * 3,
        "specular": (0, 0, 0),
        "f90": 0,
    } | more


def mean(description, integrator, spp=64, env=SKY):
    scene = vc.Scene.from_description(description)
    scene = scene.with_environment(env) if env is not None else scene
    return vc.render(scene, integrator, camera=VIEW, size=(24, 24), spp=spp).image.mean((0, 1))


@pytest.mark.parametrize("integrator", [vc.Direct(), vc.Whitted(), vc.Bdpt(max_depth=4)])
@pytest.mark.parametrize("share", [0.3, 0.8])
@pytest.mark.stat
def test_a_sheet_that_keeps_all_light_is_invisible_in_a_furnace(integrator, share):
    d = vc.SceneDescription()
    quad(d, sheet(1 - share, share))
    assert mean(d, integrator) == pytest.approx(1, abs=0.01)


@pytest.mark.stat
def test_light_that_goes_between_two_sheets_is_neither_lost_nor_counted_twice():
    d = vc.SceneDescription()
    for z in (0, -0.3):
        quad(d, sheet(0.5, 0.5), z)
    assert mean(d, vc.Bdpt(max_depth=16)) == pytest.approx(1, abs=0.015)


@pytest.mark.parametrize("roughness", [0.05, 0.6])
@pytest.mark.stat
def test_no_sheet_gives_more_than_arrives_straight_on(roughness):
    d = vc.SceneDescription()
    lobe = {"specular": (0.04,) * 3, "f90": 1, "roughness": roughness}
    quad(d, sheet(0.3, 0.7, **lobe))
    assert 0.95 < mean(d, vc.Bdpt(max_depth=4))[0] < 1.01


@pytest.mark.parametrize(
    "integrator", [vc.Bdpt(max_depth=4), vc.Whitted(n_vpls=400)], ids=["bdpt", "vpls"]
)
def test_light_through_a_sheet_is_its_share(integrator):
    """A lamp behind the sheet lights a wall, which lights the floor that is seen."""

    def seen(passed):
        d = vc.SceneDescription()
        quad(d, {"base_color": (0.8,) * 3})
        wall = np.float32([(1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 1, 0)])
        d.add_mesh(wall, np.uint32([[0, 1, 2], [0, 2, 3]]), material=0)
        cover = np.float32([(-9, -9, 9), (9, -9, 9), (9, 9, 9), (-9, 9, 9)])
        d.add_mesh(
            cover,
            np.uint32([[0, 1, 2], [0, 2, 3]]),
            material=d.add_material(**sheet(0, passed)),
        )
        d.add_point_light((0, 0, 10), (50, 50, 50))
        return mean(d, integrator, spp=16, env=None)[0]

    whole = seen(1)
    assert whole > 0 and seen(0.25) == pytest.approx(0.25 * whole, rel=1e-4)


@pytest.mark.parametrize("thin", [False, True])
@pytest.mark.parametrize("integrator", [vc.Direct(), vc.Bdpt(max_depth=6)], ids=["direct", "bdpt"])
@pytest.mark.stat
def test_glass_tints_what_passes_and_not_what_it_mirrors(integrator, thin):
    """Index 1 mirrors nothing."""
    d = vc.SceneDescription()
    tint = np.array([1, 0.5, 0.1])
    glass = {"kind": vc._core.MaterialKind.DIELECTRIC, "eta": 1.0, "thin": thin}
    quad(d, glass | {"transmission": tuple(tint)})
    np.testing.assert_allclose(mean(d, integrator), tint, rtol=0.03)
