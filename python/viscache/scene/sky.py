"""The clear sky and its sun as environment light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import checked_floats, require
from viscache.settings.spelling import spelled

IMAGE_WIDTH = 1024

Triple = tuple[float, float, float]


@spelled
@dataclass(frozen=True, kw_only=True, slots=True)
class Sky:
    """The clear sky and its sun after Hosek and Wilkie (2012, 2013), for `env=`.

    The sky becomes a lat-long image, the sun a directional light with the irradiance of its disk.
    Radiance is in W/(m²·sr·nm), as in Mitsuba 3's `sunsky`.

    Parameters
    ----------
    sun_direction : (3,) float
        Towards the sun, of any length. A sun below the horizon gives no light.
    turbidity : float in [1, 10]
        Haze; 3 is a clear day of the temperate zone.
    albedo : float or (3,) float in [0, 1]
        Of the ground, which reflects light into the sky.
    up : (3,) float
        Towards the zenith.
    sky_scale, sun_scale : float >= 0
        Factors of the two; 0 leaves one out.

    Raises
    ------
    ValueError
        A value out of range.

    Examples
    --------
    >>> import viscache as vc
    >>> noon = vc.Sky(sun_direction=(0.2, 0.9, 0.3))
    >>> scene = vc.Scene.from_arrays([[0, 0, 0], [0, 0, 1], [1, 0, 0]], [[0, 1, 2]], env=noon)
    >>> [light["kind"] for light in scene.lights]
    ['directional', 'environment']
    >>> evening = vc.Sky.at(latitude=48.2, longitude=16.4, timezone=2, date=(2024, 6, 21), hour=19)
    >>> round(evening.elevation_deg)
    17
    """

    sun_direction: Triple = (0.0, 0.8, 0.6)
    turbidity: float = 3.0
    albedo: float | Triple = 0.3
    up: Triple = (0.0, 1.0, 0.0)
    sky_scale: float = 1.0
    sun_scale: float = 1.0

    def __post_init__(self) -> None:
        for name in ("sun_direction", "up"):
            object.__setattr__(self, name, _unit(getattr(self, name), name))
        ok = 1 <= self.turbidity <= 10
        require(ok, "turbidity must be in [1, 10]", self.turbidity)
        ground = checked_floats(self.albedo, "albedo", np.float64)
        ok = ground.shape in ((), (3,)) and bool(((ground >= 0) & (ground <= 1)).all())
        require(ok, "albedo must be one or three numbers in [0, 1]", self.albedo)
        for name in ("sky_scale", "sun_scale"):
            value = getattr(self, name)
            require(0 <= value < float("inf"), f"{name} must be finite and >= 0", value)

    @classmethod
    def at(
        cls,
        *,
        latitude: float,
        longitude: float,
        timezone: float,
        date: tuple[int, int, int],
        hour: float,
        turbidity: float = 3.0,
        albedo: float | Triple = 0.3,
    ) -> Sky:
        """The sky of a place and a time, with x to the east, y up and z to the south.

        Parameters
        ----------
        latitude, longitude : float
            Degrees to the north and to the east.
        timezone : float
            Hours east of Greenwich, with daylight saving.
        date : (year, month, day)
        hour : float
            Local time; 15.5 is half past three.
        turbidity, albedo
            As in `Sky`.

        Notes
        -----
        The PSA algorithm (Blanco-Muriel et al. 2001), accurate to half a minute of arc.
        """
        year, month, day = date
        east, up, north = _core.sun_direction(
            year=year,
            month=month,
            day=day,
            hour=hour,
            timezone=timezone,
            latitude=latitude,
            longitude=longitude,
        )
        return cls(sun_direction=(east, up, -north), turbidity=turbidity, albedo=albedo)

    @property
    def elevation_deg(self) -> float:
        """Angle of the sun above the horizon."""
        return float(np.degrees(np.arcsin(np.clip(np.dot(self.sun_direction, self.up), -1, 1))))

    def radiance(self, directions: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Radiance of the sky without its sun from directions (N, 3); (N, 3) float32."""
        local = checked_floats(directions, "directions") @ self._to_world()
        found = _core.sky_radiance(self._local_sun(), self.turbidity, self._ground(), local)
        return found * np.float32(self.sky_scale)

    @property
    def sun_irradiance(self) -> npt.NDArray[np.float32]:
        """Irradiance of the sun on a surface that faces it, (3,) float32."""
        found = np.array(_core.sun_irradiance(self._local_sun(), self.turbidity), np.float32)
        return found * np.float32(self.sun_scale)

    def image(self, width: int = IMAGE_WIDTH) -> npt.NDArray[np.float32]:
        """Lat-long image (width / 2, width, 3) of the sky without its sun; row 0 is at `up`."""
        pixels = _core.sky_image(self._local_sun(), self.turbidity, self._ground(), width)
        return pixels * np.float32(self.sky_scale)

    def add_to(self, description: _core.SceneDescription) -> None:
        """Make this sky the environment of a scene, and add its sun."""
        if self.sky_scale > 0 and self.elevation_deg >= 0:
            to_world = np.zeros((3, 4))
            to_world[:, :3] = self._to_world()
            image = description.add_image(self.image())
            description.set_environment((1.0, 1.0, 1.0), image=image, to_world=to_world)
        else:
            description.clear_environment()
        r, g, b = (float(v) for v in self.sun_irradiance)
        if max(r, g, b) > 0:
            description.add_directional_light(self.sun_direction, (r, g, b))

    def _ground(self) -> Triple:
        r, g, b = (float(v) for v in np.broadcast_to(self.albedo, (3,)))
        return r, g, b

    def _to_world(self) -> npt.NDArray[np.float64]:
        """Rotation from the frame of the image, where y points up."""
        up = np.array(self.up)
        x = np.cross(up, (0.0, 0.0, 1.0) if abs(up[2]) < 0.9 else (1.0, 0.0, 0.0))
        x /= np.linalg.norm(x)
        return np.stack([x, up, np.cross(x, up)], axis=1)

    def _local_sun(self) -> Triple:
        x, y, z = (float(v) for v in np.array(self.sun_direction) @ self._to_world())
        return x, y, z


def _unit(value: Triple, name: str) -> Triple:
    v = checked_floats(value, name, np.float64)
    ok = v.shape == (3,) and bool(np.isfinite(v).all()) and bool(np.any(v))
    require(ok, f"{name} must be three finite numbers, not all 0", value)
    x, y, z = (float(c) for c in v / np.linalg.norm(v))
    return x, y, z
