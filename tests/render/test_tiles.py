"""Tiles are small, so that many threads have work; they follow from the frame alone."""

from __future__ import annotations

import math
from typing import Any

import pytest

import viscache as vc

OWN_SKY = vc.Direct(n_area=0, n_environment=1, n_brdf=0)
SHARED_SKY = vc.Direct(n_area=0, environment="shared", n_environment=16)
FEW_DIRECTIONS = vc.Direct(n_area=0, environment="shared", n_environment=8)


@pytest.fixture(scope="module")
def scene() -> vc.Scene:
    return vc.scenes.build("cube_on_plane").with_environment(1.0)


def edge(scene: vc.Scene, size: tuple[int, int], spp: int = 1, **options: Any) -> int:
    frame = vc.render(scene, options.pop("integrator", OWN_SKY), size=size, spp=spp, **options)
    return int(frame.parameters["tile_edge_px"])


@pytest.mark.parametrize(
    ("size", "spp", "pixels"),
    [((512, 512), 1, 64), ((511, 448), 1, 32), ((192, 192), 1, 32), ((128, 128), 16, 16)],
)
def test_a_tile_has_64_squared_eye_samples_in_frames_of_64_tiles_or_more(
    scene: vc.Scene, size: tuple[int, int], spp: int, pixels: int
) -> None:
    assert edge(scene, size, spp) == pixels
    assert math.prod(math.ceil(n / pixels) for n in size) >= 36


def test_tiles_of_many_shared_directions_are_larger(scene: vc.Scene) -> None:
    """The aligned batch sorts triangles once for all points of a tile."""
    sizes = ((256, 256), (512, 512), (1024, 1024))
    assert [edge(scene, size, integrator=SHARED_SKY) for size in sizes] == [64, 128, 256]
    assert edge(scene, (512, 512), integrator=FEW_DIRECTIONS) == 64


def test_tiles_depend_on_no_oracle_and_no_threads(scene: vc.Scene) -> None:
    for visibility in ("exact", vc.Aqvc(exact_groups=()), vc.Exact(sky_engine="batch")):
        for threads in (1, 3):
            options = {"visibility": visibility, "threads": threads, "integrator": SHARED_SKY}
            assert edge(scene, (512, 512), **options) == 128
