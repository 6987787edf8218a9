"""Which rays hit, and where: settings of the exact ray casters."""

from __future__ import annotations

import typing
from dataclasses import dataclass
from typing import Literal, TypeAlias

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.spelling import setting

__all__ = ["Bsp", "Caster", "Embree", "Rays", "Vlf", "check_rays"]


@setting
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


@setting
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
        A tree that needs more raises MemoryError; so does one that cuts triangles into countless
        pieces (deep trees over many triangles side by side), after some seconds instead of hours.

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


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class Vlf:
    """Rays by look-up in a visibility field (Mortensen, Khanna, Yu, Slater 2007).

    Parameters
    ----------
    n_directions : int or "auto"
        l: 1, 3, 9, 33, 129, 513, 2049 or 8193 (2·4^k + 1).
    n_tiles : int in [1, 4096] or "auto"
        n: tiles along an edge of each direction's grid.
    bsp_depth : int in [0, 12] or "auto"
        Most halvings of a tile's depth. "auto", for any of the three: chosen to fit `max_bytes`.
    leaf_target : int >= 0
        A tile is halved no further than to so many triangles a leaf; 0: all to `bsp_depth`.
    split : {"uniform", "object"}
        Tiles are cut into equal slabs, or at the medians of their triangles' depths.
    walk : {"linear", "stack"}
        The paper's two ways through a tile's leaves. Never changes an answer.
    tile_ranges : bool
        Depths are parted over each tile's own range, or over the scene's, which saves no memory:
        a tile keeps its range in either case, so that rays beside it can pass.
    fit : {"sphere", "psf_box"}
        What a direction's tiles cover: the square around the scene's bounding sphere, or the box of
        the triangles seen along it: finer tiles where a scene is flat. Never changes an answer.
    kernel : {"watertight", "wald"}
        "wald" is the paper's: fewer operations, but a ray may slip through an edge.
    head_room : float in [1, 1000]
        Size of the field's ball over the scene's bounding sphere: room for objects that move.
    lazy : bool
        Directions are built by the first ray that needs them, and those longest unused given up
        where the budget ends.
    snap : bool
        Approximate: every ray runs along its nearest axis, up to 5° off at l = 513.
    max_bytes : int >= 1
        A field that needs more, what one thread needs to build it included, raises MemoryError
        before it is built; no more threads build at a time than fit beside it.
    max_build_s : float >= 0
        CPU seconds that "auto" parameters may take to build, by rule of thumb; 0: any.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> rays = vc.Vlf(n_directions=33, n_tiles=32)
    >>> vc.render(scene, vc.Direct(), rays=rays, size=(32, 20)).image.shape
    (20, 32, 3)
    """

    n_directions: int | Literal["auto"] = 513
    n_tiles: int | Literal["auto"] = 128
    bsp_depth: int | Literal["auto"] = "auto"
    leaf_target: int = 4
    split: Literal["uniform", "object"] = "uniform"
    walk: Literal["linear", "stack"] = "linear"
    tile_ranges: bool = True
    fit: Literal["sphere", "psf_box"] = "sphere"
    kernel: Literal["watertight", "wald"] = "watertight"
    head_room: float = 1.0
    lazy: bool = False
    snap: bool = False
    max_bytes: int = 2 << 30
    max_build_s: float = 0.0

    def __post_init__(self) -> None:
        check_types(self)
        require(1 <= self.max_bytes < 1 << 64, "max_bytes must be in [1, 2^64)", self.max_bytes)
        self.core()

    def core(self) -> _core.vlf.FieldSettings:
        """The C++ settings.

        Raises
        ------
        ValueError
            A value out of range.
        """
        core = _core.vlf.FieldSettings()
        for name, least in (("n_directions", 1), ("n_tiles", 1), ("bsp_depth", 0)):
            value = getattr(self, name)
            fits = value == "auto" or least <= value < 1 << 31
            require(fits, f'{name} must be >= {least} or "auto"', value)
            if value != "auto":
                setattr(core, name, value)
            else:
                setattr(core, name, least - 1)
        fits = 0 <= self.leaf_target < 1 << 31
        require(fits, "leaf_target must be in [0, 2^20]", self.leaf_target)
        core.leaf_target, core.tile_ranges, core.head_room = (
            self.leaf_target, self.tile_ranges, self.head_room,
        )  # fmt: skip
        core.split = _core.vlf.DepthSplit[self.split.upper()]
        core.walk = _core.vlf.LeafWalk[self.walk.upper()]
        core.fit = _core.vlf.FieldFit[self.fit.upper()]
        core.kernel = _core.visibility.TriangleKernel[self.kernel.upper()]
        core.lazy, core.snap, core.max_bytes = self.lazy, self.snap, self.max_bytes
        core.max_build_s = self.max_build_s
        core.validate()
        return core

    def build(self, scene: _core.Scene, threads: int = 0) -> _core.vlf.VisibilityField:
        """The field over a scene; 0 threads = all cores."""
        return _core.vlf.VisibilityField(scene, self.core(), threads=threads)


#: Settings that build a ray caster: what `rays=` takes.
Rays: TypeAlias = Embree | Bsp | Vlf
#: What they build.
Caster: TypeAlias = "_core.EmbreeCaster | _core.visibility.BspCaster | _core.vlf.VisibilityField"


def vlf_settings(given: Vlf | str | None) -> Vlf:
    """The settings of a field that an argument means; ValueError where they are of other rays."""
    from viscache.settings import by_name  # which knows the classes of this file

    chosen: Vlf = by_name.setting("rays", given, "vlf")
    require(isinstance(chosen, Vlf), "settings must be vc.Vlf(...)", chosen)
    return chosen


def check_rays(rays: Rays | str | None) -> Rays:
    """The settings that `rays=` means, Embree by default; ValueError where they are none."""
    from viscache.settings import by_name

    known = typing.get_args(Rays)
    classes = " or ".join(f"vc.{cls.__name__}(...)" for cls in known)
    chosen: Rays = by_name.setting("rays", rays, "embree")
    require(isinstance(chosen, known), f"rays must be {classes}", chosen)
    return chosen
