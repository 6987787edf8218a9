# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Equations and parts of structures that only tests call.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
import viscache._core
import viscache._core.aqvc
import viscache._core.sampling
import viscache._core.vismap
import viscache._core.vlf
__all__: list[str] = ['AnalyticCaster', 'BitTable', 'Distribution1D', 'KdTree', 'ProductTree', 'TileRun', 'ambient_visibility', 'best_alpha', 'bilinear_places', 'by_light', 'choose_light', 'coherent_between', 'control_variate_estimate', 'correlation', 'diffuse_albedo', 'direction_to_octahedral', 'equal_area_round_trip', 'expected_build_s', 'expected_paths', 'flat_triangles', 'free_share', 'fresnel_dielectric', 'gather2', 'geometric_weight', 'ggx_d', 'given_maps', 'glossy_sum', 'hemisphere_batch', 'hierarchy', 'ladder', 'largest_prime', 'latlong_batch', 'learnt_map', 'least_residual_variance', 'light_cells', 'light_probabilities', 'lit_by_light', 'map_differences', 'nearest_emitter', 'node_codes', 'normal_angle', 'normalized_weight', 'octahedral_batch', 'octahedral_square', 'octahedral_to_direction', 'order', 'packed_rays', 'patch_area', 'patch_area_product', 'pdf_bsdf', 'pdf_cosine_hemisphere', 'pdf_ggx_vndf', 'pdf_uniform_cone', 'pdf_uniform_hemisphere', 'pdf_uniform_sphere', 'pick_columns', 'product_terms', 'radical_inverse', 'random', 'random_u32', 'ray_order', 'record_pattern', 'reflect_directions', 'reflection_at_nodes', 'refract', 'regressed_alpha', 'residual_variance', 'resolution_environment', 'resolution_light', 'resolution_pair', 'sample_bsdf', 'sample_ggx_vndf', 'sample_sphere_light', 'schlick', 'shared_axes', 'smith_g1', 'smith_g2', 'sobol02', 'solid_at', 'sphere_batch', 'square_to_cosine_hemisphere', 'square_to_disk_concentric', 'square_to_triangle', 'square_to_uniform_cone', 'square_to_uniform_hemisphere', 'square_to_uniform_sphere', 'tile_depth', 'triangle_hits', 'wilson_lower']
class BitTable:
    """
    The lossy table. `get` gives -1 for a miss.
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
    def __init__(self, caster: AnalyticCaster, eyes: dict, parameters: viscache._core.aqvc.AqvcParameters, *, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, extent: typing.SupportsFloat | typing.SupportsIndex, spp: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
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
class Distribution1D:
    """
    Discrete distribution of indices with given weights.
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
        Index, its probability, and u rescaled to [0, 1) inside its interval, each (N,).
        """
    @property
    def total(self) -> float:
        ...
class ProductTree:
    """
    L·B̃ over the sphere for one point. Directions are drawn from it.
    """
    @staticmethod
    def of_surface(light: viscache._core.vismap.EnvironmentPyramid, shading: viscache._core.sampling.ShadingPoint, map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        ...
    @staticmethod
    def of_table(light: viscache._core.vismap.EnvironmentPyramid, b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        """
        From a table of B over the map, (N, N, 3).
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
        Texels drawn with points (N, 2) of the square: row-major numbers (N,) and directions (N, 3).
        """
    def texel_masses(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Integrals of L·B̃ over the texels, (R, R). Divided by L_ns they are the probabilities of the texels.
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
    Tree of records. It finds the m nearest within a radius.
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
        The same with a neighbour list. Query q skips ids congruent to q modulo 3. Also the number of queries that the list answered without the tree.
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
def bilinear_places(u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], v: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> tuple:
    """
    The four pixels (4, n) around places of a lat-long image, row by row of the image, and the shares (2, n) of the right column and the lower row.
    """
def by_light(wanted: typing.Annotated[numpy.typing.ArrayLike, numpy.bool]) -> bool:
    """
    Whether a block of up to 16 rows, with these bits asked, is traced by light.
    """
def choose_light(scene: viscache._core.Scene, way: str, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64]]:
    """
    Lights (N, K) chosen at points with shading normals by numbers u (N, K), and their probabilities. Lights are counted over triangles, then spheres; -1: none contributes.
    """
def coherent_between(caster: viscache._core.RayCaster, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], ends: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> bool:
    """
    Whether rays between 16 pairs of points (16, 3) are traced with Embree's coherent flag.
    """
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
    Albedo of the diffuse part for light from wo.
    """
