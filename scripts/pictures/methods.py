"""Pictures at the head of pages on methods, lights and passes: how each works, step by step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.patches import Rectangle

import viscache as vc
from viscache.base import tonemap
from viscache.correlation import plots as correlation_plots
from viscache.plots.drawing import new_figure
from viscache.scene.cameras import find_camera
from viscache.vlf.tiles import walk_tiles
from viscache_lab.experiment.drawing import draw_image, draw_records, project
from viscache_lab.figures.aqvc_clusters import Cells, EyeSamples, eye_samples, false_colors
from viscache_lab.figures.aqvc_runs import Shot

#: Tiles along the edge of the part that is shown larger.
ZOOM = 12.0
FREE, BLOCKED, BELOW = (0.62, 0.80, 0.96), (0.25, 0.22, 0.20), (1.0, 1.0, 1.0)

Floats = npt.NDArray[np.floating[Any]]


def aqvc() -> Any:
    """The room, and its eye samples by cell, for three C_E."""
    shot = Shot(
        scene=vc.scenes.room(triangles=20_000),
        integrator=vc.Whitted(n_vpls=64),
        size=(360, 225),
    )
    samples: EyeSamples = eye_samples(shot)
    image = shot.frame().image
    light = tonemap.srgb_curve(image * tonemap.auto_exposure(image, 95.0)).mean(axis=2)
    figure = new_figure(9.0, 6.1)
    panels = figure.subplots(2, 2).ravel()
    draw_image(panels[0], image, "the room")
    for axes, c_e in zip(panels[1:], (64, 16, 6), strict=True):
        keys = samples.keys(vc.Aqvc(c_e=c_e))
        colors = false_colors(samples, keys, light.shape)
        axes.imshow(colors * (0.4 + 0.6 * light[:, :, None]))
        count = len(Cells(keys).count)
        axes.set_title(rf"$C_E$ = {c_e}: {count:,} cells", fontsize=9)
        axes.set_axis_off()
    return figure


def vismap() -> Any:
    """Records on a picture; the exact sky at one of them, its map, and the blend there."""
    scene, size = vc.scenes.build("courtyard?triangles=20000"), (360, 270)
    cache = vc.VisibilityMapCache(scene, vc.MapSettings())
    cache.update(size=size)
    records, view = cache.records(), find_camera(scene, 0)
    image = vc.render(scene, vc.Direct(n_environment=64), size=size).image
    ground = np.flatnonzero(records.normals[:, 1] > 0.99)
    place = project(view, size, records.positions[ground])
    chosen = ground[np.nanargmin(np.hypot(*(place - [0.55 * size[0], 0.8 * size[1]]).T))]
    position, normal = records.positions[chosen], records.normals[chosen]
    directions, inside = dome(normal, 240)
    cells = cache.cells(directions[inside])
    bits = records.bits[chosen][cells // 64] >> (cells % 64).astype(np.uint64) & np.uint64(1)
    start = np.broadcast_to(position + 1e-3 * normal, directions[inside].shape)
    exact = ~scene.occluded(start, directions[inside])
    found = cache.lookup(position[None], normal[None])
    blend = cache.visibility(found, directions[inside])[0]
    figure = new_figure(11.0, 3.2)
    first, *domes = figure.subplots(1, 4, width_ratios=(1.33, 1, 1, 1))
    draw_records(first, image, view, records.positions, f"{len(records.positions):,} records")
    at = project(view, size, position[None])[0]
    first.plot(*at, "o", ms=11, mfc="none", mec="yellow", mew=2)
    edge = 1 << cache.settings.m
    said = (exact, bits, blend)
    titles = (
        "exact: the sky from the ring",
        f"its record: {edge} × {edge} bits",
        "blended: Ṽ(x, ω)",
    )
    for axes, values, title in zip(domes, said, titles, strict=True):
        shown = np.full((*inside.shape, 3), BELOW)
        share = np.asarray(values, float)[:, None]
        shown[inside] = share * FREE + (1 - share) * np.array(BLOCKED)
        axes.imshow(shown)
        axes.set_title(title, fontsize=9)
        axes.set_axis_off()
    return figure


def dome(normal: Floats, n: int) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(n, n, 3) directions of an equal-area picture of the hemisphere, and where it is."""
    x, y = np.meshgrid(*[(np.arange(n) + 0.5) * 2 / n - 1] * 2)
    r2 = x * x + y * y
    inside = r2 < 0.999
    stretch, height = np.sqrt(np.maximum(2 - r2, 0)), 1 - r2
    side = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    axes = np.stack([side, np.cross(normal, side), normal])
    directions = np.stack([x * stretch, y * stretch, height], axis=-1) @ axes
    return directions / np.linalg.norm(directions, axis=2, keepdims=True), inside


