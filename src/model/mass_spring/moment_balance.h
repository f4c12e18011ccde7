// Makes a curvature energy of fits converge on scattered points: the forces of a constant moment vanish inside, and are those of
// a plate at edges. Fits alone do not ensure this; the surface is then too soft by some per cent, at any number of points.
#pragma once

#include "curvature_fits.h"

#include <vector>

namespace deformable_surface::model {

/// Of each point, a symmetric tensor in its tangent plane: half of its trace, half of the difference of its diagonal, its
/// off-diagonal.
using Multipliers = std::vector<Vec3>;

/// Returns the rows of the fits in balance. Changes the rows c_j(i) of the second derivatives as little as possible, by sum_i A_i
/// R_i^2 sum_j |dc_j(i)|^2 / weight_j(i), so that they stay exact for quadratics and
///   sum_i A_i T_ji c_j(i) = sum_k T_jk sym(o_k g_j(k))   for every point j that no clamp holds:
/// the effect of a constant moment inside equals that on the edge. T_ji maps tensors of the tangent plane of i to that of j by
/// the least rotation of the normals. o_k is the sum over the triangles at k of their normal x half of the opposite edge: outward
/// on a free edge, zero inside. It is the integration constraint of meshfree Galerkin methods [Chen et al. 2013] for second
/// derivatives, met by rows that stand on both sides of an energy.
///
/// areas (n) m^2: A_i, thirds of those triangles whose corners all have fits. On a plane there is a solution, found to rounding.
/// On curved surfaces, the residual falls with the square of the angle between neighbouring normals. Costs a factor of a sparse
/// (n x n) matrix.
///
/// multipliers (n): in, a guess, and out. is_fixed (n), or empty: 1 where they stay as they are, and nothing is balanced.
std::vector<CurvatureRow> balanceMoments(const ClampedPlate& clamped, const std::vector<double>& areas, const CurvatureFits& fits,
                                         const std::vector<char>& is_fixed, Multipliers& multipliers);

}  // namespace deformable_surface::model
