// Loads the scene of the render tools: a recipe file, or the built-in demo room.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/build_geometry.h"

namespace parallax::bench {

struct LoadedScene {
  v1::Scene recipe;
  SceneGeometry geometry;
  double geometry_s = 0, solve_core_s = 0;
};

// `path`: a Scene message, binary (.pb) or text (.txtpb, .textproto); solve:SEED[:CONFIG], with
// `rigs` rigs (0: the config's); empty = the demo room of `seed`.
absl::StatusOr<LoadedScene> LoadScene(const std::string& path, uint64_t seed, int rigs = 0);

}  // namespace parallax::bench