def vlf() -> Any:
    """The axes; the tiles along one of them; the few tiles that a ray crosses."""
    scene, axes, n = vc.scenes.room(triangles=20_000), 129, 64
    field = vc.VisibilityField(scene, settings=vc.Vlf(n_directions=axes, n_tiles=n, lazy=True))
    low, high = scene.bounds.astype(float)
    ends = low + np.array([[0.15, 0.75, 0.2], [0.8, 0.2, 0.7]]) * (high - low)
    ray = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    nearest = int(vc.vlf.nearest_direction(ray[None], axes)[0])
    entries = field.tile_entries(nearest)
    frame = vc.vlf.direction_frames(axes)[nearest].astype(float)
    ball = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    seen = in_tiles(vc.correlation.surface_points(scene, 4000).positions, ball, frame, n)
    assert (entries[tuple(seen[:, 1::-1].astype(int).T)] > 0).all(), "surfaces lie in empty tiles"
    start, end = ((p - ball[0]) / ball[1] @ frame.T for p in ends)
    crossed, _ = walk_tiles(start.tolist(), (end - start).tolist(), n, 0.0, 1.0)

    figure = new_figure(11.0, 3.9)
    first, second, third = figure.subplots(1, 3)
    draw_axes(first, vc.vlf.directions(axes), nearest, ray)
    for panel in (second, third):
        panel.imshow(np.log1p(entries), cmap="Greys", origin="lower", extent=(0, n, 0, n))
        panel.set(xticks=[], yticks=[])
    path = in_tiles(ends, ball, frame, n)[:, :2]
    for tile in crossed:
        third.add_patch(Rectangle(tuple(tile), 1, 1, fc="tab:orange", alpha=0.6, lw=0))
    for panel in (second, third):
        panel.plot(*path.T, "-o", c="tab:blue", ms=4, lw=1.5)
    corner = path.mean(axis=0) - ZOOM / 2
    third.set(xlim=corner[0] + np.array([0, ZOOM]), ylim=corner[1] + np.array([0, ZOOM]))
    second.add_patch(Rectangle(tuple(corner), ZOOM, ZOOM, fill=False, ec="tab:orange", lw=1.5))
    listed = sum(int(entries[y, x]) for x, y in crossed)
    first.set_title(rf"$l$ = {axes} axes", fontsize=9)
    second.set_title(rf"$n$ × $n$ = {n} × {n} tiles of the nearest axis", fontsize=9)
    third.set_title(f"the ray crosses {len(crossed)} tiles: {listed} entries", fontsize=9)
    return figure


def in_tiles(points: Floats, ball: tuple[Floats, float], frame: Floats, n: int) -> Floats:
    """(N, 3) points in the axes of a field's direction, in tiles."""
    return ((points - ball[0]) / ball[1] @ frame.T + 1) * n / 2


def draw_axes(panel: Any, axes: Floats, nearest: int, ray: Floats) -> None:
    """The half sphere of axes from above, equal areas, with the axis that a ray takes."""
    both = np.concatenate([axes, ray[None]])
    up = both * np.where(both[:, 1:2] < 0, -1, 1)
    flat = up[:, [0, 2]] / np.sqrt(1 + up[:, 1:2])
    panel.scatter(*flat[:-1].T, s=7, c="0.6", lw=0)
    panel.scatter(*flat[nearest], s=45, c="tab:orange", lw=0, label="nearest axis")
    panel.plot(*flat[-1], "x", c="tab:blue", ms=7, mew=2, label="the ray")
    panel.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2, frameon=False)
    panel.set(aspect="equal", xlim=(-1.05, 1.05), ylim=(-1.05, 1.05))
    panel.set_axis_off()


def correlation() -> Any:
    """The mean correlation over distance and angle, and of each point with its surroundings."""
    scene = vc.scenes.build("mushrooms?triangles=20000")
    data = vc.correlation.measure(scene, n_points=12_000, map_size=32)
    size = (data.attrs["width"], data.attrs["height"])
    image = vc.render(scene, vc.Direct(n_environment=64), size=size).image
    figure = new_figure(11.0, 3.4)
    picture, map_, table = figure.subplots(1, 3)
    draw_image(picture, image, "the scene")
    colors = correlation_plots.draw_map(map_, data)
    map_.set_title("mean ρ of a point with its surroundings", fontsize=9)
    correlation_plots.draw_table(table, data)
    table.set_title("ρ̄(d, θ) of all pairs", fontsize=9)
    figure.colorbar(colors, ax=table, label="ρ")
    return figure