def direction_to_octahedral(d: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Octahedral map of directions (N, 3) into [0, 1]², (N, 2).
    """
def equal_area_round_trip(points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], isa: str | None = None) -> tuple:
    """
    Equal-area map of points (N, 2) to directions (N, 3), and these back, in batches.
    """
def expected_build_s(scene: viscache._core.Scene, settings: viscache._core.vlf.FieldSettings) -> float:
    """
    Estimated CPU seconds of the build.
    """
def expected_paths(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg4: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 2.
    """
def flat_triangles(scene: viscache._core.Scene) -> dict:
    """
    Placed triangles: corners (T, 3, 3), mesh, triangle and instance (-1: none), and the number of degenerate ones, left out.
    """
def free_share(n_directions: typing.SupportsInt | typing.SupportsIndex, normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], rows: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Cosine-weighted fraction of the hemisphere that is free by each bit row, (N,).
    """
def fresnel_dielectric(cos_i: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], eta: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unpolarised reflectance; cos_i < 0: from inside.
    """
def gather2(v: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> typing.Any:
    """
    The bits at even positions, packed.
    """
def geometric_weight(normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], to_record: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], d_max: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    w_g.
    """
def ggx_d(h: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Density of microfacet normals (N, 3), local frame.
    """
def given_maps(settings: viscache._core.VisMapSettings, maps: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], beta: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], dilated: collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.bool]]) -> viscache._core.FrameMaps:
    """
    The same blend of maps for all points.
    """
def glossy_sum(sp: viscache._core.sampling.ShadingPoint, position: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], value: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], bound2: typing.SupportsFloat | typing.SupportsIndex, seen: collections.abc.Sequence[bool], isa: str | None = None) -> tuple:
    """
    Sum of f·g·value over the visible columns.
    """
def hemisphere_batch(scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex, normal: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], cosine: bool = True, isa: str | None = None) -> tuple:
    """
    The first 32 directions (N, 3) of a randomised (0,2)-sequence around a normal, and their cosines.
    """
def hierarchy(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint64]:
    """
    Words of the quadtree codes above a map.
    """
def ladder(r: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], c_r: typing.SupportsFloat | typing.SupportsIndex = 1.2, c_z: typing.SupportsFloat | typing.SupportsIndex = 4.0) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32], dict]:
    """
    AQVC Eq. 8: resolutions, slots, clamps.
    """
def largest_prime(arg0: typing.SupportsInt | typing.SupportsIndex) -> int:
    ...
def latlong_batch(to_world: typing.Annotated[collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]], "FixedSize(3)"], *, y: typing.SupportsFloat | typing.SupportsIndex, first: typing.SupportsFloat | typing.SupportsIndex, step: typing.SupportsFloat | typing.SupportsIndex, n: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    Columns and rows (2, n) in a lat-long image of points ((first + i)·step, y) of the equal-area map.
    """
def learnt_map(settings: viscache._core.NeePlusPlusSettings, low: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], high: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], near: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], seen: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], *, direction: bool = False) -> tuple:
    """
    Cells of both ends (N,), then the visibility and probability of every connection in the filled map. `far` holds places, or directions towards the light.
    """
def least_residual_variance(var_z: typing.SupportsFloat | typing.SupportsIndex, rho: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Eq. 5: variance at the best α.
    """
def light_cells(parameters: viscache._core.aqvc.AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, *, semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], density: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], limit: typing.SupportsInt | typing.SupportsIndex = 1073741824) -> tuple:
    """
    Columns of samples by light cell, and counts of clamped resolutions.
    """
