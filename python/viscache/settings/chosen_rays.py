"""The settings of rays that an argument means: settings or a name."""

from __future__ import annotations

from viscache.settings import by_name
from viscache.settings.checks import require
from viscache.settings.rays import Rays, Vlf
from viscache.settings.registry import classes, is_setting


def vlf_settings(given: Vlf | str | None) -> Vlf:
    """The settings of a field that an argument means; ValueError where they are of other rays."""
    chosen: Vlf = by_name.setting("rays", given, "vlf")
    require(isinstance(chosen, Vlf), "settings must be vc.Vlf(...)", chosen)
    return chosen


def check_rays(rays: Rays | str | None) -> Rays:
    """The settings that `rays=` means, Embree by default; ValueError where they are none."""
    chosen: Rays = by_name.setting("rays", rays, "embree")
    require(is_setting("rays", chosen), f"rays must be {classes('rays')}", chosen)
    return chosen
