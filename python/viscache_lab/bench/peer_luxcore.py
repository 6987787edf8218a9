"""LuxCore in a separate process (see `peers`): direct light of a sky or of point lights."""

from __future__ import annotations

import importlib
import math
import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import Fields, Pictures, cores, from_below, quiet, serve, z_up


def main() -> None:
    """Answer with frames; `luxcore-cache` as the peer's name turns its visibility caches on."""
    # OpenMP's threads would spin between the parts of a cache's build, and that counts as CPU time
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    quiet(1, 2)  # LuxCore tells its progress to both outputs
    lux: Any = importlib.import_module("pyluxcore")
    lux.Init()
    picture = LuxCorePicture(lux, Path(sys.argv[1]), cached=sys.argv[2:] == ["luxcore-cache"])
    serve({"version": lux.Version()}, {"sky": picture.sky, "points": picture.points})


class LuxCorePicture(Pictures):
    """The scene of a folder, turned to LuxCore's z up.

    If cached, skies have a cache of what is visible of them, and lights are drawn from caches of
    their contributions. Their build is part of each frame's time.
    """

    def __init__(self, lux: Any, folder: Path, *, cached: bool) -> None:
        super().__init__(folder)
        self._lux, self._cached = lux, cached

    def sky(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """Direct light of `sky` (H, W, 3). A path samples the light once and the surface once."""
        # The second vertex ends a path: there the surface's sample finds the sky or nothing
        return self._frame(given, fields, int(fields["samples"]), depth=2)

    def points(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """Direct light of point lights. A path asks one: so there are as many paths per sample."""
        return self._frame(given, fields, len(given["lights"]), depth=1)

    def _frame(self, given: Fields, fields: Fields, paths: int, depth: int) -> dict[str, Any]:
        lux, side = self._lux, int(fields["side"])
        settings = self._properties(self._settings(fields, int(fields["spp"]) * paths, depth))
        session = lux.RenderSession(lux.RenderConfig(settings, self.scene(given, fields)))
        begin = _clocks()
        # Builds the tree of triangles, then the caches, every time
        session.Start()
        built = _clocks()
        while not session.HasDone():
            time.sleep(1e-3)
            # Here it counts its samples and ends
            session.UpdateStats()
        session.Stop()
        pixels = np.empty(side * side * 3, np.float32)
        session.GetFilm().GetOutputFloat(lux.FilmOutputType.RGB, pixels)
        wall_s, cpu_s = _clocks() - (begin if self._cached else built)
        made = {"image": from_below(pixels, side), "wall_s": wall_s, "cpu_s": cpu_s}
        return made | ({"build_cpu_s": (built - begin)[1]} if self._cached else {})

    def _settings(self, fields: Fields, spp: int, depth: int) -> dict[str, Any]:
        side = int(fields["side"])
        kinds = ("total", "diffuse", "glossy", "specular")
        return {
            "renderengine.type": "PATHCPU",
            "renderengine.seed": 1 + int(fields["seed"]),
            "native.threads.count": cores(),
            "sampler.type": "SOBOL",
            # As many samples in every pixel
            "sampler.sobol.adaptive.strength": 0.0,
            "lightstrategy.type": "DLS_CACHE" if self._cached and depth == 1 else "LOG_POWER",
            **{f"path.pathdepth.{kind}": depth for kind in kinds},
            "path.clamping.variance.maxvalue": 0.0,
            "film.width": side,
            "film.height": side,
            "film.filter.type": "NONE",
            "batch.haltspp": spp,
        }

    def build(self, given: Fields, fields: Fields) -> Any:
        """Camera, grey triangles, and the sky or the lights of the job."""
        scene = self._lux.Scene()
        vertices, triangles = (
            map(tuple, z_up(self.vertices).tolist()),
            map(tuple, self.triangles.tolist()),
        )
        scene.DefineMesh("all", list(vertices), list(triangles), None, None, None, None)
        origin, forward, _, up = z_up(np.asarray(given["camera"], np.float64)).tolist()
        # LuxCore's camera looks one row of pixels too high
        row = 2 / int(fields["side"])
        values = {
            "scene.camera.type": "perspective",
            "scene.camera.lookat.orig": origin,
            "scene.camera.lookat.target": (np.array(origin) + forward).tolist(),
            "scene.camera.up": up,
            "scene.camera.fieldofview": math.degrees(float(fields["fov_rad"])),
            "scene.camera.screenwindow": [-1.0, 1.0, -1.0 - row, 1.0 - row],
            "scene.materials.grey.type": "matte",
            "scene.materials.grey.kd": [float(fields["albedo"])] * 3,
            "scene.objects.all.shape": "all",
            "scene.objects.all.material": "grey",
        }
        lights = self._points(given, fields) if "intensity" in fields else self._sky(scene, given)
        scene.Parse(self._properties(values | lights))
        return scene

    def _sky(self, scene: Any, given: Fields) -> dict[str, Any]:
        sky = np.asarray(given["sky"], np.float32)
        rows, columns = sky.shape[:2]
        # Its longitude runs the other way, from a meridian that is a quarter turn from ours
        turned = np.ascontiguousarray(np.roll(sky[:, ::-1], columns // 4, axis=1))
        scene.DefineImageMap("sky", turned, 1.0, 3, columns, rows)
        values = {"type": "infinite", "file": "sky", "gamma": 1.0}
        values["visibilitymapcache.enable"] = self._cached
        return {f"scene.lights.sky.{name}": value for name, value in values.items()}

    def _points(self, given: Fields, fields: Fields) -> dict[str, Any]:
        flux = [4 * math.pi * float(fields["intensity"])] * 3
        places = z_up(np.asarray(given["lights"], np.float64)).tolist()
        return {
            f"scene.lights.light{i}.{name}": value
            for i, place in enumerate(places)
            for name, value in {"type": "point", "position": place, "gain": flux}.items()
        }

    def _properties(self, values: Mapping[str, Any]) -> Any:
        made = self._lux.Properties()
        for name, value in values.items():
            made.Set(self._lux.Property(name, value))
        return made


def _clocks() -> Any:
    """Seconds of the wall clock, and CPU seconds of all threads."""
    return np.array([time.perf_counter(), time.process_time()])


if __name__ == "__main__":
    main()
