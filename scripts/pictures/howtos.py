"""Pictures at the head of the how-tos: what their own examples make."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.plots.drawing import new_figure
from viscache_lab.experiment.drawing import draw_image

Floats = npt.NDArray[np.floating[Any]]


def own_scene() -> Any:
    """A scene from a file, from arrays, and from a description with a lamp."""
    size = (200, 150)
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], float)
    quads = np.array([[0, 2, 1], [0, 3, 2]])
    view = vc.look_at((2.5, 2.6, 4.5), (0.0, 0.3, 0.0), fov_deg=38)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "wall.obj")
        path.write_text(
            "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -1 0 0\nv 1 0 0\nv 1 1 0\nv -1 1 0\n"
            "f 1 4 3 2\nf 5 6 7 8\n"
        )
        wall = vc.load_scene(path, env=1.0)
    floor, shelf = 4 * corners - [2, 0, 2], 1.6 * corners + [-0.8, 0.6, -0.8]
    shiny: Any = {"kind": "glossy", "base_color": (0.1, 0.1, 0.1), "roughness": 0.2}
    sky = vc.Sky(sun_direction=(0.4, 0.5, 0.6))
    meshes: list[Any] = [(floor, quads), (shelf, quads, shiny)]
    arrays = vc.Scene.from_arrays(meshes, env=sky)
    d = vc.SceneDescription()
    for color, mesh in (((0.6, 0.6, 0.6), floor), ((0.8, 0.3, 0.2), shelf)):
        d.add_mesh(mesh, quads.astype(np.uint32), material=d.add_material(base_color=color))
    d.add_point_light((0.5, 2.0, 0.3), (6.0, 6.0, 6.0))
    lamp = vc.Scene.from_description(d)
    scenes = {
        "a file, under a sky of one colour": wall,
        "arrays, under a clear sky": arrays,
        "a description with a lamp": lamp,
    }
    figure = new_figure(9.0, 2.5)
    for axes, (title, scene) in zip(figure.subplots(1, 3), scenes.items(), strict=True):
        light = vc.Direct(n_environment=16)
        draw_image(axes, vc.render(scene, light, camera=view, size=size, spp=16).image, title)
    return figure


def own_integrator() -> Any:
    """Irradiance of a floor without a camera: exact, by the cache, and their difference."""
    scene = vc.scenes.room(triangles=20_000)
    random = np.random.default_rng(2)
    low, high = scene.bounds
    lamps = vc.FarEnds.points(low + random.uniform(0.2, 0.8, (64, 3)) * (high - low))
    power = random.uniform(0.5, 2.0, 64)
    x, z = np.meshgrid(np.linspace(-4.9, 4.9, 200), np.linspace(-4.9, 4.9, 200))
    places = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    floor = vc.EyePoints(places, np.broadcast_to([0.0, 1.0, 0.0], places.shape))
    towards = lamps.positions - floor.positions[:, None]
    distance = np.linalg.norm(towards, axis=2)
    cosine = np.einsum("nmk,nk->nm", towards, floor.normals) / distance
    light = power * cosine.clip(0) / distance**2
    figure = new_figure(9.0, 3.2)
    panels = figure.subplots(1, 3)
    maps, rays = [], []
    for visibility in (vc.Exact(), vc.Aqvc(c_e=2)):
        answer = scene.oracle(visibility).block(floor, lamps, wanted=light > 0)
        maps.append((light * answer.visible).sum(axis=1).reshape(x.shape))
        rays.append(answer.counters["rays"] / 1e6)
    exact, cached = maps
    top = float(np.quantile(exact, 0.99))
    for axes, (name, values, million) in zip(
        panels[:2], zip(("exact", r"$C_E$ = 2"), maps, rays, strict=True), strict=True
    ):
        axes.imshow(values, cmap="inferno", vmin=0, vmax=top)
        axes.set_title(f"{name}: {million:.1f} M rays", fontsize=9)
    error = np.abs(cached - exact).sum() / exact.sum()
    panels[2].imshow(cached - exact, cmap="RdBu", vmin=-top / 4, vmax=top / 4)
    panels[2].set_title(f"difference × 4: error {100 * error:.1f} %", fontsize=9)
    for axes in panels:
        axes.set_axis_off()
    return figure


@dataclass(frozen=True)
class Grid:
    """The page's cache: one eye point asks for a whole cell of space."""

    cell: float = 0.25

    def block(self, eyes: Any, lamps: Any, wanted: Any) -> Any:
        facing = np.argmax(np.abs(eyes.normals), axis=1)
        key = np.column_stack([np.floor(eyes.positions / self.cell), facing])
        _, first, cell = np.unique(key, axis=0, return_index=True, return_inverse=True)
        cell = cell.ravel()
        asked = np.zeros((len(first), len(lamps)), dtype=bool)
        np.logical_or.at(asked, cell, wanted)
        return eyes[first].trace(lamps, asked)[cell]


