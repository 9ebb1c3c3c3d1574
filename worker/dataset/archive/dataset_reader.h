// Reads a dataset folder: its frames, their lines of the index, and what is missing. For exports
// and checks. Reads only.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// One frame, from its line of the index.
struct DatasetFrame {
  std::string variant;
  uint32_t scene = 0, rig = 0;
  std::string dir;                           // The frame's folder.
  bool passed = true;                        // Whether it passed all filters.
  std::map<std::string, std::string> files;  // SHA-256 by name.
  nlohmann::ordered_json line;               // The frame's line of index.jsonl.
};

// One variant: its frames, in the order of the index's keys.
struct DatasetVariant {
  std::string name;
  std::string dir;
  std::vector<DatasetFrame> frames;  // By scene, rig.
  int64_t pairs_wanted = 0;          // From dataset.json; 0 when that is missing.
  bool has_index = true;             // Without one, `frames` is empty.
  std::string type;                  // "indoor", "dense"...: from dataset.json or study.lock.yaml.
  // Faults of the folder itself: one text each, naming the file.
  std::vector<std::string> faults;
};

struct Dataset {
  std::string dir;
  std::vector<DatasetVariant> variants;  // In order of name.
};

// Reads the indices of a dataset. `dir` is an archive (its variants are the folders with an
// index.jsonl, or with frames whose index is missing) or one of its variants. Faults of a variant's
// folder do not fail the call; they are in `faults`. Errors: kNotFound if there is no index;
// kDataLoss for a malformed line of an index.
absl::StatusOr<Dataset> ReadDataset(const std::string& dir);

// Refuses a variant whose index is missing: a part must not pass for the whole dataset. Errors:
// kFailedPrecondition.
absl::Status RequireIndices(const Dataset& dataset);

// Removes the variant of held-out pairs (kHeldoutName), on which no network may be trained, unless
// the dataset's folder is that variant itself. Returns whether it did.
bool LeaveOutHeldout(Dataset& dataset);

// Returns the dataset's variants whose names match one of `patterns`; a trailing * matches the
// rest. Without patterns, all variants. Errors: kInvalidArgument for a pattern that matches none,
// listing the variants.
absl::StatusOr<std::vector<DatasetVariant>> ChooseVariants(
    Dataset dataset, const std::vector<std::string>& patterns);

}  // namespace parallax
