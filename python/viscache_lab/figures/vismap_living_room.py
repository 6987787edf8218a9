"""A living room by another author under two measured skies, beside our stand-ins."""

from __future__ import annotations

from collections.abc import Iterator

import viscache as vc
from viscache.metrics.variance import variance_ratio
from viscache.scenes.sources import SCENES_VARIABLE, made_by_others
from viscache_lab.cases.map_renders import Picture, paper_maps
from viscache_lab.experiment import Row, Trial

SCENE = "living-room/scene.xml"
#: Measured outdoor skies, in the folder of scenes.
SKIES = {"noon": "hdr/kloppenheim_05_1k.hdr", "sunset": "hdr/venice_sunset_1k.hdr"}
SAMPLES, QUICK_SAMPLES = (10, 30), (10,)
RENDERS, SIZE = 8, (160, 120)
QUICK_RENDERS, QUICK_SIZE = 3, (32, 24)


def living_rooms(trial: Trial) -> Iterator[tuple[str, vc.Scene]]:
    """The room under every available sky; absent files are recorded in `outcome.skipped`."""
    room: vc.Scene | None = None
    for name, sky in SKIES.items():
        label = f"living-room, {name}"
        mesh, light = made_by_others(SCENE), made_by_others(sky)
        if mesh is None or light is None:
            absent = SCENE if mesh is None else sky
            trial.skip(label, f"{absent} is absent: set {SCENES_VARIABLE} to its folder")
            continue
        room = room or vc.load_scene(mesh)
        yield label, room.with_environment(light)


def variance_rows(label: str, scene: vc.Scene, quick: bool) -> Iterator[Row]:
    """Remaining variance of rendered pictures, with a cache built before."""
    renders = QUICK_RENDERS if quick else RENDERS
    picture = Picture(scene=scene, size=QUICK_SIZE if quick else SIZE)
    cache = picture.build_cache()
    ways = {"alpha one": paper_maps(cache), "default": vc.VisMaps(cache=cache, update=False)}
    for n in QUICK_SAMPLES if quick else SAMPLES:
        base = [picture.product(n, 100 + seed).image for seed in range(renders)]
        for name, maps in ways.items():
            left = variance_ratio([picture.maps(n, maps, s).image for s in range(renders)], base)
            yield Row(
                f"{label}, rendered, rqmc, {name}, {n} samples: variance left",
                left.ratio,
                note=f"{left.low:.3f} to {left.high:.3f}, trimmed {left.trimmed:.3f}; "
                f"z of the means {left.energy_z:.1f}; "
                f"{len(cache)} records",
            )
