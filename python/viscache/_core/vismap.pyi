# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
The visibility-map cache (VisMap).
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
import viscache._core
import viscache._core.sampling
__all__: list[str] = ['CachePoints', 'EnvironmentPyramid', 'MapCache', 'MapCacheParameters', 'PixelRules', 'PointEstimate', 'Relighting', 'cell_light', 'dilated', 'morton2', 'morton_order', 'pixel_points', 'points', 'record_nbytes', 'record_weight', 'sample_points', 'startup_points']
class EnvironmentPyramid:
    """
    Sums of luminance × solid angle over the equal-area map.
    """
    def __init__(self, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        From N × N texels of the map in rows; N is a power of two.
        """
    def sums(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        Sums over the nodes of a level along the Morton curve, (4^level,).
        """
    @property
    def levels(self) -> int:
        ...
    @property
    def total(self) -> float:
        """
        Integral of luminance over the sphere.
        """
class PointEstimate:
    """
    Light × reflection × maps at one point, all given as tables.
    """
    def __init__(self, light: EnvironmentPyramid, b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], maps: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], beta: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, dilated: collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.bool]] = [], eta: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        """
        b (N, N, 3); maps (n, 2^m, 2^m) of bool; dilated: two dilations of the maps (m < 6) or three.
        """
    def b_tilde(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Luminance of B̃ of the texels, (R, R).
        """
    def cells(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Ṽ, (2^m, 2^m).
        """
    def density(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        D of the texels, (R, R).
        """
    def flat(self, isa: str) -> tuple[float, float, typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"]]:
        """
        J, ∫ L·B̃·Ṽ², J per channel and ∫ L·B̃·Ṽ^k, computed with one instruction set.
        """
    def guided_masses(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        ∫ L·B̃·D over the nodes of a level, along the Morton curve.
        """
    def probabilities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Probability of every texel, (R, R).
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> dict:
        """
        texel, f, g, z, w and D of the points (N, 2) of the square.
        """
    @typing.overload
    def simulate(self, visible: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], *, n: typing.SupportsInt | typing.SupportsIndex, passes: typing.SupportsInt | typing.SupportsIndex = 1, replicates: typing.SupportsInt | typing.SupportsIndex = 1, set: viscache._core.PointSet = viscache._core.PointSet.INDEPENDENT, mode: viscache._core.AlphaMode = viscache._core.AlphaMode.FIXED, alpha: typing.SupportsFloat | typing.SupportsIndex = 1.0, seed: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 1) -> numpy.typing.NDArray[numpy.float64]:
        """
        Estimates (replicates, passes, 3); `visible` (R, R) of bool is the true visibility.
        """
    @typing.overload
    def simulate(self, visible: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], *, sizes: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], replicates: typing.SupportsInt | typing.SupportsIndex = 1, set: viscache._core.PointSet = viscache._core.PointSet.INDEPENDENT, mode: viscache._core.AlphaMode = viscache._core.AlphaMode.FIXED, alpha: typing.SupportsFloat | typing.SupportsIndex = 1.0, seed: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 1) -> numpy.typing.NDArray[numpy.float64]:
        """
        The same for passes of these sizes. `alpha` belongs to the first pass.
        """
    def walk(self) -> tuple[float, float, int]:
        """
        J and ∫ L·B̃·Ṽ² by a joint walk of the quadtrees, and the number of visited nodes.
        """
    @property
    def dilated(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        ∫ L·B̃·Ṽ^k.
        """
    @property
    def guided(self) -> bool:
        ...
    @property
    def j(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        J per channel.
        """
    @property
    def j_luminance(self) -> float:
        ...
    @property
    def l_ns(self) -> float:
        ...
    @property
    def mean_w(self) -> float:
        ...
    @property
    def variance_w(self) -> float:
        ...
    @property
    def w2(self) -> float:
        """
        ∫ L·B̃·Ṽ² of luminances.
        """
class CachePoints:
    """
    Query points of a cache. d_max is 0 for points without a surface.
    """
    def __init__(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], d_max: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], footprint: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], first_row: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    def __len__(self) -> int:
        ...
    def take(self, indices: typing.Annotated[numpy.typing.ArrayLike, numpy.int64]) -> CachePoints:
        """
        A selection of the points, in this order.
        """
    @property
    def d_max(self) -> numpy.typing.NDArray[numpy.float32]:
        ...
    @property
    def footprint(self) -> numpy.typing.NDArray[numpy.float32]:
        ...
    @property
    def normals(self) -> numpy.typing.NDArray[numpy.float32]:
        ...
    @property
    def positions(self) -> numpy.typing.NDArray[numpy.float32]:
        ...
class PixelRules:
    """
    Search radii of records; see viscache.MapSettings.
    """
    def __init__(self, reach: typing.SupportsFloat | typing.SupportsIndex, most_reach: typing.SupportsFloat | typing.SupportsIndex = 0.10000000149011612, least_cos: typing.SupportsFloat | typing.SupportsIndex = 0.05000000074505806) -> None:
        ...