def light_probabilities(scene: viscache._core.Scene, way: str, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Probabilities (N, lights) of the choice at points with shading normals.
    """
def lit_by_light(caster: viscache._core.RayCaster, settings: viscache._core.ShadowMapSettings, far: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, direction: bool, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 1) -> tuple:
    """
    Points with unit normals looked up in one light's map: lit (N,), depths (faces, rows, columns). `far` is a position, or a unit direction towards the light.
    """
def map_differences(a: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], b: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    δ of rows of maps, (N,).
    """
def nearest_emitter(scene: viscache._core.Scene, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> tuple[numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float32]]:
    """
    Lights (N,) that rays find among the lights alone, -1 for none, and the points (N, 3).
    """
def node_codes(bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], m: typing.SupportsInt | typing.SupportsIndex, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Codes of the nodes of a level, (4^level,).
    """
def normal_angle(a: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], b: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> float:
    """
    θ of unit normals, in radians.
    """
def normalized_weight(t: typing.SupportsFloat | typing.SupportsIndex, theta: typing.SupportsFloat | typing.SupportsIndex, theta_max: typing.SupportsFloat | typing.SupportsIndex, lambda_: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    ŵ.
    """
def octahedral_batch(w: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, isa: str | None = None) -> tuple:
    """
    Octahedral map of many directions, computed with one instruction set.
    """
def octahedral_square(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Octahedral map of directions to the unit square.
    """
def octahedral_to_direction(p: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Its inverse: (N, 2) to unit vectors (N, 3).
    """
def order(x: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], y: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], width: typing.SupportsInt | typing.SupportsIndex, height: typing.SupportsInt | typing.SupportsIndex, parameters: viscache._core.aqvc.AqvcParameters) -> dict:
    """
    Processing order of a tile's eye points (AQVC Sec. 4.3).
    """
def packed_rays(origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, *, order: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32] | None = None, isa: str | None = None) -> typing.Any:
    """
    Lanes and masks of up to 256 rays as Embree gets them; None if one of them must not be traced.
    """
def patch_area(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 5.
    """
def patch_area_product(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 3.
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
def pick_columns(contributions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], most: typing.SupportsInt | typing.SupportsIndex, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Weights (N, M) of the columns that are picked with the offsets u (N,); 0: not picked. All 1 where every column counts.
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
    The same numbers as floats in [0, 1).
    """
def random_u32(keys: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], count: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
    """
    First `count` numbers of each stream; keys (N, 4) are (seed, purpose, pixel, pass). (N, count) uint32.
    """
def ray_order(origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, isa: str | None = None) -> tuple:
    """
    The order in which rays without order are traced, and their share in order.
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
    Sixteen node centres (16, 3), and B = f·cos at them as the tree computes it (16, 3).
    """
def refract(wo: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], eta_ratio: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Refracted directions (N, 3); NaN: total reflection.
    """
def regressed_alpha(z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    α from samples (N,) of Z and W, both minus the mean of W.
    """
def residual_variance(var_z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], covariance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], alpha: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Eq. 4: variance of Z − αW.
    """
def resolution_environment(density: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], printed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool] = False) -> typing.Any:
    """
    AQVC Eq. 9 of P(ω)·M.
    """
def resolution_light(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 7, light side: D_l, B_R.
    """
def resolution_pair(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg3: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 6 of D_e, D_l, C_E, B_R.
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
    Fresnel reflectance (N, 3) from the reflectance at normal incidence.
    """
def shared_axes(directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.int64]:
    """
    Pairs of opposite unit directions (A, 2): the one along each axis and the one against it; -1: none.
    """
def smith_g1(cos_w: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], alpha: typing.SupportsFloat | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Fraction of the microfacets that are visible from a direction.
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
    (N,) bool: whether points of triangles are solid by their alpha masks. (u, v) are the barycentrics of the second and the third corner.
    """
def sphere_batch(scramble_x: typing.SupportsInt | typing.SupportsIndex, scramble_y: typing.SupportsInt | typing.SupportsIndex, *, first: typing.SupportsInt | typing.SupportsIndex = 0, n: typing.SupportsInt | typing.SupportsIndex, isa: str | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    Directions (n, 3) of a randomised (0,2)-sequence, uniform on the sphere.
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
def triangle_hits(kernel: str, a: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], c: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_min: typing.SupportsFloat | typing.SupportsIndex = 0.0, t_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> numpy.typing.NDArray[numpy.float32]:
    """
    Intersects ray i with triangle (a, b, c)[i]: rows (t, u, v) with t_min < t <= t_max, NaN for a miss.
    """
def wilson_lower(misses: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32], rays: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32]) -> typing.Any:
    """
    Lower bound of the 95 % Wilson interval of misses / rays.
    """
