# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
What tests alone ask for: equations and parts of structures.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
import viscache._core
import viscache._core.sampling
import viscache._core.visibility
import viscache._core.vismap
import viscache._core.vlf
__all__: list[str] = ['Distribution1D', 'KdTree', 'ProductTree', 'ambient_visibility', 'best_alpha', 'control_variate_estimate', 'correlation', 'diffuse_albedo', 'direction_to_octahedral', 'expected_build_s', 'flat_triangles', 'fresnel_dielectric', 'gather2', 'geometric_weight', 'ggx_d', 'glossy_sum', 'hemisphere_batch', 'hierarchy', 'least_residual_variance', 'map_differences', 'node_codes', 'normal_angle', 'normalized_weight', 'octahedral_to_direction', 'pdf_bsdf', 'pdf_cosine_hemisphere', 'pdf_ggx_vndf', 'pdf_uniform_cone', 'pdf_uniform_hemisphere', 'pdf_uniform_sphere', 'product_terms', 'radical_inverse', 'random', 'random_u32', 'record_pattern', 'reflect_directions', 'reflection_at_nodes', 'refract', 'regressed_alpha', 'residual_variance', 'sample_bsdf', 'sample_ggx_vndf', 'sample_sphere_light', 'schlick', 'shared_axes', 'smith_g1', 'smith_g2', 'sobol02', 'solid_at', 'sphere_batch', 'square_to_cosine_hemisphere', 'square_to_disk_concentric', 'square_to_triangle', 'square_to_uniform_cone', 'square_to_uniform_hemisphere', 'square_to_uniform_sphere', 'tile_depth', 'triangle_hits', 'wilson_lower']
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
class ProductTree:
    """
    L·B̃ over the sphere for one point, to draw directions from.
    """
    @staticmethod
    def of_surface(light: viscache._core.vismap.EnvironmentPyramid, shading: viscache._core.sampling.ShadingPoint, map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        ...
    @staticmethod
    def of_table(light: viscache._core.vismap.EnvironmentPyramid, b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        """
        From B as a table over the map, (N, N, 3).
        """
    def b_tilde(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        B̃ of the texels, (R, R, 3).
        """
    def masses(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        Integrals of L·B̃ over the nodes of a level along the Morton curve.
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple:
        """
        Texels drawn by points (N, 2) of the square, row-major numbers (N,), and directions (N, 3).
        """
    def texel_masses(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Integrals of L·B̃ over the texels, (R, R); over L_ns the probability to be drawn.
        """
    @property
    def dense_level(self) -> int:
        ...
    @property
    def leaves(self) -> int:
        ...
    @property
    def total(self) -> float:
        """
        L_ns, the integral of L·B̃.
        """
class KdTree:
    """
    The records' tree; finds the m nearest within a radius.
    """
    def __init__(self) -> None:
        ...
    def __len__(self) -> int:
        ...
    def build(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        ...
    def insert(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], first_id: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def search(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], radius: typing.SupportsFloat | typing.SupportsIndex, m: typing.SupportsInt | typing.SupportsIndex) -> list[list[int]]:
        """
        Ids of every position, nearest first.
        """
    def walk(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], radius: typing.SupportsFloat | typing.SupportsIndex, m: typing.SupportsInt | typing.SupportsIndex) -> tuple[list[list[int]], int]:
        """
        The same by a neighbour list that excludes ids congruent to the query's number modulo 3, and how often the tree was not needed.
        """
    @property
    def depth(self) -> int:
        ...
    @property
    def oversized_leaves(self) -> int:
        ...
    @property
    def rebuilds(self) -> int:
        ...
def ambient_visibility(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, pattern: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> float:
    """
    A of a map.
    """
def best_alpha(var_w: typing.SupportsFloat | typing.SupportsIndex, covariance: typing.SupportsFloat | typing.SupportsIndex) -> float:
    ...
def control_variate_estimate(sum_f: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], sum_g: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], j: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], alpha: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], n: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Eq. 2 for one channel.
    """
def correlation(var_z: typing.SupportsFloat | typing.SupportsIndex, var_w: typing.SupportsFloat | typing.SupportsIndex, covariance: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Eq. 6: ρ.
    """
def diffuse_albedo(sp: viscache._core.sampling.ShadingPoint) -> typing.Annotated[list[float], "FixedSize(3)"]:
    """
    Albedo of the diffuse part alone for light from wo.
    """
