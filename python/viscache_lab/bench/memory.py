"""`viscache bench memory`: peak memory of a frame of a large scene, in a separate process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from viscache.scenes.sources import scene_file
from viscache_lab.experiment import BENCHES, Trial

LIMIT_GIB = 4.0
PROGRAM = """
import json, resource, sys
import numpy as np
import viscache as vc
from viscache_lab.experiment.amounts import build_scene
spec = sys.argv[1]
scene = vc.load_scene(spec) if spec.endswith((".xml", ".pbrt")) else build_scene(spec)
size = (int(sys.argv[2]), int(sys.argv[3]))
integrator = vc.Whitted(n_vpls=int(sys.argv[4]))
visibility = vc.Aqvc(c_e=10) if sys.argv[5] == "aqvc" else vc.Exact()
frame = vc.render(scene, integrator, visibility=visibility, size=size)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
finite = bool(np.isfinite(frame.image).all())
print(json.dumps({"triangles": scene.triangles, "peak_bytes": peak * 1024,
                  "mean": float(frame.image.mean()), "finite": finite}))
"""


@BENCHES.add("memory", "peak memory of a 1280x800 frame of a scene of 2.2 million triangles")
def memory(trial: Trial) -> None:
    """2.2 million distinct placed triangles at 1280x800 with 1024 VPLs."""
    specs = ["random_triangles?triangles=" + ("20000" if trial.quick else "2200000")]
    if not trial.quick:
        path = scene_file("sanmiguel-part")
        if path is None:
            trial.skip("sanmiguel-part", "no scene file; VISCACHE_SCENES names its folder")
        else:
            specs.append(str(path))
    for spec in specs:
        _measure(trial, spec, trial.quick)


def _measure(trial: Trial, spec: str, quick: bool) -> None:
    is_file = spec.endswith((".xml", ".pbrt"))
    name = Path(spec).parent.name if is_file else spec.partition("?")[0]
    width, height, n_vpls = (160, 100, 64) if quick else (1280, 800, 1024)
    for visibility in ("exact", "aqvc"):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, spec, str(width), str(height), str(n_vpls), visibility],
            capture_output=True,
            text=True,
            check=True,
        )
        found = json.loads(done.stdout)
        gib = found["peak_bytes"] / 2**30
        trial.figure(
            f"{name} {found['triangles']} {width}x{height} {visibility} peak memory",
            gib,
            "GiB",
            baseline=LIMIT_GIB,
            ratios=[LIMIT_GIB / gib],
            goal=1.0,
        )
        trial.check(f"{name} {visibility}: pixels not finite", float(not found["finite"]), 0)
        trial.check(f"{name} {visibility}: black image", float(not found["mean"] > 0), 0)
