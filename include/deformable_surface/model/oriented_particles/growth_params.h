// Parameters of growth: where oriented particles are added. Lengths are in spacings: the same values suit every sampling.
#pragma once

#include "deformable_surface/base/params.h"

namespace deformable_surface::model {

struct GrowthParams {
  double min_gap = 2.0;         // spacings: d_min of the stretching rule
  double max_gap = 2.5;         // spacings, >= min_gap: d_max; the widest gap that either rule closes
  double sample_gap = 0.0;      // >= 0: samples close gaps up to this multiple of their distance to others; 0 = up to max_gap
  Index min_neighbors = 0;      // n_min of the growing rule
  Index max_neighbors = 5;      // n_max, >= n_min: particles with more do not grow
  double min_angle = 1.75;      // rad: theta_min, the smallest gap between successive neighbours that is filled
  double max_angle = 6.2832;    // rad, >= min_angle: theta_max
  double neighbor_range = 1.5;  // spacings: range of neighbours for n and theta
  double clearance = 0.7;       // spacings: nothing is added closer to another particle
  Index edge_rows = 0;          // rows that may grow where there is no other side within max_gap
  Index max_passes = 100;
  Index max_particles = 20000;
  bool fix_samples = true;      // the given particles stay where they are while the surface grows
  bool release_samples = true;  // they move in a last relaxation
  // Spacings, >= 0: rms distance of the samples from the surface; the last relaxation removes it.
  double noise = 0.0;
  bool witnessed = false;  // the surroundings must agree to a new particle (growth.h); growSurface() sets it, no field
  bool chain = false;      // particles of a curve in the plane y = 0; follows from the model's mode, no field
};

inline void visit(Fields& fields, GrowthParams& p) {
  fields.number("min_gap", p.min_gap, "spacings", between(1.0, 100.0), "particles this far apart get a new one between them");
  fields.number("max_gap", p.max_gap, "spacings", between(1.0, 100.0), "the widest gap that is closed");
  fields.require(p.min_gap <= p.max_gap, "max_gap", "found less than min_gap; accepted: at least min_gap");
  fields.number("sample_gap", p.sample_gap, "", between(0.0, 100.0),
                "for `grow_surface`: limits gaps near a sample to this times the distance of its fourth nearest sample, at least "
                "2.5 spacings and "
                "at most max_gap. Dense samples may show small features. 0 = max_gap everywhere");
  fields.integer("min_neighbors", p.min_neighbors, "", between(0, 100), "particles with fewer neighbours do not grow");
  fields.integer("max_neighbors", p.max_neighbors, "", between(0, 100), "particles with more neighbours do not grow");
  fields.require(p.min_neighbors <= p.max_neighbors, "max_neighbors", "found less than min_neighbors; accepted: as many or more");
  fields.number("min_angle", p.min_angle, "rad", between(1.0, 6.2832),
                "smallest angular gap between successive neighbours that is filled");
  fields.number("max_angle", p.max_angle, "rad", between(1.0, 6.2832),
                "largest angular gap between successive neighbours that is filled");
  fields.require(p.min_angle <= p.max_angle, "max_angle", "found less than min_angle; accepted: at least min_angle");
  fields.number("neighbor_range", p.neighbor_range, "spacings", between(1.0, 3.0),
                "distance up to which particles are neighbours");
  fields.number("clearance", p.clearance, "spacings", between(0.3, 1.0), "new particles keep this distance to all others");
  fields.integer("edge_rows", p.edge_rows, "", between(0, 1000),
                 "rows of particles that may grow at edges without an opposite edge within max_gap");
  fields.integer("max_passes", p.max_passes, "", between(1, 10000), "maximum number of growth passes");
  fields.integer("max_particles", p.max_particles, "", between(1, kMaxPoints), "maximum number of particles");
  fields.flag("fix_samples", p.fix_samples, "the given particles are constrained while others grow");
  fields.flag("release_samples", p.release_samples, "the given particles move in a final relaxation");
  fields.number(
      "noise", p.noise, "spacings", between(0.0, 1.0),
      "for `grow_surface`: rms distance of the samples from the surface. After release the surface is smoothed until the samples "
      "have "
      "moved that far along their normals, or until they stop. Rest curvatures are means over a few spacings. 0 = the least "
      "smoothing that makes the surface even. Noise cannot be distinguished from features as small as the sample distance");
  fields.require(!(p.noise > 0.0) || p.release_samples, "noise",
                 "found " + formatReal(p.noise) + " with release_samples: false; accepted: 0, or samples that are let go");
}

}  // namespace deformable_surface::model
