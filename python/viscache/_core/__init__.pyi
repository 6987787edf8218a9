# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
C++ core of viscache. Use the package viscache instead of this module.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
from . import aqvc
from . import correlation
from . import sampling
from . import visibility
from . import vismap
from . import vlf
__all__: list[str] = ['AlignedSource', 'AlphaMode', 'AmbientSettings', 'AqvcRows', 'AqvcRowsSource', 'AqvcSource', 'BdptSettings', 'Camera', 'CoatKind', 'CorrectSettings', 'DirectSettings', 'EmbreeCaster', 'ExactSource', 'FrameMaps', 'FrameSettings', 'FrameTableSource', 'FrameTaps', 'GivenAnswers', 'GivenSource', 'IntegratorSettings', 'KeptLights', 'KeptTable', 'KeptTableSource', 'KeptVoxels', 'MaterialKind', 'NeePlusPlusSettings', 'OracleSource', 'PacketOrder', 'PointSet', 'PythonSource', 'PythonTracer', 'RayCaster', 'ResidualSource', 'RouletteSource', 'Scene', 'SceneDescription', 'SceneError', 'ShadowMapSettings', 'ShadowMapSource', 'ShaftScene', 'ShaftSource', 'UnoccludedSource', 'VisMapSettings', 'WhittedSettings', 'active_isa', 'aqvc', 'ask_block', 'ask_pairs', 'best_isa', 'cache_maps', 'correlation', 'counter_rows', 'description_of', 'draw_audit_pixels', 'embree_version', 'geometry_hash', 'load_scene_file', 'look_at', 'read_image', 'render_bdpt', 'render_frame', 'sampling', 'scene_cameras', 'scene_hash', 'scene_instances', 'scene_lights', 'scene_materials', 'scene_mesh', 'scene_mesh_count', 'scene_offset_extent', 'scene_sphere', 'scene_warnings', 'shaft_matrix', 'sky_image', 'sky_radiance', 'sun_direction', 'sun_irradiance', 'trace_eye_points', 'visibility', 'vismap', 'vlf']
class SceneError(ValueError):
    pass
class MaterialKind(enum.Enum):
    """
    Kinds of materials.
    """
    DIELECTRIC: typing.ClassVar[MaterialKind]
    DIFFUSE: typing.ClassVar[MaterialKind]
    GLOSSY: typing.ClassVar[MaterialKind]
    MIRROR: typing.ClassVar[MaterialKind]
    @classmethod
    def __new__(cls, value):
        ...
class CoatKind(enum.Enum):
    """
    Layers over a glossy material.
    """
    BECKMANN: typing.ClassVar[CoatKind]
    FRESNEL_MIX: typing.ClassVar[CoatKind]
    NONE: typing.ClassVar[CoatKind]
    ROUGH: typing.ClassVar[CoatKind]
    SMOOTH: typing.ClassVar[CoatKind]
    @classmethod
    def __new__(cls, value):
        ...
