"""Make docs/images/room.png: exact visibility, the quantized cache, and their difference ×16."""

from pathlib import Path

import numpy as np
from PIL import Image

import viscache as vc
from viscache.base import tonemap


def main() -> None:
    """Render the built-in room twice and write the three pictures side by side."""
    scene, integrator = vc.scenes.room(), vc.Whitted(n_vpls=512)
    exact = vc.render(scene, integrator, size=(480, 300), spp=16)
    cached = vc.render(scene, integrator, visibility=vc.Aqvc(c_e=16), size=(480, 300), spp=16)
    pictures = [tonemap.to_srgb8(f.image, 0.55) for f in (exact, cached)]
    pictures.append(tonemap.difference8(cached.image, exact.image))
    path = Path(__file__).parents[1] / "docs/images/room.png"
    Image.fromarray(np.hstack(pictures)).quantize(256).save(path, optimize=True)
    error = vc.metrics.compare(cached, exact, metrics=["rel_l1"])
    print(path, error, cached.counters["ray_reduction"])


if __name__ == "__main__":
    main()
