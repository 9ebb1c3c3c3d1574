// Scores that trained networks gave to a variant's frames: <variant>/curation.jsonl, one line for
// each frame and network. Lines are appended while frames are scored, so that an interrupted
// curation can continue.
//
//   {"scene": 3, "rig": 0, "frame": SHA-256 of the hashes of its pictures and truth,
//    "network": SHA-256 of the checkpoint, "versions": "1/1", "pixels": 57600, "bad": 8211}
//
// "pixels" counts those with truth, "bad" those of them that are missed by more than 2 px.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/base/status.h"
#include "worker/dataset/archive/dataset_reader.h"

namespace parallax {

// Counts of pixels in one frame.
struct CurationScore {
  int64_t pixels = 0;
  int64_t bad = 0;
};

// The log of one variant. One writer at a time. Not thread-safe.
class CurationLog {
 public:
  // Reads the existing log, and drops lines that an interruption broke. Errors: those of ReadFile.
  static absl::StatusOr<CurationLog> Open(const std::string& variant_dir);

  // Returns the score of a frame; nothing if this network, with this version of the trainer, has
  // not scored these files.
  std::optional<CurationScore> Find(const DatasetFrame& frame, const std::string& network) const;

  struct Entry {
    const DatasetFrame* frame = nullptr;
    CurationScore score;
  };
  // Appends the entries durably. Errors: those of WriteFile.
  absl::Status Add(const std::string& network, const std::vector<Entry>& entries);

 private:
  using Key = std::tuple<std::string, std::string>;  // Frame, network.
  explicit CurationLog(std::string path) : path_(std::move(path)) {}

  std::string path_;
  std::map<Key, CurationScore> scores_;
};

}  // namespace parallax
