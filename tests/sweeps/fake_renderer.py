"""A stand-in for `viscache.render` whose error and cost are known in closed form.

The exact picture is a ramp; the cached one is the ramp times (1 + c_e / 100), so that rel_l1
against the paired reference is c_e / 100 exactly; it traces queries / c_e² rays.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from viscache.frame import Frame
from viscache.scene.cameras import look_at


@dataclass(frozen=True, kw_only=True, slots=True)
class Whitted:
    n_vpls: int = 64

    def __post_init__(self) -> None:
        if self.n_vpls < 1:
            raise ValueError(f"n_vpls must be >= 1, got {self.n_vpls}")


@dataclass(frozen=True, kw_only=True, slots=True)
class Embree:
    robust: bool = True


@dataclass(frozen=True, kw_only=True, slots=True)
class Exact:
    pass


@dataclass(frozen=True, kw_only=True, slots=True)
class Aqvc:
    preset: str = "default"
    c_e: float = 10.0
    c_n: int = 8
    processing: str = "waves"

    def __post_init__(self) -> None:
        if self.c_e <= 0:
            raise ValueError(f"c_e must be > 0, got {self.c_e}")


#: Name of each of the settings above, as `viscache.settings.by_name.NAMES` has them.
NAMES: tuple[tuple[str, str, type], ...] = (
    ("integrator", "whitted", Whitted),
    ("rays", "embree", Embree),
    ("visibility", "exact", Exact),
    ("visibility", "aqvc", Aqvc),
)


@dataclass(frozen=True)
class FakeScene:
    name: str = "fake"
    content_hash: str = "ab" * 32
    triangles: int = 12
    cameras: tuple[Any, ...] = (look_at((0, 0, 3), (0, 0, 0)),)


CALLS = []
#: Raise KeyboardInterrupt at this many calls.
STOP: list[int] = []


def fake_render(
    scene,
    integrator,
    *,
    rays=None,
    visibility=None,
    use=None,
    size: tuple[int, int] = (64, 48),
    spp: int = 1,
    seed: int = 0,
    threads=None,
    camera=None,
    env=None,
    progress: bool = False,
) -> Frame:
    if STOP and len(CALLS) >= STOP[0]:
        raise KeyboardInterrupt
    CALLS.append({"visibility": visibility, "integrator": integrator, "seed": seed, "spp": spp})
    width, height = size
    rng = np.random.default_rng(seed)
    ramp = np.linspace(0.1, 1.0, width)[None, :, None] * np.ones((height, 1, 3))
    noise = 0.01 * rng.standard_normal((height, width, 1)) / np.sqrt(spp)
    exact = isinstance(visibility, Exact)
    error = 0.0 if exact else visibility.c_e / 100
    color = (ramp + noise) * (1 + error)
    queries = width * height * integrator.n_vpls
    traced = queries if exact else int(queries / visibility.c_e**2)
    return Frame(
        layers={"color": color, "vpl": color * 0.5},
        counters={
            "queries": queries,
            "rays": traced,
            "ray_reduction": queries / max(traced, 1),
            "groups": {"vpl": {"queries": queries, "occluded": queries // 3, "rays": traced}},
            "rays_per_level": [traced, 0],
        },
        timings={
            "total_s": 1.0 if exact else 0.2 + 0.5 / visibility.c_e,
            "visibility_s": traced * 1e-7,
            "shading_s": 0.1,
        },
        parameters={"seed": seed},
    )
