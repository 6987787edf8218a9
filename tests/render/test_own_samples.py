"""Light samples per eye point in whole frames with the quantized cache."""

import pytest

import viscache as vc
from render import quantized as q

AMBIENT = vc.AmbientOcclusion(n_samples=16, max_distance=None)


def made(group):
    """A scene lit by one group, and what asks for it."""
    if group == "ambient":
        return q.scene("slats"), AMBIENT
    if group == "environment":
        sky = vc.Direct(n_area=0, n_environment=16, n_brdf=16)
        return q.scene("cube_on_plane").with_environment(1.0), sky
    return q.scene("cornell_box"), vc.Direct(n_area=24)


@pytest.mark.parametrize("group", ["area", "environment", "ambient"])
@pytest.mark.parametrize("refinement", ["off", "on"])
def test_rows_and_the_table_are_about_as_wrong_with_as_many_rays(group, refinement):
    """rel_l1 within 25 %, rays within 5 % (refined: 10 %), at equal parameters."""
    scene, integrator = made(group)
    options = {"c_e": 8, "refinement": refinement, "size": (160, 100)}
    exact = q.exact(scene, integrator, (160, 100)).layers[group]
    rows = q.render(scene, integrator, **options)
    table = q.render(scene, integrator, form="pairs", storage="exact", **options)
    errors = [q.rel_l1(f.layers[group], exact) for f in (rows, table)]
    assert errors[0] == pytest.approx(errors[1], rel=0.25) and errors[0] > 1e-3
    rays = [f.counters["groups"][group]["rays"] for f in (rows, table)]
    assert rays[0] == pytest.approx(rays[1], rel=0.05 if refinement == "off" else 0.1)
    queries = rows.counters["groups"][group]["queries"]
    assert queries == table.counters["groups"][group]["queries"] > 2 * rays[0]
    coarse = q.render(scene, integrator, **options | {"c_e": 24, "refinement": "off"})
    assert q.rel_l1(coarse.layers[group], exact) > 1.1 * errors[0]


def test_cells_of_light_sampling_alone_take_fewer_rays_and_err_more():
    """cell_density, where the BRDF is sampled beside the sky."""
    scene, sky = made("environment")
    exact = q.exact(scene, sky).layers["environment"]
    frames = {d: q.render(scene, sky, c_e=6, cell_density=d) for d in ("light", "mixture")}
    rays = {d: f.counters["rays"] for d, f in frames.items()}
    error = {d: q.rel_l1(f.layers["environment"], exact) for d, f in frames.items()}
    assert rays["light"] < 0.7 * rays["mixture"] and error["light"] > 1.2 * error["mixture"]
    # Without samples of the BRDF they are one
    alone = vc.Direct(n_area=0, n_environment=16, n_brdf=0)
    same = [q.render(scene, alone, c_e=6, cell_density=d) for d in ("light", "mixture")]
    assert same[0].sha256 == same[1].sha256


@pytest.mark.parametrize("group", ["area", "environment", "ambient"])
def test_finer_light_cells_lower_an_error_that_no_c_e_lowers(group):
    """c_l: to the exact frame's, through rows and the table alike."""
    scene, integrator = made(group)
    exact = q.exact(scene, integrator).layers[group]

    def error(**options):
        frame = q.render(scene, integrator, **options)
        return q.rel_l1(frame.layers[group], exact), frame.counters["groups"][group]["rays"]

    floor, few = error(c_e=0.05)
    found = [error(c_e=0.05, c_l=c_l) for c_l in (4, 0.3, 0.01)]
    errors, rays = zip(*found, strict=True)
    assert errors[0] > 1.3 * floor > 2 * errors[1] and errors[2] < 0.05 * floor
    assert rays[0] < few < rays[1] < rays[2]
    table, asked = error(c_e=0.05, c_l=0.3, form="pairs", storage="exact")
    assert table == pytest.approx(errors[1], rel=0.25)
    assert asked == pytest.approx(rays[1], rel=0.05)
