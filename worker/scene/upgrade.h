// Recipes and layouts of earlier releases, read by this one.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Turns a recipe or layout that an earlier release wrote into what this one writes: a room becomes
// a house, none the open sky, and parts of rooms get the class that they are shown as. Leaves those
// of this release as they are, so may be called at every place that reads one.
// Errors: kInvalidArgument for an object of a room that the house does not have.
absl::Status UpgradeScene(v1::Scene& scene);
absl::Status UpgradeLayout(v1::Layout& layout);

// A recipe's file (<dataset>/<variant>/scenes/*.pb), upgraded.
// Errors: kInvalidArgument, which names `path`, for bytes that are no recipe; as UpgradeScene.
absl::StatusOr<v1::Scene> ParseScene(const std::string& bytes, const std::string& path);

}  // namespace parallax
