# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Samplers and their densities, as tests and notebooks use them.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['Distribution1D', 'EnvironmentMap', 'PatternKind', 'ShadingPoint', 'diffuse_albedo', 'direction_pattern', 'direction_to_equal_area', 'direction_to_octahedral', 'equal_area_to_direction', 'eval_bsdf', 'fresnel_dielectric', 'ggx_d', 'glossy_sum', 'hemisphere_batch', 'octahedral_to_direction', 'pdf_bsdf', 'pdf_cosine_hemisphere', 'pdf_ggx_vndf', 'pdf_uniform_cone', 'pdf_uniform_hemisphere', 'pdf_uniform_sphere', 'radical_inverse', 'random', 'random_u32', 'reflect_directions', 'refract', 'sample_bsdf', 'sample_ggx_vndf', 'sample_sphere_light', 'schlick', 'smith_g1', 'smith_g2', 'sobol02', 'sphere_batch', 'square_to_cosine_hemisphere', 'square_to_disk_concentric', 'square_to_triangle', 'square_to_uniform_cone', 'square_to_uniform_hemisphere', 'square_to_uniform_sphere']
class EnvironmentMap:
    """
    Environment light on the equal-area octahedral map.
    """
    @staticmethod
    def constant(radiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> EnvironmentMap:
        ...
    @staticmethod
    def from_latlong(pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, scale: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, resolution: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> EnvironmentMap:
        """
        Resample a lat-long image (H, W, C); to_world (3, 3) rotates the map into the world.
        """
    def eval(self, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
        """
        Radiance from unit vectors (N, 3), (N, 3).
        """
    def pdf(self, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
        """
        Density of `sample` per solid angle, (N,).
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
        """
        Directions (N, 3), radiances (N, 3) and densities (N,).
        """
    @property
    def is_constant(self) -> bool:
        ...
    @property
    def pixels(self) -> numpy.ndarray:
        ...
    @property
    def power_ratio(self) -> float:
        ...
    @property
    def resolution(self) -> int:
        ...
    @property
    def total_power(self) -> float:
        ...
class ShadingPoint:
    """
    What reflection needs at a point.
    """
    def __init__(self, kind: viscache._core.MaterialKind, wo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, ns: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 1.0], ng: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 1.0], base: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], specular: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], roughness: typing.SupportsFloat | typing.SupportsIndex = 0.10000000149011612, eta: typing.SupportsFloat | typing.SupportsIndex = 1.5) -> None:
        ...
class Distribution1D:
    """
    Indices with given, piecewise constant probability.
    """
    def __init__(self, weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> None:
        ...
    def __len__(self) -> int:
        ...
    def pmf(self, index: typing.SupportsInt | typing.SupportsIndex) -> float:
        """
        Probability of an index.
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]]:
        """
        Index, its probability and the stretched rest of u, each (N,).
        """
    @property
    def total(self) -> float:
        ...
class PatternKind(enum.Enum):
    """
    Where in its cell a direction lies.
    """
    CENTRES: typing.ClassVar[PatternKind]
    JITTERED: typing.ClassVar[PatternKind]
    LLOYD: typing.ClassVar[PatternKind]
    @classmethod
    def __new__(cls, value):
        ...
def diffuse_albedo(sp: ShadingPoint) -> typing.Annotated[list[float], "FixedSize(3)"]:
    """
    Albedo of the diffuse part alone for light from wo.
    """
def direction_pattern(map_size: typing.SupportsInt | typing.SupportsIndex, kind: PatternKind, seed: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unit vectors (map_size², 3), one in each cell of the equal-area map, row by row.
    """
def direction_to_equal_area(d: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Equal-area octahedral map of unit vectors (N, 3) into [0, 1]², (N, 2).
    """
def direction_to_octahedral(d: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Octahedral map of directions (N, 3) into [0, 1]², (N, 2).
    """
def equal_area_to_direction(p: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Its inverse: (N, 2) to unit vectors (N, 3).
    """
def eval_bsdf(sp: ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    f without the cosine, (N, 3).
    """
def fresnel_dielectric(cos_i: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], eta: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unpolarised reflectance; cos_i < 0: from inside.
    """
def ggx_d(h: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density of microfacet normals (N, 3), local frame.
    """
def glossy_sum(sp: ShadingPoint, position: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], value: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], bound2: typing.SupportsFloat | typing.SupportsIndex, seen: collections.abc.Sequence[bool], isa: str | None = None) -> tuple:
    """
    Sum of f·g·value over the columns that are seen.
    """
def hemisphere_batch(scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex, normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], cosine: bool = True, isa: str | None = None) -> tuple:
    """
    The first 32 directions (N, 3) of a randomised (0,2)-sequence around a normal, and their cosines.
    """
def octahedral_to_direction(p: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Its inverse: (N, 2) to unit vectors (N, 3).
    """
def pdf_bsdf(sp: ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density of `sample_bsdf` per solid angle, (N,).
    """
def pdf_cosine_hemisphere(w: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density per solid angle, (N,).
    """
def pdf_ggx_vndf(wo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], h: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density per solid angle of the normals h (N, 3).
    """
def pdf_uniform_cone(cos_max: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Density per solid angle.
    """
def pdf_uniform_hemisphere() -> float:
    """
    Density per solid angle.
    """
def pdf_uniform_sphere() -> float:
    """
    Density per solid angle.
    """
def radical_inverse(base: typing.SupportsInt | typing.SupportsIndex, index: typing.SupportsInt | typing.SupportsIndex) -> float:
    """
    Digits of `index` mirrored at the radix point, in [0, 1).
    """
def random(keys: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], count: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    The same streams as floats in [0, 1).
    """
def random_u32(keys: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], count: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
    """
    First `count` numbers of each stream; keys (N, 4) are (seed, purpose, pixel, pass). (N, count) uint32.
    """
def reflect_directions(sp: ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, isa: str | None = None) -> tuple:
    """
    f·cos (N, 3) and densities of `sample_bsdf` (N,).
    """
def refract(wo: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], eta_ratio: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Refracted directions (N, 3); NaN: total reflection.
    """
def sample_bsdf(sp: ShadingPoint, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
    """
    Directions (N, 3), weights f·cos/pdf (N, 3) and densities (N,) for u (N, 3); density 0: no sample.
    """
def sample_ggx_vndf(wo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], alpha: typing.SupportsFloat | typing.SupportsIndex, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Microfacet normals visible from wo (wo.z > 0), (N, 3).
    """
def sample_sphere_light(center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, origin: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> typing.Any:
    """
    Points, normals, densities per solid angle and per area; None unless `origin` is outside.
    """
def schlick(f0: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], cosine: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Fresnel reflectance from that at normal incidence, (N, 3).
    """
def smith_g1(cos_w: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Share of the microfacets that a direction sees.
    """
def smith_g2(cos_i: typing.SupportsFloat | typing.SupportsIndex, cos_o: typing.SupportsFloat | typing.SupportsIndex, alpha: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Separable: G1 · G1.
    """
def sobol02(index: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Points of the Owen-scrambled (0, 2)-sequence, (N, 2) in [0, 1).
    """
def sphere_batch(scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex, *, first: typing.SupportsInt | typing.SupportsIndex = 0, n: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    Directions (n, 3) of a randomised (0,2)-sequence, even over the sphere.
    """
def square_to_cosine_hemisphere(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Cosine-weighted around +z, (N, 3).
    """
def square_to_disk_concentric(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Uniform on the unit disk, (N, 2).
    """
def square_to_triangle(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Weights of vertices 1 and 2, (N, 2).
    """
def square_to_uniform_cone(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], cos_max: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Uniform in the cone around +z, (N, 3).
    """
def square_to_uniform_hemisphere(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Uniform around +z, (N, 3).
    """
def square_to_uniform_sphere(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Uniform on the sphere, (N, 3).
    """