def passes() -> Any:
    """Exact, plain and corrected passes over 1, 4 and 16 passes, as error per pixel."""
    scene, lights = vc.scenes.room(triangles=20_000), vc.Whitted(n_vpls=256)
    cache = vc.Aqvc(c_e=10)
    kinds = {
        "exact": {"visibility": vc.Exact()},
        "the cache alone": {"visibility": cache, "use": "replace"},
        "corrected": {"visibility": cache, "use": "correct"},
    }
    size, counts = (160, 100), (1, 4, 16)
    truth = vc.Progressive(scene, lights, visibility=vc.Exact(), size=size).passes(96)
    figure = new_figure(9.0, 6.2)
    panels = figure.subplots(3, 3)
    for row, (name, kind) in zip(panels, kinds.items(), strict=True):
        shown = vc.Progressive(scene, lights, size=size, **kind)
        for axes, before, count in zip(row, (0, *counts), counts, strict=False):
            frame = shown.passes(count - before)
            error = np.abs(frame.image - truth.image).mean(axis=2) / truth.image.mean()
            axes.imshow(error, cmap="magma", vmin=0, vmax=0.3)
            plural = "es" if count > 1 else ""
            rays = frame.counters["rays"] / 1e6
            axes.set_title(
                f"{name}, {count} pass{plural}: {100 * error.mean():.1f} %, {rays:.1f} M rays",
                fontsize=8,
            )
            axes.set_axis_off()
    return figure


def lights() -> Any:
    """Light of the formats' spot lights over the angle, and mushrooms under clear skies."""
    figure = new_figure(11.0, 2.6)
    first, *skies = figure.subplots(1, 4)
    inner, outer = 15.0, 40.0
    plain = under_a_lamp({})
    # Places on the floor from edge to edge; the lamp is 1 above its middle
    across = (np.arange(len(plain)) + 0.5) / len(plain) * 2 - 1
    kinds = {"Mitsuba": "angle", "pbrt-v3": "quartic", "pbrt-v4": "smooth", "glTF": "quadratic"}
    for name, falloff in kinds.items():
        lit = under_a_lamp({"axis": (0, -1, 0), "cone_deg": (inner, outer), "falloff": falloff})
        first.plot(np.degrees(np.arctan(across)), lit / plain, label=name)
    first.set(xlim=(0, 45), xticks=(0, inner, outer), yticks=(0, 1))
    first.set_xlabel("degrees from the axis", fontsize=8)
    first.set_title("spot lights, as a floor shows them", fontsize=9)
    first.legend(fontsize=8)
    for axes, elevation in zip(skies, (5, 30, 70), strict=True):
        angle = np.radians(elevation)
        sky = vc.Sky(sun_direction=(0.8 * np.cos(angle), np.sin(angle), 0.6 * np.cos(angle)))
        scene = vc.scenes.mushrooms(triangles=20_000).with_environment(sky)
        frame = vc.render(scene, vc.Direct(n_environment=16), size=(200, 150), spp=4)
        draw_image(axes, frame.image, f"a clear sky, the sun at {elevation}°")
    return figure


def under_a_lamp(cone: dict[str, Any]) -> Floats:
    """A line of pixels across a floor of 2 × 2 under a lamp 1 above it."""
    d = vc.SceneDescription()
    corners = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]
    d.add_mesh(corners, [(0, 1, 2), (0, 2, 3)], material=d.add_material(base_color=(0.8,) * 3))
    d.add_point_light((0, 1, 0), (1, 1, 1), **cone)
    d.add_camera((0, 5, 0), (0, 0, 0), up=(0, 0, 1), fov_deg=40, view_height=2.0)
    frame = vc.render(vc.Scene.from_description(d), vc.Direct(), size=(201, 201), spp=4)
    return np.asarray(frame.image[100, :, 0], float)


def ambient() -> Any:
    """Directions of each point's own, and those that all points share."""
    scene, size = vc.scenes.courtyard(triangles=20_000), (240, 150)
    kinds = {
        "64 directions of each point's own": vc.AmbientOcclusion(n_samples=64),
        "129 directions that all points share": vc.AmbientOcclusion(
            n_samples=129, directions="shared"
        ),
        "1024 of each point's own": vc.AmbientOcclusion(n_samples=1024),
    }
    figure = new_figure(11.0, 2.6)
    for axes, (title, kind) in zip(figure.subplots(1, 3), kinds.items(), strict=True):
        draw_image(axes, vc.render(scene, kind, size=size, spp=4).image, title, exposure=0.8)
    return figure


