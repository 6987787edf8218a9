"""Stand-ins for the scenes of the quantized cache's paper, lit and sampled as in Section 5."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import viscache as vc
from viscache import scenes
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Shot

Preset: TypeAlias = Literal["default", "fast", "paper"]
#: Presets whose pictures are compared with exact ones.
PRESETS: tuple[Preset, ...] = ("default", "fast", "paper")

SIZE, QUICK_SIZE = (640, 400), (80, 50)
#: Direction to the sun of APARTMENT DELTA, and its irradiance.
SUN, SUNLIGHT = (-0.35, 0.45, -0.8), (4.0, 3.8, 3.4)
#: Under a chair of the living room: the camera's place, its target, its angle of view.
CLOSE_UP = ((-1.89, 0.31, -1.18), (-2.29, 0.01, -1.52), 40.0)


@dataclass(frozen=True, slots=True)
class Setup:
    """One of the paper's renderings, full or quick."""

    name: str
    printed: str
    """The paper's scene, a key of `aqvc_printed.SCENES`."""
    make: Callable[[int], vc.Scene]
    """Takes the number of triangles."""
    triangles: tuple[int, int]
    """Of full and of quick runs."""
    n_vpls: int = 0
    n_area: int = 0
    n_environment: int = 0
    """Samples of the environment by its radiance; the same number by the BRDF."""
    antialiased: int = 16
    """Samples per pixel in the paper's anti-aliased frames."""
    c_e_groups: Mapping[str, float] = field(default_factory=dict)
    _: KW_ONLY
    delta_lights: bool = False
    square: bool = False

    def integrator(self, quick: bool) -> vc.Whitted:
        """The paper's numbers of samples; an eighth of them if quick."""
        share = 8 if quick else 1
        environment = self.n_environment // share
        return vc.Whitted(
            n_vpls=self.n_vpls // share,
            n_area=self.n_area // share,
            n_environment=environment,
            n_brdf=environment,
        )

    def pixels(self, quick: bool, size: tuple[int, int] | None = None) -> tuple[int, int]:
        """The requested size, or this setup's own."""
        if size is not None:
            return size
        if self.square:
            return (128, 128) if quick else (512, 512)
        return QUICK_SIZE if quick else SIZE

    def shot(self, quick: bool, size: tuple[int, int] | None = None, spp: int = 1) -> Shot:
        """Ready to be rendered."""
        return Shot(
            scene=self.scene(quick),
            integrator=self.integrator(quick),
            spp=spp,
            size=self.pixels(quick, size),
        )

    def scene(self, quick: bool) -> vc.Scene:
        """The scene; recent scenes are cached."""
        return _made(self.name, self.triangles[quick])

    def cache(self, preset: Preset, c_e: float, **given: Any) -> vc.Aqvc:
        """A preset at one C_E, except for the light groups whose C_E the paper keeps fixed."""
        groups = dict(self.c_e_groups)
        return vc.Aqvc(preset=preset, c_e=c_e, c_e_groups=groups, exact_groups=(), **given)


@lru_cache(maxsize=4)
def _made(name: str, triangles: int) -> vc.Scene:
    return SETUPS[name].make(triangles)


def delta(triangles: int) -> vc.Scene:
    """The apartment with its 24 lamps and sunlight through the windows, without a sky."""
    d: vc.SceneDescription = vc.scenes.SCENES["apartment"].builder(triangles=triangles).description
    d.clear_environment()
    d.add_directional_light(SUN, SUNLIGHT)
    return vc.Scene.from_description(d)


LAMPS = {"point": printed.APARTMENT_POINT_C_E}
SETUPS: dict[str, Setup] = {
    setup.name: setup
    for setup in (
        Setup("delta", "delta", delta, (750_000, 20_000), delta_lights=True),
        Setup(
            "apartment",
            "apartment",
            scenes.apartment,
            (750_000, 20_000),
            1024,
            0,
            128,
            16,
            LAMPS,
        ),
        Setup("conference", "conference", scenes.conference, (280_000, 20_000), n_area=64),
        Setup("courtyard", "san miguel", scenes.courtyard, (2_200_000, 60_000), 1024, 0, 128, 9),
        Setup(
            "hairball",
            "hairball",
            scenes.hairball,
            (3_000_000, 30_000),
            256,
            0,
            32,
            9,
            square=True,
        ),
    )
}