def direction_to_octahedral(d: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Octahedral map of directions (N, 3) into [0, 1]², (N, 2).
    """
def expected_build_s(scene: viscache._core.Scene, settings: viscache._core.vlf.FieldSettings) -> float:
    """
    CPU seconds to build, by rule of thumb.
    """
def flat_triangles(scene: viscache._core.Scene) -> dict:
    """
    Placed triangles: corners (T, 3, 3), mesh, triangle and instance (-1: none), and the number of degenerate ones, left out.
    """
def fresnel_dielectric(cos_i: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], eta: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unpolarised reflectance; cos_i < 0: from inside.
    """
def gather2(v: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> typing.Any:
    """
    The bits on even places.
    """
def geometric_weight(normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], to_record: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], d_max: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    w_g.
    """
def ggx_d(h: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density of microfacet normals (N, 3), local frame.
    """
def glossy_sum(sp: viscache._core.sampling.ShadingPoint, position: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], value: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], bound2: typing.SupportsFloat | typing.SupportsIndex, seen: collections.abc.Sequence[bool], isa: str | None = None) -> tuple:
    """
    Sum of f·g·value over the columns that are seen.
    """
def hemisphere_batch(scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex, normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], cosine: bool = True, isa: str | None = None) -> tuple:
    """
    The first 32 directions (N, 3) of a randomised (0,2)-sequence around a normal, and their cosines.
    """
def hierarchy(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint64]:
    """
    Words of the codes above a map.
    """
def least_residual_variance(var_z: typing.SupportsFloat | typing.SupportsIndex, rho: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Eq. 5: variance at the best α.
    """
def map_differences(a: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], b: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    δ of rows of maps, (N,).
    """
def node_codes(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Codes of a level's nodes, (4^level,).
    """
def normal_angle(a: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], b: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> float:
    """
    θ of unit normals, in radians.
    """
def normalized_weight(t: typing.SupportsFloat | typing.SupportsIndex, theta: typing.SupportsFloat | typing.SupportsIndex, theta_max: typing.SupportsFloat | typing.SupportsIndex, lambda_: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    ŵ.
    """
def octahedral_to_direction(p: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Its inverse: (N, 2) to unit vectors (N, 3).
    """
def pdf_bsdf(sp: viscache._core.sampling.ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
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
def product_terms(b_over_b_tilde: typing.SupportsFloat | typing.SupportsIndex, visible: typing.SupportsFloat | typing.SupportsIndex, approximate: typing.SupportsFloat | typing.SupportsIndex, d: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> tuple[float, float]:
    """
    Eq. 3: Z and W.
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
def record_pattern(m: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Directions of the cells in Z order, (4^m, 3).
    """
def reflect_directions(sp: viscache._core.sampling.ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, isa: str | None = None) -> tuple:
    """
    f·cos (N, 3) and densities of `sample_bsdf` (N,).
    """
def reflection_at_nodes(shading: viscache._core.sampling.ShadingPoint, level: typing.SupportsInt | typing.SupportsIndex, first: typing.SupportsInt | typing.SupportsIndex) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
    """
    Sixteen node centres (16, 3) and B = f·cos there, as the tree sees it (16, 3).
    """
def refract(wo: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], eta_ratio: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Refracted directions (N, 3); NaN: total reflection.
    """
def regressed_alpha(z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    α from samples (N,), both less the mean of W.
    """
def residual_variance(var_z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], covariance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], alpha: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Eq. 4: variance of Z − αW.
    """
def sample_bsdf(sp: viscache._core.sampling.ShadingPoint, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
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
def shared_axes(directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.int64]:
    """
    Which of unit directions go along and against one axis, (A, 2); -1 against: none.
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
def solid_at(scene: viscache._core.Scene, meshes: typing.Annotated[numpy.typing.ArrayLike, numpy.int64], triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.int64], uv: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.bool]:
    """
    (N,) bool: do alpha masks leave points of triangles solid, at barycentrics (u, v) of their second and third corners?
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
def tile_depth(count: typing.SupportsInt | typing.SupportsIndex, depth: typing.SupportsInt | typing.SupportsIndex, leaf_target: typing.SupportsInt | typing.SupportsIndex) -> int:
    ...
def triangle_hits(kernel: viscache._core.visibility.TriangleKernel, a: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], c: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_min: typing.SupportsFloat | typing.SupportsIndex = 0.0, t_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> numpy.typing.NDArray[numpy.float32]:
    """
    Ray i against triangle (a, b, c)[i]: rows (t, u, v) for t_min < t <= t_max, NaN where it misses.
    """
def wilson_lower(misses: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], rays: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> typing.Any:
    """
    Lower end of the 95 % interval of a share.
    """
