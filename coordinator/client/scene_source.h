// Finds the recipe for `parallax scene`.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/command.h"
#include "parallax/v1/scene.pb.h"

namespace parallax::client {

// Loads the recipe that a command line names: FILE; DIR VARIANT SCENE, where DIR is a dataset of
// `run` or `fetch`; or STUDY VARIANT SCENE, which asks the session's coordinator. Errors:
// kInvalidArgument for other words and for a file that is not a recipe; kNotFound for an unknown
// variant or scene, naming the existing ones; the connection's.
absl::StatusOr<v1::Scene> LoadScene(const std::vector<std::string>& source, const Session& session);

}  // namespace parallax::client
