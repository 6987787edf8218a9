"""The error over light on surfaces: emitted light that the camera sees is left out."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core, metrics, report
from viscache.frame import Frame
from viscache.frame.emitted_light import light_on_surfaces, seen_emitters

SIZE = (48, 32)


def lit(mirror=False):
    """A floor under a lamp: in view, or only in view in a mirror."""
    d = vc.SceneDescription()
    grey, z = d.add_material(base_color=(0.5, 0.5, 0.5)), 3 if mirror else -1

    def add(*corners, **given):
        faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
        d.add_mesh(np.array(corners, float), faces, **{"material": grey, **given})

    add((-4, 0, -4), (-4, 0, 4), (4, 0, 4), (4, 0, -4))
    lamp = {"emission": (20, 20, 20), "emits_two_sided": True}
    add((-1, 1, z), (1, 1, z), (1, 2, z), (-1, 2, z), **lamp)
    add((-0.5, 0.3, 0), (0.5, 0.3, 0), (0.5, 0.3, 1), (-0.5, 0.3, 1))
    if mirror:
        glass = d.add_material(_core.MaterialKind.MIRROR)
        add((-4, 0, -2), (4, 0, -2), (4, 4, -2), (-4, 4, -2), material=glass)
    d.add_camera((0, 1.0, 2.5), (0, 0.8, 0), fov_deg=70)
    return vc.Scene.from_description(d)


def pair(scene):
    whitted = vc.Whitted(n_vpls=0, n_area=4)
    exact = vc.render(scene, whitted, size=SIZE)
    return vc.render(scene, whitted, visibility=vc.Aqvc(c_e=16, exact_groups=()), size=SIZE), exact


@pytest.mark.parametrize("mirror", [False, True])
def test_lamps_in_view_and_in_mirrors_are_left_out_of_both_sums(mirror):
    frame, exact = pair(lit(mirror))
    area = [np.asarray(f.layers["area"], float) for f in (frame, exact)]
    wanted = np.abs(area[0] - area[1]).sum() / area[1].sum()
    got = metrics.compare(frame, exact)
    assert got.rel_l1_reflected == pytest.approx(wanted, rel=1e-4)
    # The lamp is brighter than the floor: the paper's error is a fraction of it
    share = area[1].sum() / np.asarray(exact.image, float).sum()
    assert share < 0.9 and got.rel_l1 == pytest.approx(wanted * share, rel=1e-4)


def test_without_emitters_in_view_both_errors_are_the_same():
    scene, direct = vc.scenes.room(triangles=2000), vc.Direct()
    exact = vc.render(scene, direct, size=SIZE)
    frame = vc.render(scene, direct, visibility=vc.Aqvc(c_e=16), size=SIZE)
    got = metrics.compare(frame, exact, metrics=["rel_l1", "rel_l1_reflected"])
    assert got.rel_l1_reflected == got.rel_l1 > 0


def test_bidirectional_frames_tell_what_is_seen_from_what_paths_found():
    scene = lit()
    frame = vc.render(scene, vc.Bdpt(max_depth=4), size=SIZE, spp=8)
    direct = vc.render(scene, vc.Direct(), size=SIZE, spp=8)
    seen = seen_emitters(frame)
    np.testing.assert_allclose(seen, direct.layers["emitted"], rtol=1e-5, atol=1e-6)
    # Paths that hit the lamp by chance after the floor are light on surfaces
    found = np.asarray(frame.layers["emitted"], float) - seen
    assert found.min() > -1e-4 and found.sum() > 0
    surfaces = light_on_surfaces(frame)
    groups = sum(np.asarray(frame.layers[g], float) for g in frame.counters["groups"])
    np.testing.assert_allclose(surfaces, groups + found, rtol=1e-4, atol=1e-4)
    # A file from before the layer existed does not tell them apart
    old = {name: pixels for name, pixels in frame.layers.items() if name != "seen_emitters"}
    assert seen_emitters(Frame(layers=old)) is None


def test_a_picture_of_nothing_but_a_lamp_has_no_light_on_surfaces():
    shown = np.full((4, 4, 3), 5.0)
    lamp = Frame(layers={"color": shown, "emitted": shown})
    got = metrics.compare(lamp, lamp, metrics=["rel_l1", "rel_l1_reflected"])
    assert got.rel_l1 == 0 and got.rel_l1_reflected is None


@pytest.mark.usefixtures("without_netcdf")
def test_sweeps_have_it_by_default_and_reports_can_plot_it(tmp_path):
    given = {"visibility": vc.Aqvc(exact_groups=()), "over": {"c_e": [4, 16]}}
    table = vc.sweep(lit(), vc.Direct(n_area=4), size=SIZE, directory=tmp_path / "s", **given)
    ratio = (table.rel_l1_reflected / table.rel_l1).values.ravel()
    assert ratio == pytest.approx(np.full(2, ratio[0]), rel=1e-3) and ratio[0] > 1.1
    page = report.write(tmp_path / "s", error="rel_l1_reflected").read_text("utf-8")
    assert "rel_l1 of light on surfaces" in page.split('id="settings"')[0]
    files = vc.plots.save_all(table, tmp_path / "plots", "svg", error="rel_l1_reflected")
    assert "light on surfaces" in files[0].read_text("utf-8")
    with pytest.raises(ValueError, match="error must be one of the sweep's metrics"):
        report.write(tmp_path / "s", error="max_abs")
