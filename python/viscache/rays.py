"""Which rays hit, and where: settings of the exact ray casters."""

from __future__ import annotations

import typing
from dataclasses import dataclass
from typing import Literal, TypeAlias

from viscache import _core
from viscache.checks import check_types, require

__all__ = ["Bsp", "Caster", "Embree", "Rays", "check_rays"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Embree:
    """Rays by Embree.

    Parameters
    ----------
    robust : bool
        Watertight edges and the same answer from every instruction set; costs 15–35 % speed.
    """

    robust: bool = True

    def __post_init__(self) -> None:
        check_types(self)

    def build(self, scene: _core.Scene, threads: int = 0) -> _core.EmbreeCaster:
        """Embree's structure over a scene; it takes all cores."""
        return _core.EmbreeCaster(scene, robust=self.robust)


@dataclass(frozen=True, kw_only=True, slots=True)
class Bsp:
    """Single rays through a BSP: the tracer the visibility field is compared with.

    Cells are halved at the middle of their longest side (Mortensen et al. 2007, Sec. 5.1).

    Parameters
    ----------
    max_depth : int in [1, 40], optional
        5 + log2 of the number of triangles by default.
    leaf_size : int in [1, 1024]
        Cells of as many triangles or fewer are not halved.
    kernel : {"watertight", "wald"}
        "wald" is the paper's: fewer operations, but a ray may slip through an edge.
    max_bytes : int >= 1
        A tree that needs more raises MemoryError.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> scene.caster(vc.Bsp(max_depth=10)).stats["max_depth"]
    10
    """

    max_depth: int | None = None
    leaf_size: int = 8
    kernel: Literal["watertight", "wald"] = "watertight"
    max_bytes: int = 2 << 30

    def __post_init__(self) -> None:
        check_types(self)
        depth, leaf = self.max_depth, self.leaf_size
        require(depth is None or 1 <= depth <= 40, "max_depth must be in [1, 40]", depth)
        require(1 <= leaf <= 1024, "leaf_size must be in [1, 1024]", leaf)
        require(1 <= self.max_bytes < 1 << 64, "max_bytes must be in [1, 2^64)", self.max_bytes)

    def core(self) -> _core.visibility.BspSettings:
        """The C++ settings."""
        settings = _core.visibility.BspSettings()
        settings.max_depth, settings.leaf_size = self.max_depth or 0, self.leaf_size
        settings.kernel = _core.visibility.TriangleKernel[self.kernel.upper()]
        settings.max_bytes = self.max_bytes
        return settings

    def build(self, scene: _core.Scene, threads: int = 0) -> _core.visibility.BspCaster:
        """The tree over a scene; 0 threads = all cores."""
        return _core.visibility.BspCaster(scene, self.core(), threads=threads)


#: Settings that build a ray caster: what `rays=` takes.
Rays: TypeAlias = Embree | Bsp
#: What they build.
Caster: TypeAlias = "_core.EmbreeCaster | _core.visibility.BspCaster"


def check_rays(rays: Rays) -> Rays:
    """The settings; ValueError where they are none."""
    known = typing.get_args(Rays)
    classes = " or ".join(f"vc.{cls.__name__}(...)" for cls in known)
    require(isinstance(rays, known), f"rays must be {classes}", rays)
    return rays
