"""Area lights of opacity 0: they shine as a whole, throw no shadow and are not seen."""

import numpy as np
import pytest

import viscache as vc
from render.ztest import compare

QUAD = '"point3 P" [-1 0 -1 1 0 -1 1 0 1 -1 0 1] "integer indices" [0 1 2 0 2 3]'


VIEW = 'LookAt 0 .3 3.5  0 .9 0  0 1 0 Camera "perspective" "float fov" 55'


def written(folder, version, light, floor="diffuse", view=VIEW):
    """A floor and a square light 1.5 above it."""
    film, end = ("rgb", "") if version == 4 else ("image", "WorldEnd")
    if floor == "diffuse":
        floor = (
            '"diffuse" "rgb reflectance" [.6 .6 .6]'
            if version == 4
            else '"matte" "rgb Kd" [.6 .6 .6]'
        )
    path = folder / "scene.pbrt"
    path.write_text(f"""{view}
Film "{film}" "integer xresolution" 24 "integer yresolution" 24
WorldBegin
Material {floor}
AttributeBegin Scale 4 1 4 Shape "trianglemesh" {QUAD} AttributeEnd
AttributeBegin Translate 0 1.5 0 AreaLightSource "diffuse" "rgb L" [6 5 4] {light} AttributeEnd
{end}
""")
    return vc.load_scene(path, strict=True)


def pair(folder, version=4, **rest):
    mesh = f'Shape "trianglemesh" {QUAD}'
    return [
        written(folder, version, f"{mesh} {alpha}", **rest) for alpha in ('"float alpha" 0', "")
    ]


def means(scene, integrator=None, **rest):
    frame = vc.render(scene, integrator or vc.Direct(n_area=8), spp=16, **rest)
    return frame.image.astype(np.float64)


def is_lamp(scene):
    """Pixels in which the lamp is seen, with a margin of two."""
    wide = np.pad(means(scene).mean(2) > 3.5, 2)
    n = len(wide) - 4
    return np.any([wide[i : n + i, j : n + j] for i in range(5) for j in range(5)], 0)


@pytest.mark.parametrize("version", [3, 4])
def test_the_camera_sees_through_it(tmp_path, version):
    scene, visible = pair(tmp_path, version)
    lamp = is_lamp(visible)
    assert 5 < lamp.sum() < 350
    ours, theirs = means(scene), means(visible)
    # Behind it lies the sky, which is black, and the floor
    assert ours.max() < 3 < theirs.max()
    np.testing.assert_allclose(ours[~lamp], theirs[~lamp], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(
    "visibility",
    [vc.Aqvc(), vc.NeePlusPlus(), vc.ShadowMap(), vc.Unoccluded()],
    ids=lambda v: type(v).__name__,
)
def test_caches_see_no_shadow_of_it(tmp_path, visibility):
    scene = pair(tmp_path)[0]
    exact, cached = means(scene), means(scene, visibility=visibility)
    # Nothing stands between the floor and the light
    assert cached.sum() == pytest.approx(exact.sum(), rel=0.005)


@pytest.mark.parametrize("rays", [vc.Bsp(), vc.Vlf(n_directions=513), vc.Embree(watertight=True)])
def test_every_caster_sees_through_it(tmp_path, rays):
    scene = pair(tmp_path)[0]
    np.testing.assert_allclose(means(scene, rays=rays), means(scene), rtol=0.02, atol=0.02)


@pytest.mark.stat
@pytest.mark.parametrize(
    "floor", ["diffuse", '"conductor" "float roughness" .2 "bool remaproughness" false']
)
def test_bidirectional_paths_lose_no_light_of_it(tmp_path, floor):
    """Hits by chance never find it; the weights of the other strategies must not count on them."""
    scene, visible = pair(tmp_path, floor=floor)
    lamp = is_lamp(visible)

    def images(lit, integrator, spp, first=0):
        made = [vc.render(lit, integrator, spp=spp, seed=first + i).image for i in range(6)]
        return np.stack(made).astype(np.float64)[:, ~lamp][:, None]

    bdpt = images(scene, vc.Bdpt(max_depth=2), 96)
    for direct in (scene, visible):
        reference = images(direct, vc.Direct(n_area=4, n_brdf=2), 64, 50)
        found = compare(bdpt, reference)
        assert found.same and abs(found.energy) < 0.02
    # Power
    assert not compare(0.92 * bdpt, reference).same


def test_a_sphere_without_opacity_is_a_mesh_that_shines(tmp_path):
    ball = 'Shape "sphere" "float radius" .3'
    unseen, seen = (written(tmp_path, 4, f"{ball} {a}") for a in ('"float alpha" 0', ""))
    assert unseen.visible((0, 0.5, 0), (0, 2.5, 0))
    lamp = is_lamp(seen)
    ours, theirs = means(unseen)[~lamp].sum(), means(seen)[~lamp].sum()
    assert ours == pytest.approx(theirs, rel=0.02)


def test_holes_of_version_4_are_shares_and_those_of_a_light_are_warned_of(tmp_path):
    half = f'Shape "trianglemesh" {QUAD} "float alpha" .5'
    with pytest.raises(vc.SceneError, match=r"scene.pbrt:6: an area light with holes"):
        written(tmp_path, 4, half)
    # pbrt-v3 takes all but 0 for whole
    scene = written(tmp_path, 3, half)
    assert not scene.visible((0, 0.5, 0), (0, 2.5, 0))
