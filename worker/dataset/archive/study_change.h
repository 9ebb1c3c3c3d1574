// Fits a dataset folder to its study that has grown or changed: puts content that the study no
// longer asks for aside, and never deletes it.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// A part of a dataset folder that a changed study no longer asks for.
struct DroppedPart {
  std::string what;                // "variant wide: no longer in the study".
  std::vector<std::string> paths;  // Relative to the dataset's folder; some may not be there.
};

// Returns the parts of a dataset of study `before` that `now`, a later version of it, does not ask
// for in this form: variants that are gone or have other settings, and trainings and scores whose
// data or settings have changed. More pairs, seeds, variants, mixtures and benchmarks drop nothing
// else; neither do other filters, sensors and places of own content. Both studies are resolved.
std::vector<DroppedPart> PartsDropped(const v1::StudySpec& before, const v1::StudySpec& now);

// Moves the parts that are there from `out_dir` to a new folder of `out_dir`/.parallax/aside, which
// becomes a dataset by itself with the study's files of before. Returns a text for each part that
// was there, with its new place. Errors: those of the disk.
absl::StatusOr<std::vector<std::string>> PutAside(const std::string& out_dir,
                                                  const std::vector<DroppedPart>& parts);

}  // namespace parallax
