// Where `parallax scene` finds a recipe.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/commands/command.h"
#include "parallax/v1/scene.pb.h"

namespace parallax::client {

// The recipe that the words of a command line name: FILE; DIR VARIANT SCENE, where DIR is a dataset
// as `run` and `fetch` write it; or STUDY VARIANT SCENE of the session's coordinator, which is
// asked only then. Errors: kInvalidArgument for other words and for a file that is no recipe;
// kNotFound, naming what there is, for a variant or scene that is not there; the connection's.
absl::StatusOr<v1::Scene> LoadScene(const std::vector<std::string>& source, const Session& session);

}  // namespace parallax::client
