// Upgrades recipes and layouts of earlier releases to this one.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Converts a recipe or layout of an earlier release in place: a room becomes a house, no room the
// open sky, and parts of rooms get the class that they are shown as. Does nothing to those of this
// release, so every reader may call it. Errors: kInvalidArgument for an object of a room that the
// house does not have.
absl::Status UpgradeScene(v1::Scene& scene);
absl::Status UpgradeLayout(v1::Layout& layout);

// Parses a recipe's file (<dataset>/<variant>/scenes/*.pb) and upgrades it.
// Errors: kInvalidArgument, naming `path`, for bytes that are no recipe; as UpgradeScene.
absl::StatusOr<v1::Scene> ParseScene(const std::string& bytes, const std::string& path);

}  // namespace parallax
