"""Whole frames with the quantized cache: the properties that AQVC promises."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from render import bdpt_scenes
from render import quantized as q

DIRECT = vc.Direct()
LARGE = (160, 100)


@cache
def every_light():
    return bdpt_scenes.LIGHTS.to_viscache()


def errors(scene, c_e_list, grids, integrator=DIRECT, size=q.SIZE, **options):
    """rel_l1 of every C_E (rows) and grid seed (columns)."""
    exact = q.exact(scene, integrator, size).image

    def error(c_e, seed):
        given = {"size": size, "c_e": c_e, "grid_seed": seed, **options}
        return q.rel_l1(q.render(scene, integrator, **given).image, exact)

    return np.array([[error(c_e, seed) for seed in range(grids)] for c_e in c_e_list])


def energies(scene, grids=32, size=LARGE, **options):
    """Relative energy error of every grid seed."""
    exact = q.exact(scene, DIRECT, size).image
    frames = (q.render(scene, DIRECT, size=size, grid_seed=s, **options) for s in range(grids))
    return np.array([q.energy(frame.image, exact) for frame in frames])


def z_of_mean(values):
    """Mean over its standard error; 0 where all values are 0."""
    error = np.std(values, ddof=1) / np.sqrt(len(values))
    return float(np.mean(values) / max(error, 1e-12))


SHARED_GROUPS = ("point", "directional", "vpl")
PATH_GROUPS = ("point", "area", "environment", "connection", "camera")
TILES, SMALL = {"form": "pairs", "storage": "paper_tiles"}, {"table_bytes": 16 << 20}
PATHS = {c: vc.Bdpt(max_depth=4, camera_connections=c) for c in ("bypass", "keyed")}
#: Integrator, the groups that it must light, C_E, and settings of the cache.
LIMIT = {
    name: (q.SHARED, SHARED_GROUPS, 1e-3, given)
    for name, given in (
        q.FORMS | {f"tables of {n} threads": TILES | {"threads": n} for n in (1, 3)}
    ).items()
} | {
    f"{camera} paths, {storage}": (paths, PATH_GROUPS, 1e-4, SMALL | {"storage": storage})
    for camera, paths in PATHS.items()
    for storage in ("table", "exact", "shared")
}


@pytest.mark.parametrize("name", LIMIT)
def test_tiny_clusters_give_the_exact_image_with_one_ray_per_query(name):
    """All kinds of light, mirrors of the key included, bit for bit."""
    integrator, lit, c_e, given = LIMIT[name]
    scene = q.lit_box() if integrator is q.SHARED else every_light()
    exact = q.exact(scene, integrator)
    frame = q.render(scene, integrator, c_e=c_e, **given)
    for layer, pixels in exact.layers.items():
        np.testing.assert_array_equal(frame.layers[layer], pixels, err_msg=layer)
    for group in lit:
        counts, want = (f.counters["groups"][group] for f in (frame, exact))
        assert exact.layers[group].max() > 0 and want["occluded"] > 0
        assert counts["rays"] == counts["queries"] == want["queries"]
        assert counts["occluded"] == want["occluded"]
    assert frame.counters["ray_reduction"] == 1
    assert q.render(scene, integrator, **given | {"c_e": 4}).sha256 != exact.sha256


@pytest.mark.parametrize("form", q.FORMS)
def test_refinement_adds_levels_and_at_most_one_ray_per_query(form):
    """Level 0 traces what it traces without refinement."""
    options = {"c_e": 16, **q.FORMS[form]} | ({"batch": 1} if form != "waves" else {})
    plain = q.render(q.lit_box(), refinement="off", **options).counters
    refined = q.render(q.lit_box(), c_finest="log2", level_step=2, **options).counters
    assert len(plain["rays_per_level"]) == 1 and len(refined["rays_per_level"]) == 4
    # A lossy table may drop a key before its next query
    slack = 0.01 if form == "pairs-table" else 0
    assert refined["rays_per_level"][0] == pytest.approx(plain["rays_per_level"][0], rel=slack)
    for group in refined["groups"].values():
        assert group["rays"] <= group["queries"]


#: Grids, size and C_E for which the mean energy has a standard error of half a percent at most.
ENOUGH = {
    "slats": {"grids": 32, "size": LARGE, "c_e": 8},
    "slits": {"grids": 400, "size": q.SIZE, "c_e": 4},
}


@pytest.mark.stat
@pytest.mark.parametrize("name", ENOUGH)
@pytest.mark.parametrize(
    "options", [{"form": "waves"}, {"form": "pairs", "order": "random"}], ids=["waves", "pairs"]
)
def test_shifted_grids_keep_the_energy_without_refinement(name, options):
    """Mean over grids, |bias| < 3σ; orders are drawn anew with the grid."""
    values = energies(q.scene(name), refinement="off", **ENOUGH[name], **options)
    assert abs(z_of_mean(values)) < 3
    # Power: an image 2 % too bright or too dark would be noticed
    assert abs(z_of_mean(values + 0.02)) > 3 and abs(z_of_mean(values - 0.02)) > 3


@pytest.mark.stat
def test_one_fixed_order_does_not_average_out_over_grids():
    """Control: the first pixels of a scanline represent every cluster, whatever the grid."""
    values = energies(
        q.scene("slits"), size=q.SIZE, c_e=8, refinement="off", form="pairs", order="scanline"
    )
    assert abs(z_of_mean(values)) > 5


@pytest.mark.stat
def test_waves_err_like_pairs():
    """Mean rel_l1 of four grids within 25 %; an eighth of the C_E is told apart."""
    for scene, integrator in ((q.lit_box(), q.SHARED), (q.scene("stairs"), DIRECT)):
        size = (128, 80)
        waves = errors(scene, (12,), 4, integrator, size, form="waves").mean()
        other, fine = errors(scene, (12, 1.5), 4, integrator, size, form="pairs").mean(axis=1)
        assert other == pytest.approx(waves, rel=0.25)
        assert fine != pytest.approx(waves, rel=0.25)
