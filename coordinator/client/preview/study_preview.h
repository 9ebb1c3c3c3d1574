// Makes a small pair of each variant of a study, in this process: `parallax preview`.
//
// Each pair is one that the study itself would have: the first rig of the first scene that has one,
// chosen by the study's own config and seed. Only its pictures are smaller, and of the profile
// `preview`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "worker/dataset/sheets/preview_sheet.h"

namespace parallax::client {

// Variants that are shown unless some are chosen.
inline constexpr int kMostPreviewed = 8;

struct PreviewOptions {
  std::string file;                   // A study or scene file, or a built-in name.
  std::optional<uint64_t> seed;       // In place of the study's.
  std::vector<std::string> variants;  // Empty: the first kMostPreviewed.
};

// How others follow a preview while it is made. All are called on the caller's thread.
struct PreviewWatcher {
  CancelToken cancel;
  // Called with what is done now: "solving 2 scenes".
  std::function<void(const std::string& stage)> stage;
  // Called with the files and folders that the preview depends on, as soon as they are known, also
  // when something is wrong in one of them.
  std::function<void(const std::vector<std::string>& paths)> files;
};

struct Preview {
  std::string name;  // The study's, or a scene file's.
  uint64_t seed = 0;
  std::vector<PreviewRow> rows;
  std::vector<std::string> left_out;  // Variants that are not shown.
};

// Keeps what it has solved and rendered, so that the next preview makes only what has changed. Not
// thread-safe.
class StudyPreview {
 public:
  StudyPreview();
  ~StudyPreview();

  // Makes the preview. The row of a variant without a valid scene among its first seeds says why.
  // Errors: those of ResolveStudy, LoadSceneConfig and HashContent; kInvalidArgument for a variant
  // that the study does not have; those of Solve and of rendering, naming the variant; kCancelled.
  absl::StatusOr<Preview> Make(const PreviewOptions& options, const PreviewWatcher& watcher);

 private:
  class Maker;
  struct Kept;
  const std::unique_ptr<Kept> kept_;
};

}  // namespace parallax::client
