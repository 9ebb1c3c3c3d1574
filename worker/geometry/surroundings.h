// The space around a scene's objects as the scene's type describes it: where rigs and objects may
// be, how light gets in, what counts as exterior, where the view ends. Renderer, dataset and rigs
// read this and never the kind of place. Plain data, world frame, metres.
#pragma once

#include <algorithm>
#include <vector>

#include "common/math/types.h"

namespace parallax {

// An opening of an enclosure through which skylight enters: the parallelogram corner + [0, 1]
// edge_u + [0, 1] edge_v.
struct SkyPortal {
  Vec3f corner, edge_u, edge_v;
  Vec3f normal;       // Unit, out of the enclosure.
  float depth_m = 0;  // Thickness of the wall around it; closings (panes, doors) lie within.
};

// The points with normal . p <= offset.
struct HalfSpace {
  Vec3f normal;  // Unit.
  float offset = 0;
};

// A space that the sky lights only through its portals: the part of the box within all half-spaces.
struct SkyEnclosure {
  Box3f box;
  std::vector<HalfSpace> within;  // For spaces that stand askew in their box.
  std::vector<SkyPortal> portals;
};

// Everything that a scene's type says about its space.
struct Surroundings {
  // Limits of rigs and floating objects; empty: no limit.
  Eigen::AlignedBox3d bounds;
  std::vector<SkyEnclosure> enclosures;
  // The inner spaces of the place: rooms and the openings in their walls. If none exist,
  // nothing is exterior.
  std::vector<Box3f> interiors;
  // Whether the sky's own flat ground is seen below the horizon. False for places whose ground
  // reaches the horizon: below it, the sky continues as bright as at the horizon.
  bool ground_below_horizon = true;

  // Returns whether a point is outside all of the place's inner spaces.
  bool IsExterior(const Vec3f& point) const {
    return !interiors.empty() &&
           std::none_of(interiors.begin(), interiors.end(),
                        [&](const Box3f& interior) { return interior.contains(point); });
  }
};

}  // namespace parallax
