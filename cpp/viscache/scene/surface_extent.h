#pragma once
// How large the coordinates are whose rounding moves a surface: with |p|, the scale of self-intersection
// offsets (visibility/query.h). It follows the triangle that was hit, so that one far or large object does
// not move the shadows of the others.
#include "viscache/math/affine.h"
#include "viscache/math/bounds.h"

namespace viscache {

/// Extent E of a triangle: 8 ulps of max(|p|, E) are more than the distance by which Embree may see a point p
/// of the triangle, offset along its normal, on the wrong side of it.
///
/// Embree's robust test (v3.13, triangle_intersector_pluecker.h) takes the corners relative to the origin of
/// the ray, v_k ≤ s_k along axis k, where s is the size of the triangle; the normal N as a cross product of
/// two edges; and the sign of N·v. Half an ulp u of each step adds up, to first order, to
///     u Σ_k s_k (4 |n_k| + 4 A_k),   A_k = (|a_i b_j| + |a_j b_i|) / |N|
/// with the unit normal n and the edges a, b that it takes for the k-th component. The position and the
/// origin of the ray are rounded too: u Σ_k 2 |n_k| |p_k| < 4u |p|. So E = ½ Σ_k s_k (|n_k| + A_k) suffices:
/// 4u · 2E + 4u |p| ≤ 16u max(|p|, E), as 8 ulps are 16u, with room for the rounding of the offset.
///
/// The normal of a needle that lies across the axes is all rounding: E stops at 4 times the longest edge, as
/// such a triangle shows nothing that a larger offset would keep.
///
/// A floor that lies along the axes has n_k + A_k = 0 where s_k ≠ 0: it is exact however large it is. A share
/// of the size keeps the offset from vanishing at the origin.
float surface_extent(Vec3 a, Vec3 b, Vec3 c);

/// Extent of a triangle of an instance, whose corners are those of the mesh. Embree moves the origin p of the
/// ray to the mesh and tests there. By rows, that rounds |M| |M⁻¹| (|p| + |t|), three times half an ulp, for
/// the transform x → M x + t.
float surface_extent(Vec3 a, Vec3 b, Vec3 c, const Affine& to_world);

/// A bound on the extents of all triangles of an instance, where `mesh` bounds the extents in the mesh and
/// `placed` the corners in the world.
float instance_extent(float mesh, const Bounds& placed, const Affine& to_world);

}  // namespace viscache
