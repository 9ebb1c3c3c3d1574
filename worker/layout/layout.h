// Stage `layout`: turns a seed into a house with furniture, by simulated annealing over relations.
#pragma once

#include <variant>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// The result for a seed without a valid scene. This is not a failure: the variant's next seed
// replaces it.
struct Rejected {
  std::string reason;
};

// Solves the layout of a seed. The result depends only on the config's fields type, room,
// furniture, solver and assets, and on the seed.
// Errors: kCancelled; kInvalidArgument for a config that names unknown classes.
absl::StatusOr<std::variant<v1::Layout, Rejected>> SolveLayout(const v1::SceneConfig& config,
                                                               SceneSeed seed,
                                                               const CancelToken& cancel);

}  // namespace parallax
