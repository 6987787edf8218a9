"""Frames, caches and statistics whose bytes must not change.

Rays use the package's own BSP. Embree's answers at edges depend, by rounding, on its version and on
the instruction set; the BSP's do not.
"""

import hashlib
from collections.abc import Callable

import numpy as np

import viscache as vc
from reference.built import built
from render import test_sky_lobes
from render.strip_lights import strip_lights

LOOKS = tuple(test_sky_lobes.LOOKS.values())
SIZE = (48, 32)
ROOM = "room?triangles=2000"


def digest(*arrays) -> str:
    total = hashlib.sha256()
    for array in arrays:
        total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()[:24]


def frame(scene: str, integrator, *, size: tuple[int, int] = SIZE, **options) -> Callable[[], str]:
    """A frame's colour, counted rays and queries."""

    def make() -> str:
        made = vc.render(built(scene), integrator, size=size, rays=vc.Bsp(), **options)
        counts = [made.counters["queries"], made.counters["rays"], made.counters["camera_rays"]]
        return digest(made.image, np.array(counts, dtype=np.int64))

    return make


def kept_frames() -> str:
    table, scene = vc.AqvcTable(table_bytes=1 << 20, check=0.25), built(ROOM)
    frames = [
        vc.render(
            scene,
            vc.Whitted(n_vpls=32),
            visibility=vc.Aqvc(c_e=8),
            size=SIZE,
            seed=seed,
            rays=vc.Bsp(),
            keep=table,
        )
        for seed in range(3)
    ]
    counts = [[f.counters["rays"], f.counters["checked_kept"]] for f in frames]
    return digest(*(f.image for f in frames), np.array(counts, dtype=np.int64))


def correlation() -> str:
    """Means and counts of the visibility correlation of given rows of bits."""
    random = np.random.default_rng(5)
    bits = random.integers(0, 1 << 63, (300, 8), dtype=np.uint64)
    normals = random.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    measured = vc.correlation.correlate(
        bits,
        random.random((300, 3)),
        normals,
        d_edges=np.linspace(0, 2, 9),
        theta_edges_deg=np.linspace(0, 180, 7),
    )
    return digest(measured["n"].values, measured["n_undefined"].values)


def map_records() -> str:
    """A blended ambient occlusion by visibility maps, and how many records it took."""
    scene = built(ROOM)
    cache = vc.VisibilityMapCache(scene, rays=vc.Bsp())
    camera = vc.look_at((0, 0.2, 2), (0, 0, 0), (0, 1, 0), 50)
    cache.update(camera, size=SIZE)
    return digest(np.array([len(cache), cache.rays], dtype=np.int64))


def swept() -> str:
    over = {"visibility.c_e": [4.0, 16.0]}
    table = vc.sweep(
        built(ROOM),
        vc.Whitted(n_vpls=16),
        over=over,
        visibility=vc.Aqvc(),
        rays=vc.Bsp(),
        size=SIZE,
    )
    return digest(table["rel_l1"].values, np.asarray(table["rays"].values, dtype=np.int64))


def lobes() -> str:
    """Samples of lobes beside shared directions of the sky, a frame of each material."""
    given = {"rays": vc.Bsp()}
    made = (test_sky_lobes.frame_of(test_sky_lobes.shared(2), look=look, **given) for look in LOOKS)
    return digest(*(frame.image for frame in made))


def strips() -> str:
    """Lights that are chosen by the tree, one by one, and picked by eye points."""
    scene = strip_lights(60, glossy=True)
    ways = (vc.Direct(n_area=2), vc.Direct(n_area=16), vc.Whitted(pick=4, n_vpls=64, n_area=0))
    made = (vc.render(scene, way, size=SIZE, spp=4, rays=vc.Bsp()) for way in ways)
    return digest(*(frame.image for frame in made))


def corrected_passes() -> str:
    """Passes with learnt shares. 300 lights leave rows half empty."""
    picture = vc.Progressive(
        built(ROOM), vc.Whitted(n_vpls=300), visibility=vc.Aqvc(c_e=10), size=SIZE, rays=vc.Bsp()
    )
    return digest(picture.passes(4).image)


def cached(c_e: float, **given) -> vc.Aqvc:
    """The quantized cache for all light groups."""
    return vc.Aqvc(c_e=c_e, exact_groups=(), **given)


def cases() -> dict[str, Callable[[], str]]:
    """Name → what makes the digest."""
    whitted, direct = vc.Whitted(n_vpls=64), vc.Direct()
    found: dict[str, Callable[[], str]] = {}
    for name, scene in (("room", ROOM), ("slits", "slits"), ("cube", "cube_on_plane")):
        found[f"{name} exact"] = frame(scene, whitted)
        for c_e in (2.0, 8.0, 16.0):
            found[f"{name} aqvc {c_e}"] = frame(scene, whitted, visibility=cached(c_e), spp=4)
        for preset in ("fast", "paper", "as_printed"):
            cache = cached(8, preset=preset)
            found[f"{name} aqvc {preset}"] = frame(scene, direct, visibility=cache)
        found[f"{name} shadow maps"] = frame(
            scene, whitted, visibility=vc.ShadowMap(resolution=128, vpls=True)
        )
        found[f"{name} nee++"] = frame(scene, whitted, visibility=vc.NeePlusPlus())
        found[f"{name} bdpt"] = frame(scene, vc.Bdpt(), size=(24, 16), spp=2)
        found[f"{name} bdpt aqvc"] = frame(
            scene, vc.Bdpt(), size=(24, 16), spp=2, visibility=vc.Aqvc(c_e=8)
        )
        found[f"{name} bdpt nee++"] = frame(
            scene, vc.Bdpt(), size=(24, 16), spp=2, visibility=vc.NeePlusPlus()
        )
        found[f"{name} ambient"] = frame(scene, vc.AmbientOcclusion(max_distance=1.0), spp=2)
        found[f"{name} ambient aqvc"] = frame(
            scene, vc.AmbientOcclusion(max_distance=1.0), spp=2, visibility=vc.Aqvc(c_e=8)
        )
    env = (1.0, 0.8, 0.6)
    product = vc.Direct(environment="product")
    found["environment exact"] = frame("cube_on_plane", product, env=env)
    for use in ("replace", "correct"):
        found[f"environment maps {use}"] = frame(
            "cube_on_plane", product, env=env, use=use, visibility=vc.VisMaps()
        )
    found["sky shared"] = frame(
        "cube_on_plane", vc.Direct(environment="shared"), env=env, visibility=cached(8)
    )
    found["cornell by contribution"] = frame("cornell_box", direct)
    found["conference by contribution"] = frame("conference?triangles=5000", direct)
    for preset in ("default", "fast"):  # area lights are exact
        found[f"cornell aqvc {preset}"] = frame(
            "cornell_box", whitted, visibility=vc.Aqvc(preset=preset, c_e=8)
        )
    found |= {
        "kept table": kept_frames,
        "correlation": correlation,
        "map records": map_records,
        "sweep": swept,
        "lobes of a sky": lobes,
        "strip lights": strips,
        "corrected passes": corrected_passes,
    }
    return found
