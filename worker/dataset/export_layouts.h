// Where each layout puts a frame's files and how it encodes them. Private to worker/dataset.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/dataset/dataset_reader.h"
#include "worker/dataset/export.h"

namespace parallax {

// A frame on its way out.
struct ExportFrame {
  const DatasetFrame* source = nullptr;
  std::string scene;     // Folder name of its scene: no word that readers replace, no spaces.
  std::string type;      // "indoor", "dense"...
  int number = 0;        // In the whole export, from 0; frames of one scene are consecutive.
  int scene_number = 0;  // Of its scene, from 0.
  int scenes = 0;        // In all.
  bool test = false;
  bool infrared = false;  // Its pictures are the infrared ones.
};

// One file to make: a link to one of the frame's, or bytes.
struct ExportFile {
  std::string path;     // Below out_dir.
  std::string link_to;  // Absolute; empty: `bytes`.
  std::string bytes;
};

struct FrameFiles {
  std::vector<ExportFile> files;
  std::string list_line;  // Of train.txt or test.txt: "left right disparity".
  int64_t pixels_out_of_range = 0;
  std::vector<uint32_t> disparity_counts;  // By bin of DisparityHistogram().
};

class ExportLayout {
 public:
  virtual ~ExportLayout() = default;
  // Thread-safe. Errors: kDataLoss for maps or a frame.json that do not fit; as ReadFile.
  virtual absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const = 0;
  // Files of a whole scene, after its frames. Errors: as Convert.
  virtual absl::StatusOr<std::vector<ExportFile>> FinishScene(
      const std::vector<ExportFrame>& frames) const {
    (void)frames;
    return std::vector<ExportFile>();
  }
  // webdataset: the files of a frame are members of a shard, in this order.
  virtual bool Shards() const { return false; }
};

// nullptr for an unknown name.
std::unique_ptr<ExportLayout> MakeExportLayout(const ExportOptions& options);

}  // namespace parallax