def environment() -> Any:
    """A room with a window at equal samples, from the light's product and guided by maps."""
    sky = np.full((32, 64, 3), 0.3)
    sky[6:8, 10:13] = 300.0
    scene, size = vc.scenes.window_room().with_environment(sky), (200, 150)
    samples = vc.Direct(n_environment=16, environment="product")
    truth = vc.render(scene, samples, size=size, spp=64, visibility=vc.VisMaps()).image
    figure = new_figure(9.0, 2.7)
    panels = figure.subplots(1, 3)
    draw_image(panels[0], truth, "1024 samples, guided by maps", exposure=exposure_of(truth))
    for axes, (name, visibility) in zip(
        panels[1:],
        {"light × reflection": vc.Exact(), "guided by maps": vc.VisMaps()}.items(),
        strict=True,
    ):
        image = vc.render(scene, samples, size=size, visibility=visibility).image
        draw_image(axes, image, f"16 samples, {name}", exposure=exposure_of(truth))
    return figure


def exposure_of(image: Floats) -> float:
    """One exposure for pictures that are compared."""
    return float(tonemap.auto_exposure(image, 95.0))


def unbiased() -> Any:
    """Light behind slits, the mean of frames: exact, by the cache, corrected."""
    scene, lights = vc.scenes.slits(), vc.Whitted(n_vpls=64)
    cache, size, seeds = vc.Aqvc(c_e=16, exact_groups=()), (160, 100), range(16)
    kinds: dict[str, dict[str, Any]] = {
        "the cache alone": {"visibility": cache},
        "corrected": {"visibility": cache, "use": vc.Correct(share=0.25)},
    }
    exact = mean_image(scene, lights, size, seeds, {})
    figure = new_figure(9.0, 2.4)
    panels = figure.subplots(1, 3)
    draw_image(panels[0], exact, "exact", exposure=exposure_of(exact))
    unit = exact.mean()
    for axes, (name, kind) in zip(panels[1:], kinds.items(), strict=True):
        image = mean_image(scene, lights, size, seeds, kind)
        difference = (image - exact).mean(axis=2) / unit
        axes.imshow(difference, cmap="RdBu", vmin=-1, vmax=1)
        energy = 100 * (image.sum() / exact.sum() - 1)
        axes.set_title(f"{name}: energy {energy:+.1f} %", fontsize=9)
        axes.set_axis_off()
    return figure


def mean_image(
    scene: vc.Scene, lights: Any, size: tuple[int, int], seeds: range, kind: dict[str, Any]
) -> Floats:
    """The mean of frames of some seeds."""
    images = [vc.render(scene, lights, size=size, seed=s, **kind).image for s in seeds]
    return np.asarray(np.mean(images, axis=0), float)


def temporal() -> Any:
    """Rays of the frames of a moving camera, with a table of each frame's own and one kept."""
    scene, cache, size = vc.scenes.stairs(), vc.Aqvc(c_e=8, exact_groups=()), (160, 100)
    views = [vc.look_at((4.0 + 0.05 * k, 2.5, 5.0), (0.0, 0.5, 0.0)) for k in range(12)]
    table = vc.AqvcTable(table_bytes=16 << 20)
    lights = vc.Direct()
    kinds: dict[str, dict[str, Any]] = {"dropped": {}, "kept": {"keep": table}}
    figure = new_figure(9.0, 2.5)
    plot, *pictures = figure.subplots(1, 3)
    exact = vc.render(scene, lights, size=size, camera=views[-1]).image
    for axes, (name, kind) in zip(pictures, kinds.items(), strict=True):
        frames = [
            vc.render(scene, lights, camera=v, size=size, visibility=cache, **kind) for v in views
        ]
        plot.plot([f.counters["rays"] for f in frames], "o-", ms=3, label=f"table {name}")
        error = np.abs(frames[-1].image - exact).mean(axis=2) / exact.mean()
        axes.imshow(error, cmap="magma", vmin=0, vmax=1)
        axes.set_title(
            f"error of frame {len(views)}, {name}: {100 * error.mean():.2f} %", fontsize=9
        )
        axes.set_axis_off()
    plot.set(ylim=(0, None), xticks=(0, 4, 8))
    plot.set_title("rays over frames", fontsize=9)
    plot.legend(fontsize=8)
    return figure


PICTURES: dict[str, Callable[[], Any]] = {
    "how-aqvc": aqvc,
    "how-vlf": vlf,
    "how-vismap": vismap,
    "how-correlation": correlation,
    "how-passes": passes,
    "how-lights": lights,
    "how-ambient": ambient,
    "how-environment": environment,
    "how-unbiased": unbiased,
    "how-temporal": temporal,
}
