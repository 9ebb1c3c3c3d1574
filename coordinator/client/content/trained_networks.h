// Finds the networks that a study's own trainings left in its dataset folder.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// Returns the paths of the built-in trainer's networks in `out_dir`/training that fit the variant:
// all seeds of the training set that is the variant itself or, if none exists, of the mixtures
// that have it as a part and are not controls. Sorted. Errors: kNotFound if none exists, with a
// hint how to name one.
absl::StatusOr<std::vector<std::string>> NetworksFor(const std::string& out_dir,
                                                     const v1::StudySpec& study,
                                                     const std::string& variant);

}  // namespace parallax::client
