"""Try an installed wheel: where its libraries come from, and a first cached frame with its time."""

from __future__ import annotations

import sys
import time
from pathlib import Path

#: Libraries that a wheel must bring itself.
BUNDLED = ("libembree", "libtbb", "libjpeg", "libpng", "libpugixml")


def mapped() -> set[Path]:
    """Shared libraries of this process."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    fields = [line.split(maxsplit=5) for line in lines]
    return {Path(field[5]) for field in fields if len(field) == 6 and ".so" in field[5]}


def main() -> int:
    """Return 1 where a library is missing or comes from outside the environment."""
    began = time.perf_counter()
    import viscache as vc

    imported = time.perf_counter()
    scene = vc.scenes.room(triangles=20_000)
    frame = vc.render(scene, vc.Whitted(n_vpls=64), size=(320, 200), visibility=vc.Aqvc(c_e=12))
    ended = time.perf_counter()

    status, environment = 0, Path(sys.prefix).resolve()
    for name in BUNDLED:
        places = [path for path in mapped() if path.name.startswith(name)]
        outside = [str(path) for path in places if not path.is_relative_to(environment)]
        if not places or outside:
            print(f"{name}: {', '.join(outside) or 'not loaded'}; the wheel must bring it")
            status = 1
    reduction = frame.counters["ray_reduction"]
    print(f"viscache {vc.__version__} from {Path(vc.__file__).parent}")
    print(
        f"import {imported - began:.2f} s, first cached frame {ended - imported:.2f} s, "
        f"{reduction:.1f} queries per shadow ray"
    )
    return status if reduction > 1 else 1


if __name__ == "__main__":
    sys.exit(main())