def own_cache() -> Any:
    """A cache of twenty lines beside the quantized one: pictures of errors, error over rays."""
    scene, light, size = vc.scenes.room(triangles=5000), vc.Whitted(n_vpls=64), (192, 120)
    exact = vc.render(scene, light, size=size).image
    figure = new_figure(11.0, 2.6)
    first, *pictures, plot = figure.subplots(1, 4)
    draw_image(first, exact, "exact")
    ways: dict[str, tuple[list[Any], Any]] = {
        "Grid": ([Grid(c) for c in (0.1, 0.2, 0.4, 0.8)], Grid(0.4)),
        "Aqvc": ([vc.Aqvc(c_e=c) for c in (2, 4, 8, 16)], vc.Aqvc(c_e=4)),
    }
    for axes, (name, (settings, shown)) in zip(pictures, ways.items(), strict=True):
        found = []
        for setting in settings:
            frame = vc.render(scene, light, visibility=setting, size=size)
            error = np.abs(frame.image - exact).sum() / exact.sum()
            found.append((frame.counters["rays"] / frame.counters["queries"], 100 * error))
            if setting == shown:
                relative = np.abs(frame.image - exact).mean(axis=2) / exact.mean()
                axes.imshow(relative, cmap="magma", vmin=0, vmax=0.5)
                text = f"{name}: {found[-1][0]:.2f} rays per query, {found[-1][1]:.1f} %"
                axes.set_title(text, fontsize=9)
                axes.set_axis_off()
        plot.plot(*np.transpose(found), "o-", ms=4, label=name)
    plot.set_xlabel("rays per query", fontsize=8)
    plot.set_title("error in %", fontsize=9)
    plot.set(xlim=(0, None), ylim=(0, None))
    plot.legend(fontsize=8)
    return figure


def sweep() -> Any:
    """The error over every two of three parameters, as `vc.plots.pairs` draws it."""
    points = vc.designs.latin_hypercube(
        {"c_e": {"log": [2, 32]}, "c_n": [2, 4, 8], "c_z": {"linear": [1, 8]}}, 60
    )
    with tempfile.TemporaryDirectory() as folder:
        table = vc.sweep(
            "room?triangles=5000",
            "direct",
            over=points,
            size=(96, 60),
            metrics=["rel_l1"],
            directory=folder,
        )
        return vc.plots.pairs(table)


def cluster() -> Any:
    """A frame whose tiles arrive from the workers of an executor."""
    shown: dict[int, Any] = {}

    def show(frame: vc.Frame, finished: int, parts: int) -> None:
        if finished in (2, 7, parts):
            shown[finished] = frame.image

    with ThreadPoolExecutor(2) as executor:
        scene, light, size = "room?triangles=5000", vc.Whitted(n_vpls=64), (1024, 640)
        given: dict[str, Any] = {"size": size, "visibility": vc.Aqvc(c_e=4)}
        frame = vc.tiles.render(scene, light, executor=executor, parts=15, show=show, **given)
    whole = vc.render(vc.scenes.room(triangles=5000), light, **given)
    assert frame.sha256 == whole.sha256
    figure = new_figure(9.0, 2.2)
    exposure = tonemap.auto_exposure(whole.image)
    for axes, (finished, image) in zip(figure.subplots(1, 3), shown.items(), strict=True):
        text = "all parts: the bytes of one piece" if finished == 15 else f"{finished} of 15 parts"
        draw_image(axes, image[::2, ::2], text, exposure=exposure)
    return figure


def correlation() -> Any:
    """ρ̄(d, θ) of the page's courtyard; ρ̄ around each point; the variance records leave."""
    ds = vc.correlation.measure(
        "courtyard?triangles=5000",
        n_points=6000,
        map_size=32,
        d_edges=16,
        theta_edges_deg=18,
    )
    figure = new_figure(12.0, 2.7)
    table, local, left = figure.subplots(1, 3)
    mean = vc.correlation.plots.draw_table(table, ds)
    figure.colorbar(mean, ax=table, label=vc.correlation.plots.MEAN_LABEL)
    vc.correlation.plots.draw_map(local, ds)
    local.set_title(r"$\bar\rho$ of each point with those near it", fontsize=9)
    spacing = np.linspace(0.25, 8.0, 32)
    left.plot(spacing, vc.correlation.predicted_variance_ratio(ds, spacing))
    left.set(xlim=(0, 8), ylim=(0, None), xlabel="spacing of records [scene units]")
    left.set_title("share of variance left by a control variate", fontsize=9)
    return figure


PICTURES: dict[str, Callable[[], Any]] = {
    "how-own-scene": own_scene,
    "how-own-integrator": own_integrator,
    "how-own-cache": own_cache,
    "how-sweep": sweep,
    "how-cluster": cluster,
    "how-correlate": correlation,
}
