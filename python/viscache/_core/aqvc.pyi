# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Quantized visibility cache (AQVC).
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['AnalyticCaster', 'AqvcParameters', 'BitTable', 'TileRun', 'expected_paths', 'full_keys', 'hash_keys', 'ladder', 'largest_prime', 'level_hashes', 'light_cells', 'octahedral_batch', 'octahedral_square', 'order', 'patch_area', 'patch_area_product', 'resolution_environment', 'resolution_eye', 'resolution_light', 'resolution_pair']
class AqvcParameters:
    """
    Parameters of the quantized cache; see viscache.Aqvc.
    """
    batch: typing.Any
    by_contribution: bool
    c_e: typing.Any
    c_finest: typing.Any
    c_l: typing.Any
    c_n: typing.Any
    c_pg: typing.Any
    c_r: typing.Any
    c_w: typing.Any
    c_z: typing.Any
    cell_density: str
    digest_bits: typing.Any
    env_rule: str
    form: str
    grid_offset: bool
    grid_seed: typing.Any
    hash: str
    level_rule: str
    level_step: typing.Any
    normal_mode: str
    order: str
    queue: typing.Any
    refinement: str
    res_rule: str
    scale_free: bool
    storage: str
    table_bytes: typing.Any
    tangent_neighbours: bool
    vpl_key: str
    @staticmethod
    def parameter_rows() -> list:
        """
        Name, kind, range, uses and doc of every parameter, as the C++ table has them.
        """
    def __init__(self, **kwargs) -> None:
        ...
    def level_list(self, group: typing.SupportsInt | typing.SupportsIndex, *, spp: typing.SupportsInt | typing.SupportsIndex = 1, lift: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> list[float]:
        """
        C_E of every level of a light group, coarse to fine.
        """
    def validate(self) -> None:
        ...
    @property
    def c_e_groups(self) -> dict[str, float]:
        ...
    @c_e_groups.setter
    def c_e_groups(self, arg1: typing.Any) -> None:
        ...
    @property
    def refinement_groups(self) -> dict[str, str]:
        ...
    @refinement_groups.setter
    def refinement_groups(self, arg1: typing.Any) -> None:
        ...
class BitTable:
    """
    The lossy table; misses are -1.
    """
    def __init__(self, slots: typing.SupportsInt | typing.SupportsIndex, digest_bits: typing.SupportsInt | typing.SupportsIndex = 31, scheme: str = 'scheme2') -> None:
        ...
    def clear(self) -> None:
        ...
    def get(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.int32]) -> numpy.typing.NDArray[numpy.int8]:
        ...
    def put(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.int32], arg1: collections.abc.Sequence[bool]) -> dict:
        ...
    @property
    def occupied(self) -> int:
        ...
    @property
    def slots(self) -> int:
        ...
class AnalyticCaster:
    """
    Boxes (lo, hi) and spheres (centre, radius).
    """
    def __init__(self, boxes: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], spheres: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        ...
class TileRun:
    """
    The quantized cache over one tile of given eye points.
    """
    def __init__(self, caster: AnalyticCaster, eyes: dict, parameters: AqvcParameters, *, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, extent: typing.SupportsFloat | typing.SupportsIndex, spp: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        ...
    def begin_tile(self) -> None:
        ...
    def block(self, lights: dict, wanted: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], *, exact: bool = False, contribution: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None) -> tuple:
        ...
    def pair_order(self) -> tuple:
        ...
    def pairs(self, eye: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], *, semantic: typing.SupportsInt | typing.SupportsIndex, group: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], density: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], exact: bool = False) -> tuple:
        ...
    def sample_order(self, group: typing.SupportsInt | typing.SupportsIndex) -> tuple:
        ...
    def samples(self, eye: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], *, semantic: typing.SupportsInt | typing.SupportsIndex, group: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], density: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], light_density: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> tuple:
        ...
def expected_paths(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg4: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 2.
    """
def full_keys(parameters: AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], far_normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], far_resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], dx: typing.SupportsInt | typing.SupportsIndex = 0, dy: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
    """
    Keys of AQVC Sec. 3.3 and 3.5.
    """
def hash_keys(keys: typing.Annotated[numpy.typing.ArrayLike, numpy.int32], scheme: str = 'scheme2') -> numpy.typing.NDArray[numpy.uint32]:
    """
    AQVC Eq. 10: (κ, c).
    """
def ladder(r: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], c_r: typing.SupportsFloat | typing.SupportsIndex = 1.2, c_z: typing.SupportsFloat | typing.SupportsIndex = 4.0) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32], dict]:
    """
    AQVC Eq. 8: resolutions, slots, clamps.
    """
def largest_prime(arg0: typing.SupportsInt | typing.SupportsIndex) -> int:
    ...
def level_hashes(parameters: AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], lights: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, at_once: bool) -> tuple:
    """
    κ and digest (N, 4) of points (N, 3) at four resolutions (N, 4) with a point light each, and the CPU seconds it took: one key after the other, or four levels at once.
    """
def light_cells(parameters: AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, *, semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], density: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], limit: typing.SupportsInt | typing.SupportsIndex = 1073741824) -> tuple:
    """
    Columns of samples by light cell, and clamps.
    """
def octahedral_batch(w: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, isa: str | None = None) -> tuple:
    """
    Octahedral map of many directions by one instruction set.
    """
def octahedral_square(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Octahedral map of directions to the unit square.
    """
def order(x: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], y: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, parameters: AqvcParameters) -> dict:
    """
    Processing order of a tile's eye points (AQVC Sec. 4.3).
    """
def patch_area(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 5.
    """
def patch_area_product(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 3.
    """
def resolution_environment(density: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], printed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool] = False) -> typing.Any:
    """
    AQVC Eq. 9 of P(ω)·M.
    """
def resolution_eye(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 7, eye side: D_e, C_E, B_R.
    """
def resolution_light(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 7, light side: D_l, B_R.
    """
def resolution_pair(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 6 of D_e, D_l, C_E, B_R.
    """
