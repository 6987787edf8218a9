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

from viscache_lab.bench.peer_protocol import serve


def main() -> None:
    """Answer with frames; `luxcore-cache` as the peer's name turns its visibility caches on."""
    # OpenMP's threads would spin between the parts of a cache's build, and that counts as CPU time
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    # LuxCore tells its progress to both outputs: our lines keep them, it gets none
    ours = [os.fdopen(os.dup(number), "w") for number in (1, 2)]
    for number in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), number)
    lux: Any = importlib.import_module("pyluxcore")
    sys.stdout, sys.stderr = ours
    lux.Init()
    picture = LuxCorePicture(lux, Path(sys.argv[1]), cached=sys.argv[2:] == ["luxcore-cache"])
    about = {"version": lux.Version(), "threads": picture.threads}
    serve(about, {"sky": picture.sky, "points": picture.points})


class LuxCorePicture:
    """The scene of a folder with y up, turned to LuxCore's z up.

    Parameters
    ----------
    lux : module
        pyluxcore.
    folder : Path
        Has `scene.npz`.
    cached : bool
        Skies have a cache of what is visible of them, and lights are drawn from caches of their
        contributions. Their build is part of each frame's time.
    """

    def __init__(self, lux: Any, folder: Path, *, cached: bool) -> None:
        self._lux, self._folder, self._cached = lux, folder, cached
        self._scene: Any = None
        self._camera: Any = None
        self.threads = len(os.sched_getaffinity(0))

    def sky(self, given: Mapping[str, Any], fields: Mapping[str, Any]) -> dict[str, Any]:
        """Direct light of `sky` (H, W, 3). A path samples the light once and the surface once."""
        if given["camera"] is not self._camera:
            sky = np.asarray(given["sky"], np.float32)
            rows, columns = sky.shape[:2]
            scene = self._new_scene(given, fields)
            # Its longitude runs the other way, from a meridian that is a quarter turn from ours
            turned = np.roll(sky[:, ::-1], columns // 4, axis=1)
            scene.DefineImageMap("sky", np.ascontiguousarray(turned), 1.0, 3, columns, rows)
            light = "scene.lights.sky"
            self._parse(
                scene,
                {
                    f"{light}.type": "infinite",
                    f"{light}.file": "sky",
                    f"{light}.gamma": 1.0,
                    f"{light}.visibilitymapcache.enable": self._cached,
                },
            )
            self._scene, self._camera = scene, given["camera"]
        # The second vertex ends a path: there the surface's sample finds the sky or nothing
        return self._frame(fields, int(fields["spp"]) * int(fields["samples"]), depth=2)

    def points(self, given: Mapping[str, Any], fields: Mapping[str, Any]) -> dict[str, Any]:
        """Direct light of point lights. A path asks one: so there are as many paths per sample."""
        lights = np.asarray(given["lights"], np.float64)
        if given["camera"] is not self._camera:
            scene = self._new_scene(given, fields)
            flux = [4 * math.pi * float(fields["intensity"])] * 3
            for i, place in enumerate(_turned(lights).tolist()):
                light = f"scene.lights.light{i}"
                self._parse(
                    scene,
                    {f"{light}.type": "point", f"{light}.position": place, f"{light}.gain": flux},
                )
            self._scene, self._camera = scene, given["camera"]
        return self._frame(fields, int(fields["spp"]) * len(lights), depth=1)

    def _frame(self, fields: Mapping[str, Any], spp: int, depth: int) -> dict[str, Any]:
        lux, side = self._lux, int(fields["side"])
        session = lux.RenderSession(
            lux.RenderConfig(self._properties(self._settings(fields, spp, depth)), self._scene)
        )
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
        end = _clocks()
        # Rows from the bottom up
        image = pixels.reshape(side, side, 3)[::-1].astype(np.float64)
        first = begin if self._cached else built
        made = {
            "image": image.mean(axis=2),
            "wall_s": end[0] - first[0],
            "cpu_s": end[1] - first[1],
        }
        return made | ({"build_cpu_s": built[1] - begin[1]} if self._cached else {})

    def _settings(self, fields: Mapping[str, Any], spp: int, depth: int) -> dict[str, Any]:
        side = int(fields["side"])
        kinds = ("total", "diffuse", "glossy", "specular")
        return {
            "renderengine.type": "PATHCPU",
            "renderengine.seed": 1 + int(fields["seed"]),
            "native.threads.count": self.threads,
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

    def _new_scene(self, given: Mapping[str, Any], fields: Mapping[str, Any]) -> Any:
        scene = self._lux.Scene()
        with np.load(self._folder / "scene.npz") as file:
            vertices, triangles = _turned(file["vertices"]), file["triangles"]
        scene.DefineMesh(
            "all",
            [tuple(v) for v in vertices.tolist()],
            [tuple(t) for t in triangles.tolist()],
            None,
            None,
            None,
            None,
        )
        origin, forward, _, up = _turned(np.asarray(given["camera"], np.float64)).tolist()
        # LuxCore's camera looks one row of pixels too high
        row = 2 / int(fields["side"])
        self._parse(
            scene,
            {
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
            },
        )
        return scene

    def _parse(self, scene: Any, values: Mapping[str, Any]) -> None:
        scene.Parse(self._properties(values))

    def _properties(self, values: Mapping[str, Any]) -> Any:
        made = self._lux.Properties()
        for name, value in values.items():
            made.Set(self._lux.Property(name, value))
        return made


def _clocks() -> tuple[float, float]:
    """Seconds of the wall clock, and CPU seconds of all threads."""
    return time.perf_counter(), time.process_time()


def _turned(rows: Any) -> Any:
    """(x, y, z) with y up as (x, -z, y) with z up."""
    return np.stack([rows[:, 0], -rows[:, 2], rows[:, 1]], axis=1)


if __name__ == "__main__":
    main()
