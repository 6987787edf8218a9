# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
C++ core of viscache; use the package viscache, not this module.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
__all__: list[str] = ['MaterialKind', 'SceneDescription', 'SceneError', 'active_isa', 'best_isa']
class SceneError(ValueError):
    pass
class MaterialKind(enum.Enum):
    """
    The few materials of viscache.
    """
    DIELECTRIC: typing.ClassVar[MaterialKind]
    DIFFUSE: typing.ClassVar[MaterialKind]
    GLOSSY: typing.ClassVar[MaterialKind]
    MIRROR: typing.ClassVar[MaterialKind]
    @classmethod
    def __new__(cls, value):
        ...
class SceneDescription:
    """
    A scene that can still be changed.
    """
    name: str
    def __init__(self) -> None:
        ...
    def add_camera(self, origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], target: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, up: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 1.0, 0.0], fov_deg: typing.SupportsFloat | typing.SupportsIndex = 45.0, width: typing.SupportsInt | typing.SupportsIndex = 640, height: typing.SupportsInt | typing.SupportsIndex = 400, horizontal: bool = False, name: str = 'camera') -> None:
        """
        `fov_deg` is vertical unless horizontal=True.
        """
    def add_directional_light(self, direction: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], irradiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> None:
        """
        `direction` points towards the light.
        """
    def add_image(self, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> int:
        """
        Add an image (H, W, C), linear; returns its index.
        """
    def add_instance(self, meshes: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> int:
        """
        Place meshes (added with in_world=False) once more.
        """
    def add_material(self, kind: MaterialKind = MaterialKind.DIFFUSE, *, base_color: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.5, 0.5, 0.5], specular: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], roughness: typing.SupportsFloat | typing.SupportsIndex = 0.10000000149011612, eta: typing.SupportsFloat | typing.SupportsIndex = 1.5, two_sided: bool = True, base_texture: typing.SupportsInt | typing.SupportsIndex = -1, alpha_texture: typing.SupportsInt | typing.SupportsIndex = -1, alpha_cutoff: typing.SupportsFloat | typing.SupportsIndex = 0.5) -> int:
        """
        Add a material; returns its index.
        """
    def add_mesh(self, vertices: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], *, material: typing.SupportsInt | typing.SupportsIndex = 0, normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, uvs: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, emission: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], emits_two_sided: bool = False, in_world: bool = True, name: str = '') -> int:
        """
        Add a triangle mesh; returns its index.
        """
    def add_point_light(self, position: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], intensity: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> None:
        """
        Intensity in W/sr.
        """
    def add_sphere_light(self, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, radiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> None:
        ...
    def clear_environment(self) -> None:
        ...
    def set_environment(self, scale: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], *, image: typing.SupportsInt | typing.SupportsIndex = -1, to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None) -> None:
        """
        Constant radiance, or a lat-long image scaled.
        """
    def set_image(self, index: typing.SupportsInt | typing.SupportsIndex, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        Give the pixels of a pending image.
        """
    def warn(self, where: str, text: str) -> None:
        ...
    @property
    def images(self) -> list:
        """
        Path, place, size of every image; width 0 = still to be decoded.
        """
    @property
    def n_lights(self) -> int:
        ...
    @property
    def n_meshes(self) -> int:
        ...
    @property
    def warnings(self) -> list[tuple[str, str]]:
        ...
def active_isa() -> str:
    """
    Variant of the SIMD kernels in use: portable, avx2 or avx512.
    """
def best_isa() -> str:
    """
    Best variant this CPU has.
    """
