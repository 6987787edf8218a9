"""`rays=` reaches every integrator, oracle and query; images are Embree's but for edges."""

import numpy as np
import pytest

import viscache as vc

SIZE = (48, 32)
BSP = vc.Bsp()


def share_unlike(a, b):
    """Share of pixels that differ by more than 1 % of the brightest."""
    return float((np.abs(a.image - b.image).max(axis=-1) > 0.01 * b.image.max()).mean())


STACKS = [
    (vc.Direct(), {}),
    (vc.Whitted(n_vpls=32), {}),
    (vc.Bdpt(max_depth=4), {}),
    (vc.AmbientOcclusion(n_samples=16, max_distance=1.0), {}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Exact(order="by_pixel", engine="packets")}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Aqvc(c_e=8)}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Aqvc(preset="paper")}),
]


@pytest.mark.parametrize(("integrator", "options"), STACKS)
def test_every_stack_gives_embrees_image(integrator, options):
    scene = vc.scenes.room(triangles=5000, lights=6)
    frames = [vc.render(scene, integrator, rays=rays, size=SIZE, **options) for rays in (None, BSP)]
    assert frames[1].image.max() > 0
    assert share_unlike(frames[1], frames[0]) < 0.01
    assert frames[1].parameters["rays"]["name"] == "Bsp"


@pytest.mark.parametrize("use", ["replace", "correct"])
def test_records_of_visibility_maps_are_traced_by_the_same_caster(use, monkeypatch):
    def rendered(scene, rays):
        given = {"use": use, "size": SIZE, "env": (1, 1, 1)}
        product = vc.Direct(environment="product")
        return vc.render(scene, product, rays=rays, visibility=vc.VisMaps(), **given)

    def forbidden(*_):
        raise AssertionError("Embree was asked")

    scene, fresh = (vc.scenes.build("courtyard?triangles=6000") for _ in range(2))
    embree, bsp = (rendered(scene, rays) for rays in (None, BSP))
    assert bsp.counters["records"] > 0
    assert np.abs(bsp.image - embree.image).mean() < 0.05 * embree.image.mean()
    # The control: where Embree cannot be had, a frame by the BSP still comes out
    monkeypatch.setattr(vc.Embree, "build", forbidden)
    assert rendered(fresh, BSP).sha256 == bsp.sha256
    with pytest.raises(AssertionError, match="Embree was asked"):
        vc.render(fresh, vc.Direct(), size=SIZE)
