"""`rays=` reaches every integrator, oracle and query; images are Embree's but for edges."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import viscache as vc

SIZE = (48, 32)
BSP = vc.Bsp()


def share_unlike(a: vc.Frame, b: vc.Frame) -> float:
    """Share of pixels that differ by more than 1 % of the brightest."""
    return float((np.abs(a.image - b.image).max(axis=-1) > 0.01 * b.image.max()).mean())


STACKS: list[tuple[Any, dict[str, Any]]] = [
    (vc.Direct(), {}),
    (vc.Whitted(n_vpls=32), {}),
    (vc.Bdpt(max_depth=4), {}),
    (vc.AmbientOcclusion(n_samples=16, max_distance=1.0), {}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Exact(order="by_pixel", engine="packets")}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Aqvc(c_e=8)}),
    (vc.Whitted(n_vpls=32), {"visibility": vc.Aqvc(preset="paper")}),
]


@pytest.mark.parametrize(("integrator", "options"), STACKS)
def test_every_stack_gives_embrees_image(integrator: Any, options: dict[str, Any]) -> None:
    scene = vc.scenes.room(triangles=5000, lights=6)
    frames = [vc.render(scene, integrator, rays=rays, size=SIZE, **options) for rays in (None, BSP)]
    assert frames[1].image.max() > 0
    assert share_unlike(frames[1], frames[0]) < 0.01
    assert frames[1].parameters["rays"]["name"] == "Bsp"


@pytest.mark.parametrize("use", ["replace", "correct"])
def test_records_of_visibility_maps_are_traced_by_the_same_caster(
    use: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = vc.scenes.build("courtyard?triangles=6000")
    frames = [
        vc.render(
            scene,
            vc.Direct(environment="product"),
            rays=rays,
            use=use,
            size=SIZE,
            visibility=vc.VisMaps(),
            env=(1, 1, 1),
        )
        for rays in (None, BSP)
    ]
    assert frames[1].counters["records"] > 0
    difference = np.abs(frames[1].image - frames[0].image).mean() / frames[0].image.mean()
    assert difference < 0.05

    def forbidden(*_: Any) -> None:
        raise AssertionError("Embree was asked")

    # The control: where Embree cannot be had, a frame by the BSP still comes out
    monkeypatch.setattr(vc.Embree, "build", forbidden)
    fresh = vc.scenes.build("courtyard?triangles=6000")
    alone = vc.render(
        fresh,
        vc.Direct(environment="product"),
        rays=BSP,
        use=use,
        size=SIZE,
        visibility=vc.VisMaps(),
        env=(1, 1, 1),
    )
    assert alone.sha256 == frames[1].sha256
    with pytest.raises(AssertionError, match="Embree was asked"):
        vc.render(fresh, vc.Direct(), size=SIZE)


def test_a_caster_is_built_once_and_the_last_one_kept() -> None:
    scene = vc.scenes.cube_on_plane()
    first = scene.caster(BSP)
    assert scene.caster(vc.Bsp()) is first
    assert scene.caster(vc.Bsp(max_depth=5)) is not first
    assert scene.caster(BSP) is not first
    assert scene.caster() is scene.caster(vc.Embree())
    with pytest.raises(ValueError, match=r"rays must be vc.Embree\(...\), vc.Bsp"):
        scene.caster(vc.Exact())  # type: ignore[call-overload]
    assert scene.caster("embree") is scene.caster()