class MapCacheParameters:
    """
    Parameters of the cache; see viscache.MapSettings.
    """
    @staticmethod
    def parameter_rows() -> list:
        """
        Name, kind, range, uses and doc of every parameter, as the C++ table has them.
        """
    def __getattr__(self, arg0: str) -> typing.Any:
        ...
    def __init__(self, **kwargs) -> None:
        ...
    def __setattr__(self, arg0: str, arg1: typing.Any) -> None:
        ...
class MapCache:
    """
    Records and their tree; see viscache.VisibilityMapCache.
    """
    def __init__(self, parameters: MapCacheParameters) -> None:
        ...
    def __len__(self) -> int:
        ...
    def add_records(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], rays: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], misses: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], last_used: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], ambient: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], nearest_hit: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        Insert records that were traced before.
        """
    def bootstrap(self, scene: viscache._core.Scene, caster: viscache._core.RayCaster, points: CachePoints, frame: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> dict:
        """
        Insert a record at every point; gives what the records predict of each other.
        """
    def insert(self, scene: viscache._core.Scene, caster: viscache._core.RayCaster, points: CachePoints, *, frame: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> dict:
        """
        Insert records where they are needed; gives counts.
        """
    def mark_used(self, points: CachePoints, frame: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        """
        Mark the records that are blended at the points as used in the frame.
        """
    def records(self) -> dict:
        """
        Copies of all stored records, one row each.
        """
    def remove(self, frame: typing.SupportsInt | typing.SupportsIndex) -> dict:
        """
        Removes records as the parameters say; counts.
        """
    def reset_tallies(self) -> None:
        ...
    def select(self, points: CachePoints, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> dict:
        """
        Records that are blended at every point: ids (N, n_best) or −1, their weights beta, and the values of the insertion test.
        """
    def set_thresholds(self, w_min: typing.SupportsFloat | typing.SupportsIndex, delta_max: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    def shade_ambient(self, points: CachePoints, width: typing.SupportsFloat | typing.SupportsIndex, weighted: bool, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        """
        Ambient visibility, records averaged, jump, each (N,).
        """
    def tally(self, rays: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], misses: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], used: typing.Annotated[numpy.typing.ArrayLike, numpy.uint8], frame: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    @property
    def depth(self) -> int:
        ...
    @property
    def extra_bytes_per_record(self) -> int:
        ...
    @property
    def oversized_leaves(self) -> int:
        ...
    @property
    def pattern(self) -> numpy.typing.NDArray[numpy.float32]:
        ...
    @property
    def rebuilds(self) -> int:
        ...
class Relighting:
    """
    See viscache.Relighting.
    """
    @staticmethod
    def trace(scene: viscache._core.Scene, caster: viscache._core.RayCaster, camera: viscache._core.Camera, frame: viscache._core.FrameSettings, cache: MapCache, d_max: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], footprint: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], progress: typing.Any = None) -> Relighting:
        """
        Compute all that does not depend on the light. d_max and footprint belong to the centres of the pixels, (H·W,).
        """
    def image(self, light: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        J of every pixel (H, W, 3) under light (3, 4^m).
        """
    def transfer(self, pixel: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        The factor of every cell's light in one pixel, (4^m, 3).
        """
    @property
    def camera_rays(self) -> int:
        ...
    @property
    def nbytes(self) -> int:
        ...
    @property
    def rays(self) -> int:
        ...
    @property
    def without_record(self) -> int:
        ...
def cell_light(map: viscache._core.sampling.EnvironmentMap, m: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
    """
    Radiance × solid angle of the cells of a map, (3, 4^m), in Z order.
    """
def dilated(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint64]:
    """
    V^level of a map.
    """
def morton2(x: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], y: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> typing.Any:
    """
    Z-order numbers of cells.
    """
def morton_order(positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.uint32]:
    """
    Row numbers of the positions along the Morton curve of their bounding box.
    """
def pixel_points(scene: viscache._core.Scene, caster: viscache._core.RayCaster, camera: viscache._core.Camera, width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, at: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"], rules: PixelRules, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
    """
    First hits through one position inside every pixel, row-major; misses; bad normals.
    """
def points(set: viscache._core.PointSet, count: typing.SupportsInt | typing.SupportsIndex, *, seed: typing.SupportsInt | typing.SupportsIndex = 0, pixel: typing.SupportsInt | typing.SupportsIndex = 0, pass_: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
    """
    Random or randomised (0, 2)-sequence points of the square, (count, 2).
    """
def record_nbytes(m: typing.SupportsInt | typing.SupportsIndex) -> int:
    """
    Size of a record in bytes by the paper's formula.
    """
def record_weight(t: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], theta: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], lambda_: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> typing.Any:
    """
    w of Eq. 9; t = d / d_max, θ in radians.
    """
def sample_points(scene: viscache._core.Scene, caster: viscache._core.RayCaster, camera: viscache._core.Camera, width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex, sample: typing.SupportsInt | typing.SupportsIndex, rules: PixelRules, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
    """
    The same through the position of the sample that `render` takes in every pixel.
    """
def startup_points(scene: viscache._core.Scene, caster: viscache._core.RayCaster, camera: viscache._core.Camera, width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, n: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex, rules: PixelRules) -> tuple:
    """
    First hits of n rays stratified over the image; misses; bad normals.
    """
