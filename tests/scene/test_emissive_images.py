"""Area lights whose radiance is an image: seen, sampled, chosen by each triangle's mean."""

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from render.ztest import compare

#: Dark but for two bright patches: light from the mean alone would fall elsewhere.
PATCHES = np.full((8, 8, 3), 5, np.uint8)
PATCHES[0:2, 0:3] = (255, 120, 30)
PATCHES[6:8, 5:8] = (60, 90, 255)
LINEAR = np.where(PATCHES / 255 <= 0.04045, PATCHES / 3294.6, (PATCHES / 255 + 0.055) / 1.055)
LINEAR = np.where(PATCHES / 255 <= 0.04045, LINEAR, LINEAR**2.4).astype(np.float32)


def lamp_scene(image, *, two_sided=False, instance=False, uvs=None):
    """A floor under a lamp of four triangles that shines down with an image."""
    d = vc.SceneDescription()
    d.add_material(base_color=(0.7, 0.7, 0.7))
    floor = [(-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)]
    d.add_mesh(floor, [(0, 1, 2), (0, 2, 3)])
    back = [(-2, 0, -1), (2, 0, -1), (2, 2, -1), (-2, 2, -1)]
    d.add_mesh(back, [(0, 1, 2), (0, 2, 3)])
    lamp = [(-0.6, 0.8, -0.5), (0.6, 0.8, -0.5), (0.6, 0.8, 0.7), (-0.6, 0.8, 0.7), (0, 0.8, 0.1)]
    own = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5)]
    mesh = d.add_mesh(
        lamp,
        [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
        uvs=own if uvs is None else uvs,
        emission=(6, 6, 6),
        emission_texture=-1 if image is None else d.add_image(image),
        emits_two_sided=two_sided,
        in_world=not instance,
    )
    if instance:
        to_world = np.eye(4)
        to_world[:3, 3] = (0.2, 0.1, 0.1)
        d.add_instance([mesh], to_world)
    d.add_camera((0.3, 1.6, 3.5), (0, 0.4, 0), fov_deg=50)
    return vc.Scene.from_description(d)


def images(scene, integrator, spp, seeds, first=0):
    made = [
        vc.render(scene, integrator, size=(24, 16), spp=spp, seed=first + i) for i in range(seeds)
    ]
    assert all(f.counters["non_finite"] == 0 for f in made)
    return np.stack([f.image for f in made]).astype(np.float64)


@pytest.mark.stat
@pytest.mark.parametrize(
    "kind",
    [
        "plain",
        pytest.param("two_sided", marks=pytest.mark.slow),
        pytest.param("instance", marks=pytest.mark.slow),
    ],
)
def test_bidirectional_paths_of_two_edges_are_direct_light(kind):
    scene = lamp_scene(LINEAR, two_sided=kind == "two_sided", instance=kind == "instance")
    direct = images(scene, vc.Direct(n_area=2), 192, 6, first=100)
    bdpt = images(scene, vc.Bdpt(max_depth=2), 128, 6)
    found = compare(bdpt, direct)
    assert found.same and abs(found.energy) < 0.015
    assert not compare(0.92 * bdpt, direct).same
    # Power: the image's mean everywhere gives another picture
    flat = lamp_scene(np.full_like(LINEAR, LINEAR.mean((0, 1))), two_sided=kind == "two_sided")
    assert not compare(images(flat, vc.Direct(n_area=64), 8, 6), direct).same


def test_a_constant_image_is_a_constant_lamp():
    ours = vc.render(lamp_scene(np.full((4, 4, 3), 0.5, np.float32)), vc.Direct(), size=(24, 16))
    d = lamp_scene(None)
    plain = vc.render(d, vc.Direct(), size=(24, 16))
    np.testing.assert_allclose(ours.image, 0.5 * plain.image, rtol=2e-5, atol=1e-7)


def test_the_camera_sees_the_image():
    view = vc.look_at((0, 0.05, 0.1), (0, 0.8, 0.1), up=(0, 0, -1), fov_deg=70)
    frame = vc.render(lamp_scene(LINEAR), vc.Direct(), size=(8, 8), spp=64, camera=view)
    seen = frame.layers["emitted"]
    # The patches fill opposite corners; between them it is dark
    red, blue = (np.unravel_index(np.argmax(seen[..., c]), (8, 8)) for c in (0, 2))
    assert seen[red][0] == pytest.approx(6, rel=0.05) and seen[blue][2] == pytest.approx(
        6, rel=0.05
    )
    assert abs(red[0] - blue[0]) >= 4 and abs(red[1] - blue[1]) >= 4
    assert np.median(seen) == pytest.approx(6 * LINEAR.min(), rel=0.05)


def test_repeated_images_and_dark_triangles_lose_no_light():
    half = np.zeros((2, 2, 3), np.float32)
    half[:, 0] = 1
    corner = [(0.24, 0.1), (0.26, 0.1), (0.26, 0.2), (0.24, 0.2), (0.25, 0.15)]
    bright = lamp_scene(half, uvs=corner)
    many = lamp_scene(half, uvs=np.array(corner) * 5000)
    light, repeated = (images(s, vc.Direct(n_area=32), 16, 2).mean() for s in (bright, many))
    assert repeated == pytest.approx(0.5 * light, rel=0.05)
    dark = lamp_scene(np.zeros((2, 2, 3), np.float32))
    assert np.all(vc.render(dark, vc.Direct(), size=(8, 8)).image == 0)


def test_descriptions_carry_the_image_and_check_it():
    plain, other = lamp_scene(LINEAR), lamp_scene(LINEAR[::-1].copy())
    assert plain.content_hash != other.content_hash != lamp_scene(None).content_hash
    assert plain.lights[0]["kind"] == "area" and plain.lights[0]["image"] == 0
    d = vc.SceneDescription()
    d.add_mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], emission_texture=0)
    with pytest.raises(vc.SceneError, match="emission_texture must be -1 or in"):
        vc.Scene.from_description(d)


def test_a_sphere_with_an_image_is_tessellated_and_says_so(tmp_path):
    imsave(tmp_path / "lamp.png", PATCHES, check_contrast=False)
    path = tmp_path / "scene.xml"
    image = '<texture type="bitmap" name="radiance"><string name="filename" value="lamp.png"/>'
    lamp = f'<emitter type="area">{image}</texture></emitter>'
    for shape, what in (("disk", []), ("sphere", ["is tessellated"])):
        path.write_text(f'<scene version="3.0.0">\n<shape type="{shape}">{lamp}</shape></scene>')
        warnings = [w for w in vc.load_scene(path).warnings if "scene.xml:2" in w]
        assert [part in w for part, w in zip(what, warnings, strict=True)] == [True] * len(what)
