"""Which rays hit, and where: settings of the exact ray casters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, TypeAlias

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.registry import registered

BSP_ROWS = ParameterRows(_core.visibility.BspSettings)
FIELD_ROWS = ParameterRows(_core.vlf.FieldSettings)


@registered("rays", "embree")
@dataclass(frozen=True, kw_only=True, slots=True)
class Embree:
    """Rays by Embree.

    Parameters
    ----------
    robust : bool
        No gaps along edges, and the same answer from every instruction set; costs 15–35 % speed.
        Of rays aimed exactly at vertices, 0.05 % still pass, and 0.7 % in meshes of slivers.
    watertight : bool
        No gaps at vertices either. Embree finds the triangles near a ray, and the test of `Bsp`
        decides in double precision at edges. Rays are traced one by one, and instances are stored
        as copies, so it needs more time and memory. Needs `robust`.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> bool(scene.visible((0, 3, 0), (0, -1, 0), rays=vc.Embree(watertight=True)))
    False
    """

    robust: bool = True
    watertight: bool = False

    def __post_init__(self) -> None:
        check_types(self)
        require(self.robust or not self.watertight, "robust must be True with watertight", False)

    def build(self, scene: Any, threads: int = 0) -> EmbreeStructure:
        """Embree's structure over a `Scene`; it takes all cores."""
        if self.watertight:
            return _core.visibility.WatertightCaster(scene._core)
        return _core.EmbreeCaster(scene._core, robust=self.robust)


@registered("rays", "bsp")
@BSP_ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Bsp(RowSettings):
    """Single rays through a BSP: the tracer the visibility field is compared with.

    Cells are halved at the middle of their longest side (Mortensen et al. 2007, Sec. 5.1).

    Parameters
    ----------
    {parameters}

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> scene.caster(vc.Bsp(max_depth=10)).stats["max_depth"]
    10
    """

    ROWS: ClassVar[ParameterRows] = BSP_ROWS
    max_depth: int | None = BSP_ROWS.default("max_depth")
    leaf_size: int = BSP_ROWS.default("leaf_size")
    kernel: Literal["watertight", "wald"] = BSP_ROWS.default("kernel")
    max_bytes: int = BSP_ROWS.default("max_bytes")

    def build(self, scene: Any, threads: int = 0) -> _core.visibility.BspCaster:
        """The tree over a `Scene`; 0 threads = all cores."""
        return _core.visibility.BspCaster(scene._core, self.core(), threads=threads)


@registered("rays", "vlf")
@FIELD_ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Vlf(RowSettings):
    """Rays by look-up in a visibility field (Mortensen, Khanna, Yu, Slater 2007).

    Parameters
    ----------
    {parameters}

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> rays = vc.Vlf(n_directions=33, n_tiles=32)
    >>> vc.render(scene, vc.Direct(), rays=rays, size=(32, 20)).image.shape
    (20, 32, 3)
    """

    ROWS: ClassVar[ParameterRows] = FIELD_ROWS
    n_directions: int | Literal["auto"] = FIELD_ROWS.default("n_directions")
    n_tiles: int | Literal["auto"] = FIELD_ROWS.default("n_tiles")
    bsp_depth: int | Literal["auto"] = FIELD_ROWS.default("bsp_depth")
    leaf_target: int = FIELD_ROWS.default("leaf_target")
    split: Literal["uniform", "object"] = FIELD_ROWS.default("split")
    walk: Literal["linear", "stack"] = FIELD_ROWS.default("walk")
    tile_ranges: bool = FIELD_ROWS.default("tile_ranges")
    fit: Literal["sphere", "psf_box"] = FIELD_ROWS.default("fit")
    kernel: Literal["watertight", "wald"] = FIELD_ROWS.default("kernel")
    head_room: float = FIELD_ROWS.default("head_room")
    lazy: bool = FIELD_ROWS.default("lazy")
    snap: bool = FIELD_ROWS.default("snap")
    max_bytes: int = FIELD_ROWS.default("max_bytes")
    max_build_s: float = FIELD_ROWS.default("max_build_s")

    def build(self, scene: Any, threads: int = 0) -> _core.vlf.VisibilityField:
        """The field over a `Scene`; 0 threads = all cores."""
        return _core.vlf.VisibilityField(scene._core, self.core(), threads=threads)


#: Settings that build a ray caster: what `rays=` takes.
Rays: TypeAlias = Embree | Bsp | Vlf
#: What `Embree` builds.
EmbreeStructure: TypeAlias = "_core.EmbreeCaster | _core.visibility.WatertightCaster"
#: What they build.
Caster: TypeAlias = (
    "_core.EmbreeCaster | _core.visibility.WatertightCaster | _core.visibility.BspCaster"
    " | _core.vlf.VisibilityField"
)


def is_robust(rays: object) -> bool:
    """True for Embree's robust rays, the default, which come in packets."""
    return isinstance(rays, Embree) and rays.robust and not rays.watertight
