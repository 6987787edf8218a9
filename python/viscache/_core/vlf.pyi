# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
The visibility field.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['AlignedBatch', 'DynamicField', 'FIELD_RAY_NS', 'FieldSettings', 'UpdateMode', 'VisibilityField', 'cover_tiles', 'direction_frames', 'direction_weights', 'directions', 'embree_rows', 'expected_references', 'field_rows', 'is_hopeless', 'nearest_direction', 'point_order', 'predict_field_rows', 'predicted_bytes', 'walk_leaves', 'walk_tiles']
class FieldSettings:
    """
    Settings of the field; see viscache.Vlf.
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
class VisibilityField(viscache._core.RayCaster):
    """
    Answers rays by look-up.
    """
    def __init__(self, scene: viscache._core.Scene, settings: FieldSettings, *, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> None:
        ...
    def intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        ...
    def occluded(self: viscache._core.RayCaster, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def subfield(self, direction: typing.SupportsInt | typing.SupportsIndex) -> dict:
        """
        The lists of one direction as arrays.
        """
    def trace_by(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], axes: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], t_min: typing.Any = 0.0, t_max: typing.Any = ...) -> tuple:
        """
        Traces every ray through a given subfield: t, triangle (N,), any (N,), steps of both kinds.
        """
    def visible(self: viscache._core.RayCaster, x: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], y: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible_matrix(self: viscache._core.RayCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
        ...
    @property
    def settings(self) -> FieldSettings:
        ...
    @property
    def stats(self) -> dict:
        ...
class AlignedBatch:
    def __init__(self, scene: viscache._core.Scene) -> None:
        ...
    def choose(self, scene: viscache._core.Scene, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., order: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32] | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple[bool, float, float]:
        """
        True if the batch is the faster engine; predicted ns per ray of the batch and of Embree.
        """
    def rows(self, scene: viscache._core.Scene, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., order: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32] | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, progress: typing.Any = None) -> tuple:
        """
        Bit rows (N, words), 1 = free, and counts of the work.
        """
    def sample(self, scene: viscache._core.Scene, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., order: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32] | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> dict:
        """
        Work per ray of the batch, estimated from a sample of the rays.
        """
    @property
    def bytes(self) -> int:
        ...
    @property
    def triangles(self) -> int:
        ...
class UpdateMode(enum.Enum):
    """
    How objects are inserted into a field.
    """
    IN_PLACE: typing.ClassVar[UpdateMode]
    OVERLAY: typing.ClassVar[UpdateMode]
    @classmethod
    def __new__(cls, value):
        ...
class DynamicField:
    """
    A visibility field over moving objects.
    """
    def __init__(self, scene: viscache._core.Scene, settings: FieldSettings, mode: UpdateMode, *, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> None:
        ...
    def insert(self, vertices: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> int:
        ...
    def intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        """
        t, object, triangle (N,), barycentrics (N, 2).
        """
    def listed(self, direction: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
        """
        Entries (tile, triangle) of the lists of one direction.
        """
    def listed_anew(self, direction: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
        """
        The same of lists that are built from scratch.
        """
    def occluded(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def remove(self, object: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    def transform(self, object: typing.SupportsInt | typing.SupportsIndex, place: typing.Annotated[collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"]], "FixedSize(3)"], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    @property
    def bytes(self) -> int:
        ...
    @property
    def objects(self) -> int:
        ...
    @property
    def settings(self) -> FieldSettings:
        ...
def cover_tiles(triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n_tiles: typing.SupportsInt | typing.SupportsIndex) -> tuple:
    """
    Tiles of triangles in canonical space: (triangle, x, y) (K, 3) and depth ranges (K, 2).
    """
def direction_frames(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Rows u, v, w of (l, 3, 3).
    """
def direction_weights(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Solid angles (l,), in sr.
    """
def directions(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unit axes (l, 3).
    """
def embree_rows(caster: viscache._core.EmbreeCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., by_axis: bool | None = None, width: typing.SupportsInt | typing.SupportsIndex = 16, coherent: bool | None = None, order: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32] | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
    """
    The same bits, traced by Embree.
    """
def expected_references(scene: viscache._core.Scene, n_tiles: typing.SupportsInt | typing.SupportsIndex) -> float:
    """
    Expected number of entries in the lists of one direction, without splits along the depth.
    """
def field_rows(field: VisibilityField, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
    """
    The same bits, looked up in a field of these directions.
    """
def is_hopeless(scene: viscache._core.Scene, points: typing.SupportsInt | typing.SupportsIndex, t_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> bool:
    """
    True if the batch is slower whatever the scene looks like.
    """
def nearest_direction(directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
    """
    Index of the axis nearest to each row.
    """
def point_order(points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.uint32]:
    """
    Indices (N,) of points in the compact order of the engines for aligned rays.
    """
def predict_field_rows(scene: viscache._core.Scene, settings: FieldSettings) -> dict:
    """
    Predicted cost in a field that is still to be built: tests per ray, ray_ns, build_s, bytes (at least).
    """
def predicted_bytes(scene: viscache._core.Scene, settings: FieldSettings, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> int:
    """
    Bytes of a field before it is built.
    """
def walk_leaves(z0: typing.SupportsFloat | typing.SupportsIndex, z1: typing.SupportsFloat | typing.SupportsIndex, leaves: typing.SupportsInt | typing.SupportsIndex, borders: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], low: typing.SupportsFloat | typing.SupportsIndex, high: typing.SupportsFloat | typing.SupportsIndex, upwards: bool, how: str) -> list[int]:
    ...
def walk_tiles(origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], direction: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], n_tiles: typing.SupportsInt | typing.SupportsIndex, t_min: typing.SupportsFloat | typing.SupportsIndex = 0.0, t_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> tuple:
    """
    Tiles (K, 2) and t (K, 2) of a ray in canonical space.
    """
FIELD_RAY_NS: float = 160.0