class SceneDescription:
    """
    A scene that can still be changed; `viscache.Scene.from_description` freezes it.
    
    Vectors are three numbers, lengths are in scene units, light is in linear RGB. Positions and
    transforms are given in the world. `origin` is subtracted from them in double precision, before
    they become floats: scenes far from the origin keep their digits.
    """
    def __getstate__(self) -> bytes:
        ...
    def __init__(self, origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0]) -> None:
        ...
    def __setstate__(self, arg0: bytes) -> None:
        ...
    def add_camera(self, origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], target: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, up: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 1.0, 0.0], fov_deg: typing.SupportsFloat | typing.SupportsIndex = 45.0, width: typing.SupportsInt | typing.SupportsIndex = 640, height: typing.SupportsInt | typing.SupportsIndex = 400, horizontal: bool = False, view_height: typing.SupportsFloat | typing.SupportsIndex = 0.0, name: str = 'camera') -> None:
        """
        Add a camera; `fov_deg` is its vertical angle unless horizontal=True, sizes are in pixels. With view_height > 0 it is orthographic, and its picture is so high in scene units.
        """
    def add_directional_light(self, direction: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], irradiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> None:
        """
        Add a directional light: `direction` points towards it, irradiance in W/m² across it.
        """
    def add_image(self, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, nearest: bool = False, wrap: typing.Annotated[collections.abc.Sequence[str], "FixedSize(2)"] = ('repeat', 'repeat')) -> int:
        """
        Add an image (H, W, C), linear; returns its index. With nearest=True, its pixels have hard edges.
        `wrap` is what it shows beyond its borders along u and v: "repeat", "mirror" or "clamp".
        """
    def add_instance(self, meshes: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> int:
        """
        Add an instance of meshes (added with in_world=False) by an affine (3, 4) or (4, 4) matrix; returns
        its index.
        """
    def add_material(self, kind: MaterialKind = MaterialKind.DIFFUSE, *, base_color: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.5, 0.5, 0.5], specular: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], roughness: typing.SupportsFloat | typing.SupportsIndex = 0.10000000149011612, eta: typing.SupportsFloat | typing.SupportsIndex = 1.5, two_sided: bool = True, base_texture: typing.SupportsInt | typing.SupportsIndex = -1, alpha_texture: typing.SupportsInt | typing.SupportsIndex = -1, alpha_cutoff: typing.SupportsFloat | typing.SupportsIndex = 0.5, coat: CoatKind = CoatKind.NONE, nonlinear: bool = False, thin: bool = False, opacity: typing.SupportsFloat | typing.SupportsIndex = 1.0, metallic: typing.SupportsFloat | typing.SupportsIndex = 0.0, metallic_roughness_texture: typing.SupportsInt | typing.SupportsIndex = -1, roughness_texture: typing.SupportsInt | typing.SupportsIndex = -1, metal_eta: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], metal_k: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], beckmann: bool = False, f90: typing.SupportsFloat | typing.SupportsIndex = 1.0, transmission: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0]) -> int:
        """
        Add a material; returns its index. Colours and roughness are in [0, 1], eta is the index of
        refraction, textures are indices of images, -1 for none. A coat covers a glossy material: a
        dielectric layer of index eta, smooth or of the roughness; then specular scales its
        reflection, and nonlinear lets light that scatters under it shift colours. A dielectric can be
        thin: a plate without thickness. opacity in [0, 1] is the share of the surface that is there;
        the rest are small holes in a fixed pattern. A negative alpha_cutoff takes alpha_texture for
        such shares too. A glossy material without a coat can be metallic
        in [0, 1]: that share of its base colour becomes its specular colour. Its roughness can have an
        image: the green channel of metallic_roughness_texture multiplies the root of roughness and the
        blue one multiplies metallic, as in glTF; the values of roughness_texture multiply roughness.
        A mirror, or a glossy material with a base_color of 0, can be a metal of the complex index
        metal_eta + i·metal_k, relative to what is outside; then specular scales its reflection. Both 0:
        its reflectance at normal incidence is specular. Microfacets are GGX's, or Beckmann's with
        beckmann=True; those of a rough coat are named by its kind.
        With the coat fresnel_mix the base loses what the lobe's Schlick term, from specular to f90,
        reflects at the half vector, as glTF defines it; a thin dielectric with it reflects by that
        term. A thin glossy material with it is a sheet: it lets transmission, less what the lobe
        reflects, straight through. transmission is also the tint of glass: the factor of light at each
        surface that it passes; base_texture multiplies it. Rays to lights end at glass and sheets.
        """
    def add_mesh(self, vertices: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], *, material: typing.SupportsInt | typing.SupportsIndex = 0, normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, uvs: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, emission: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], emits_two_sided: bool = False, in_world: bool = True, name: str = '', emission_texture: typing.SupportsInt | typing.SupportsIndex = -1) -> int:
        """
        Add a triangle mesh: vertices (V, 3), triangles (T, 3) indices, normals (V, 3) unit, uvs (V, 2),
        emission in W/(m²·sr), emission_texture the index of an image that multiplies it, -1 for none.
        Returns its index.
        """
    def add_point_light(self, position: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], intensity: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, axis: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] | None = None, cone_deg: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [30.0, 40.0], falloff: str = 'smooth') -> None:
        """
        Add a point light; intensity in W/sr. With an `axis` it is a spot light: the whole intensity within
        the first angle of `cone_deg`, none beyond the second (in degrees from the axis). Between them,
        `falloff` is t ("angle", t linear in the angle), or t² ("quadratic"), t⁴ ("quartic") or
        t²(3 - 2t) ("smooth") with t linear in the cosine.
        """
    def add_point_lights(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], intensities: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        Add point lights, (M, 3) each; intensities in W/sr.
        """
    def add_sphere_light(self, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, radiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> None:
        """
        Add a sphere that emits; radiance in W/(m²·sr).
        """
    def bounds(self) -> tuple[typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"]]:
        """
        Lowest and highest corner of the placed meshes and the sphere lights.
        """
    def clear_environment(self) -> None:
        """
        Remove the environment.
        """
    def image_pixels(self, index: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
        """
        Linear pixels (H, W, C) of a decoded image.
        """
    def mesh_arrays(self, index: typing.SupportsInt | typing.SupportsIndex) -> dict:
        """
        vertices, triangles, normals, uvs of one mesh.
        """
    def set_environment(self, scale: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], *, image: typing.SupportsInt | typing.SupportsIndex = -1, to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None) -> None:
        """
        Light from infinity: constant radiance in W/(m²·sr), or a lat-long image (an index) times scale.
        """
    def set_image(self, index: typing.SupportsInt | typing.SupportsIndex, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        Set the pixels of a pending image.
        """
    def warn(self, where: str, text: str) -> None:
        """
        Add a warning for the scene's users, with its place.
        """
    @property
    def cameras(self) -> list:
        """
        A dict per camera.
        """
    @property
    def images(self) -> list:
        """
        Path, place, size and bits per value of every image; width 0 = still to be decoded.
        """
    @property
    def instances(self) -> list:
        """
        A dict per instance.
        """
    @property
    def lights(self) -> list:
        """
        A dict per light.
        """
    @property
    def materials(self) -> list:
        """
        A dict per material.
        """
    @property
    def meshes(self) -> list:
        """
        A dict per mesh, without its arrays.
        """
    @property
    def n_lights(self) -> int:
        """
        Lights added so far: emitting meshes and the environment count as one each.
        """
    @property
    def n_meshes(self) -> int:
        """
        Meshes added so far.
        """
    @property
    def name(self) -> str:
        """
        Name that is shown with the scene.
        """
    @name.setter
    def name(self, arg0: str) -> None:
        ...
    @property
    def origin(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        The point of the world at (0, 0, 0).
        """
    @property
    def triangle_count(self) -> int:
        """
        Placed triangles.
        """
    @property
    def warnings(self) -> list[tuple[str, str]]:
        """
        Place and text of every warning.
        """
class Scene:
    """
    An immutable scene.
    """
    @staticmethod
    def freeze(description: SceneDescription, threads: typing.SupportsInt | typing.SupportsIndex = 0, take: bool = False) -> Scene:
        """
        Validate and freeze a description. `take` leaves it empty, without a copy.
        """
    @property
    def bounds(self) -> tuple[typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"]]:
        ...
    @property
    def center(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        ...
    @property
    def instances(self) -> int:
        ...
    @property
    def memory_bytes(self) -> int:
        ...
    @property
    def name(self) -> str:
        ...
    @property
    def offset_extent(self) -> float:
        ...
    @property
    def origin(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        ...
    @property
    def radius(self) -> float:
        ...
    @property
    def triangles(self) -> int:
        ...
    @property
    def unique_triangles(self) -> int:
        ...
class RayCaster:
    """
    Which rays hit, and where?
    """
class EmbreeCaster(RayCaster):
    """
    Exact rays by Embree.
    """
    def __init__(self, scene: Scene, *, robust: bool = True) -> None:
        ...
    def bare_intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float32]:
        """
        Distances of nearest hits by one call of Embree per ray: the baseline of single-ray tracers.
        """
    def bare_occluded(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.SupportsFloat | typing.SupportsIndex, width: typing.SupportsInt | typing.SupportsIndex, *, coherent: bool = False, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        """
        Baseline of `viscache bench rays`: a loop with one packet width and no checks.
        """
    def intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        ...
    def occluded(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, threads: typing.SupportsInt | typing.SupportsIndex = 0, *, way: str | None = None) -> numpy.typing.NDArray[numpy.bool]:
        """
        Any hits. `way` (coherent, as_given or sorted) fixes what otherwise follows from the rays.
        """
    def visible(self: RayCaster, x: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], y: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible_matrix(self: RayCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
        ...
    @property
    def native16(self) -> bool:
        ...
class PointSet(enum.Enum):
    """
    Point sets on the unit square.
    """
    INDEPENDENT: typing.ClassVar[PointSet]
    ZERO_TWO: typing.ClassVar[PointSet]
    @classmethod
    def __new__(cls, value):
        ...
class PacketOrder(enum.Enum):
    """
    Which exact shadow rays share a packet.
    """
    BY_LIGHT: typing.ClassVar[PacketOrder]
    BY_PIXEL: typing.ClassVar[PacketOrder]
    @classmethod
    def __new__(cls, value):
        ...
class IntegratorSettings:
    """
    Of integrators that shade eye points.
    """
class DirectSettings(IntegratorSettings):
    """
    See viscache.Direct.
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
class WhittedSettings(IntegratorSettings):
    """
    See viscache.Whitted.
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
class AmbientSettings(IntegratorSettings):
    """
    See viscache.AmbientOcclusion.
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
class BdptSettings:
    """
    See viscache.Bdpt.
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
class FrameSettings:
    """
    Size, samples, seed and threads of a frame.
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
class Camera:
    """
    A camera; made by `viscache.look_at`, `viscache.orthographic` or a scene file.
    """
    def __getstate__(self) -> tuple[str, typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"], float, int, int, bool, float, float, float]:
        ...
    def __setstate__(self, arg0: tuple[str, typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, bool, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex]) -> None:
        ...
    @property
    def forward(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        Viewing direction, a unit vector.
        """
    @property
    def fov_is_horizontal(self) -> bool:
        """
        Whether `fov_rad` is the horizontal angle.
        """
    @fov_is_horizontal.setter
    def fov_is_horizontal(self, arg0: bool) -> None:
        ...
    @property
    def fov_rad(self) -> float:
        """
        Full angle of view in radians.
        """
    @fov_rad.setter
    def fov_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def height(self) -> int:
        """
        Pixels.
        """
    @height.setter
    def height(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    @property
    def name(self) -> str:
        """
        Its name in the scene file.
        """
    @name.setter
    def name(self, arg0: str) -> None:
        ...
    @property
    def origin(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        Position in scene units.
        """
    @property
    def right(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        Unit vector to the right in the picture.
        """
    @property
    def shift_x(self) -> float:
        """
        How far the picture's centre lies right of the axis, in widths of the picture.
        """
    @shift_x.setter
    def shift_x(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def shift_y(self) -> float:
        """
        How far the picture's centre lies above the axis, in heights of the picture.
        """
    @shift_y.setter
    def shift_y(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def up(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        Unit vector upwards in the picture.
        """
    @property
    def view_height(self) -> float:
        """
        Orthographic cameras: height of the picture in scene units, or its width where `fov_is_horizontal`. 0: a pinhole.
        """
    @view_height.setter
    def view_height(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def width(self) -> int:
        """
        Pixels.
        """
    @width.setter
    def width(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
class AqvcRows:
    """
    See viscache.AqvcRows.
    """
    def __init__(self, max_bytes: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def begin_restore(self, tiles: typing.SupportsInt | typing.SupportsIndex, frames: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def clear(self) -> None:
        ...
    def commit(self) -> None:
        ...
    def restore(self, tile: typing.SupportsInt | typing.SupportsIndex, group: typing.SupportsInt | typing.SupportsIndex, digest: typing.SupportsInt | typing.SupportsIndex, row_words: typing.SupportsInt | typing.SupportsIndex, cells: typing.Annotated[numpy.typing.ArrayLike, numpy.int64], rows: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64]) -> None:
        ...
    def state(self, tile: typing.SupportsInt | typing.SupportsIndex, group: typing.SupportsInt | typing.SupportsIndex) -> tuple:
        """
        (digest, row_words, cells, rows) of finished frames.
        """
    @property
    def bytes(self) -> int:
        ...
    @property
    def cells(self) -> int:
        ...
    @property
    def frames(self) -> int:
        ...
    @property
    def tiles(self) -> int:
        ...
class KeptTable:
    """
    See viscache.AqvcTable.
    """
    def __init__(self, table_bytes: typing.SupportsInt | typing.SupportsIndex, parameters: aqvc.AqvcParameters) -> None:
        ...
    def entries(self) -> numpy.ndarray:
        """
        Occupied slots in ascending order: slot, digest, visible, current.
        """
    def next_epoch(self) -> None:
        ...
    @property
    def epoch(self) -> int:
        ...
    @property
    def frames(self) -> int:
        ...
    @property
    def occupied(self) -> int:
        ...
    @property
    def slots(self) -> int:
        ...
class NeePlusPlusSettings:
    """
    See viscache.NeePlusPlus.
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
class KeptVoxels:
    """
    See viscache.VoxelCounts.
    """
    def __init__(self) -> None:
        ...
    def commit(self) -> None:
        ...
    def restore(self, scene: Scene, settings: NeePlusPlusSettings, frames: typing.SupportsInt | typing.SupportsIndex, place: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], tested: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], seen: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> None:
        """
        Sets what `state` gave, in an object without frames.
        """
    def roll_back(self) -> None:
        ...
    def state(self) -> tuple:
        """
        Places, tests and unblocked tests (N,) of all pairs with tests.
        """
    @property
    def bytes(self) -> int:
        ...
    @property
    def frames(self) -> int:
        ...
    @property
    def pairs_tested(self) -> int:
        ...
class AlphaMode(enum.Enum):
    """
    How the control variate's α is chosen.
    """
    FIXED: typing.ClassVar[AlphaMode]
    LEAVE_ONE_OUT: typing.ClassVar[AlphaMode]
    PREVIOUS_PASS: typing.ClassVar[AlphaMode]
    @classmethod
    def __new__(cls, value):
        ...
class VisMapSettings:
    """
    See viscache.VisMaps.
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
class FrameMaps:
    """
    Visibility maps for the environment light of one frame.
    """
class OracleSource:
    """
    Makes the oracles of one frame.
    """
class ExactSource(OracleSource):
    """
    See viscache.Exact.
    """
    def __init__(self, scene: Scene, caster: RayCaster, *, order: PacketOrder | None = None, coherent: bool | None = None) -> None:
        ...
class UnoccludedSource(OracleSource):
    """
    See viscache.Unoccluded.
    """
    def __init__(self) -> None:
        ...
class AlignedSource(OracleSource):
    """
    Exact rays. A batch may trace shared directions.
    """
    def __init__(self, scene: Scene, caster: RayCaster, batch: vlf.AlignedBatch, *, choose: bool, order: PacketOrder | None = None, coherent: bool | None = None) -> None:
        ...
class AqvcSource(OracleSource):
    """
    See viscache.Aqvc.
    """
    def __init__(self, scene: Scene, caster: RayCaster, parameters: aqvc.AqvcParameters, *, spp: typing.SupportsInt | typing.SupportsIndex, exact: OracleSource | None = None) -> None:
        ...
class FrameTableSource(OracleSource):
    """
    A quantized cache with one table per frame; see viscache.Bdpt.
    """
    def __init__(self, scene: Scene, caster: RayCaster, parameters: aqvc.AqvcParameters, *, spp: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
class KeptTableSource(OracleSource):
    """
    See viscache.AqvcTable.
    """
    def __init__(self, scene: Scene, caster: RayCaster, parameters: aqvc.AqvcParameters, table: KeptTable, *, spp: typing.SupportsInt | typing.SupportsIndex, check: typing.SupportsFloat | typing.SupportsIndex, repair: bool) -> None:
        ...
class AqvcRowsSource(OracleSource):
    """
    See viscache.AqvcRows.
    """
    def __init__(self, scene: Scene, caster: RayCaster, parameters: aqvc.AqvcParameters, rows: AqvcRows, *, spp: typing.SupportsInt | typing.SupportsIndex, exact: OracleSource | None = None) -> None:
        ...
class ShadowMapSettings:
    """
    See viscache.ShadowMap.
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
class ShadowMapSource(OracleSource):
    """
    See viscache.ShadowMap.
    """
    def __init__(self, scene: Scene, caster: RayCaster, settings: ShadowMapSettings) -> None:
        ...
class RouletteSource(OracleSource):
    """
    See viscache.NeePlusPlus.
    """
    @staticmethod
    def correct(scene: Scene, caster: RayCaster, settings: NeePlusPlusSettings, *, share: typing.SupportsFloat | typing.SupportsIndex | None = None, certain: typing.SupportsFloat | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex, lasting_seed: typing.SupportsInt | typing.SupportsIndex = 0, weighted: bool = True, keep: KeptVoxels | None = None) -> RouletteSource:
        """
        The means of voxels as a control variate.
        """
    def __init__(self, scene: Scene, caster: RayCaster, settings: NeePlusPlusSettings, *, seed: typing.SupportsInt | typing.SupportsIndex, weighted: bool = True, keep: KeptVoxels | None = None) -> None:
        ...
class CorrectSettings:
    """
    See viscache.Correct.
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
class ResidualSource(OracleSource):
    """
    See viscache.Correct.
    """
    def __init__(self, scene: Scene, caster: RayCaster, inner: OracleSource, *, share: typing.SupportsFloat | typing.SupportsIndex | None, certain: typing.SupportsFloat | typing.SupportsIndex = 0.015625, seed: typing.SupportsInt | typing.SupportsIndex, lasting_seed: typing.SupportsInt | typing.SupportsIndex = 0, octaves: typing.Annotated[collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(8)"]], "FixedSize(8)"] = [[1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1]], weighted: bool = True) -> None:
        ...
class ShaftScene:
    """
    The triangles of a scene for shafts; the tree is built on first use.
    """
    def __init__(self, scene: Scene, *, max_bytes: typing.SupportsInt | typing.SupportsIndex = 4294967296) -> None:
        ...
    def memory_bytes(self, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> int:
        """
        Bytes of the tree, which is built if it does not exist.
        """
    @property
    def refusal(self) -> str:
        """
        Why packets answer everything; empty if shafts can be used.
        """
class ShaftSource(OracleSource):
    """
    See viscache.Exact.
    """
    def __init__(self, scene: Scene, caster: RayCaster, shafts: ShaftScene, exact: OracleSource, *, choose: bool = False, bounds: typing.SupportsFloat | typing.SupportsIndex = 1, isa: str | None = None) -> None:
        ...
class KeptLights:
    """
    The shared lights of a frame, for frames of the same scene, integrator, size and seed.
    """
    def __init__(self) -> None:
        ...
class FrameTaps:
    """
    All queries of a frame; see viscache.connections.
    """
    def __init__(self, scene: Scene, caster: RayCaster, camera: Camera, integrator: IntegratorSettings, frame: FrameSettings) -> None:
        ...
    def ask(self, source: OracleSource) -> dict:
        ...
    def contributions(self, group: typing.SupportsInt | typing.SupportsIndex, begin: typing.SupportsInt | typing.SupportsIndex, end: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
        ...
    def lights(self) -> list:
        ...
    def sample_groups(self) -> list:
        ...
    def samples(self, group: typing.SupportsInt | typing.SupportsIndex) -> dict:
        ...
    def tiles(self) -> list:
        ...
    def wanted(self, light: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint64]:
        ...
    @property
    def rows(self) -> int:
        ...
class GivenSource(OracleSource):
    """
    Oracles that give stored answers.
    """
class GivenAnswers:
    """
    Stored answers for one frame.
    """
    def __init__(self, taps: FrameTaps) -> None:
        ...
    def block(self, group: typing.SupportsInt | typing.SupportsIndex, bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None, columns: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def samples(self, group: typing.SupportsInt | typing.SupportsIndex, visible: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None, order: collections.abc.Sequence[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]], run_end: collections.abc.Sequence[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]]) -> None:
        ...
    def source(self) -> GivenSource:
        ...
class PythonTracer:
    """
    Traces exact rays for an oracle written in Python.
    """
    def block(self, eyes: dict, ends: dict, wanted: typing.Any) -> numpy.typing.NDArray[numpy.uint64]:
        ...
    def pairs(self, eyes: dict, index: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], ends: dict) -> numpy.typing.NDArray[numpy.bool]:
        ...
class PythonSource(OracleSource):
    """
    Makes oracles from a class written in Python.
    """
    def __init__(self, scene: Scene, caster: RayCaster, written: typing.Any) -> None:
        ...
def active_isa() -> str:
    """
    Variant of the SIMD kernels in use: portable, avx2 or avx512.
    """
def ask_block(source: OracleSource, eyes: typing.Any, ends: dict, *, wanted: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64] | None = None, contributions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, log: tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex] = (0, 0), extent: typing.SupportsFloat | typing.SupportsIndex, most: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex) -> dict:
    """
    All eye points × all far ends: bits, weights, counters, timings and log. `eyes` is one dict of arrays, cut into tiles of `most` points, or a list of the tiles of a frame.
    """
def ask_pairs(source: OracleSource, eyes: typing.Any, index: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], ends: dict, *, extent: typing.SupportsFloat | typing.SupportsIndex, most: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex) -> dict:
    """
    Connection k joins eye point index[k] with far end k.
    """
def best_isa() -> str:
    """
    Best variant that this CPU supports.
    """
def cache_maps(settings: VisMapSettings, cache: vismap.MapCache, frame: FrameSettings, d_max: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], footprint: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, replace: bool = False, count_misses: bool = False, cache_frame: typing.SupportsInt | typing.SupportsIndex = 0) -> FrameMaps:
    """
    The maps of a cache, which must not change while the frame is rendered. d_max and footprint belong to the centres of the pixels, (H·W,).
    """
def counter_rows() -> dict:
    """
    What each counter of a frame counts, by name.
    """
def description_of(scene: Scene) -> SceneDescription:
    """
    A description of the scene that can be changed.
    """
def draw_audit_pixels(light: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex, first_sample: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
    """
    Pixels of an audit (n, 3): x, y, weight; two of each stratum, one after the other. `light` (H, W): light without shadows.
    """
def embree_version() -> str:
    ...
def geometry_hash(scene: Scene) -> str:
    ...
def load_scene_file(path: str, strict: bool = False, skip_missing: bool = False, allow_outside: bool = False, origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0]) -> SceneDescription:
    """
    Read a scene file (.obj .ply .gltf .glb .xml .pbrt .serialized); SceneError says what cannot be used.
    """
def look_at(origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], target: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], up: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], fov_deg: typing.SupportsFloat | typing.SupportsIndex) -> Camera:
    """
    Pinhole camera at `origin` looking at `target`; `fov_deg` is the vertical angle of view.
    """
def read_image(path: str) -> numpy.typing.NDArray[numpy.float32]:
    """
    Linear pixels (H, W, C) of a PNG, JPEG, HDR, TGA or BMP file.
    """
def render_bdpt(scene: Scene, caster: RayCaster, camera: Camera, settings: BdptSettings, frame: FrameSettings, source: OracleSource, *, progress: typing.Any = None) -> dict:
    """
    A frame of bidirectional paths. `source` serves one frame.
    """
def render_frame(scene: Scene, caster: RayCaster, camera: Camera, integrator: IntegratorSettings, frame: FrameSettings, source: OracleSource, *, maps: FrameMaps | None = None, batch: vlf.AlignedBatch | None = None, field: vlf.VisibilityField | None = None, lights: KeptLights | None = None, progress: typing.Any = None) -> dict:
    """
    A frame of direct light, virtual point lights or ambient occlusion. `source` serves one frame. `batch` and `field` may trace the shared directions of ambient occlusion. `lights` are kept for frames with the same shared lights.
    """
def scene_cameras(scene: Scene) -> list[Camera]:
    ...
def scene_hash(scene: Scene) -> str:
    ...
def scene_instances(scene: Scene) -> list:
    """
    (meshes, to_world (3, 4)) of every instance.
    """
def scene_lights(scene: Scene) -> list:
    ...
def scene_materials(scene: Scene) -> list:
    ...
def scene_mesh(scene: Scene, index: typing.SupportsInt | typing.SupportsIndex) -> dict:
    """
    Arrays of one mesh.
    """
def scene_mesh_count(scene: Scene) -> int:
    ...
def scene_offset_extent(scene: Scene) -> float:
    """
    The length that scales the offsets of ray origins.
    """
def scene_sphere(scene: Scene) -> typing.Annotated[list[float], "FixedSize(4)"]:
    """
    Bounding sphere: centre and radius.
    """
def scene_warnings(scene: Scene) -> list[tuple[str, str]]:
    ...
def shaft_matrix(scene: ShaftScene, caster: RayCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, choose: bool = False, bounds: typing.SupportsFloat | typing.SupportsIndex = 1, isa: str | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> tuple:
    """
    The bits of RayCaster.visible_matrix by shafts, and what they did.
    """
def sky_image(to_sun: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], turbidity: typing.SupportsFloat | typing.SupportsIndex, albedo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], width: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Lat-long image (width / 2, width, 3) of the clear sky without its sun; y points up.
    """
def sky_radiance(to_sun: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], turbidity: typing.SupportsFloat | typing.SupportsIndex, albedo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Radiance of the clear sky from directions (N, 3); y points up.
    """
def sun_direction(*, year: typing.SupportsInt | typing.SupportsIndex, month: typing.SupportsInt | typing.SupportsIndex, day: typing.SupportsInt | typing.SupportsIndex, hour: typing.SupportsFloat | typing.SupportsIndex, timezone: typing.SupportsFloat | typing.SupportsIndex, latitude: typing.SupportsFloat | typing.SupportsIndex, longitude: typing.SupportsFloat | typing.SupportsIndex) -> typing.Annotated[list[float], "FixedSize(3)"]:
    """
    Direction to the sun: east, up, north.
    """
def sun_irradiance(to_sun: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], turbidity: typing.SupportsFloat | typing.SupportsIndex) -> typing.Annotated[list[float], "FixedSize(3)"]:
    """
    Irradiance of the sun on a surface that faces it.
    """
def trace_eye_points(scene: Scene, caster: RayCaster, camera: Camera, integrator: IntegratorSettings, frame: FrameSettings) -> dict:
    """
    Eye points of a whole frame: position, normal, origin, throughput (N, 3), density and pixel (N,).
    """
