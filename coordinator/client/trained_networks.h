// The networks that a study's own trainings left in its dataset folder.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// Paths of the trained networks of the built-in trainer in `out_dir`/training that fit the variant:
// those of all seeds of the training set that is the variant itself, or else of the mixtures that
// have it as a part and are no control. In order of their paths.
// Errors: kNotFound when there is none, saying how to name one.
absl::StatusOr<std::vector<std::string>> NetworksFor(const std::string& out_dir,
                                                     const v1::StudySpec& study,
                                                     const std::string& variant);

}  // namespace parallax::client
