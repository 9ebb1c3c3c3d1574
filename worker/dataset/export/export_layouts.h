// The export layouts: paths of a frame's files, and their encoding. Private to worker/dataset.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/export/export.h"

namespace parallax {

// A frame to be exported.
struct ExportFrame {
  const DatasetFrame* source = nullptr;
  std::string scene;     // Name of its scene's folder: no spaces, and no word that readers replace.
  std::string type;      // "indoor", "dense"...
  int number = 0;        // In the whole export, from 0; frames of one scene are consecutive.
  int scene_number = 0;  // Within its scene, from 0.
  int scenes = 0;        // In all.
  bool test = false;
  // For layouts of sequences, whose `scene` is a run of frames that follow each other: place in it
  // from 0, and its length.
  int at = 0, length = 0;
  bool infrared = false;  // Its pictures are the infrared ones.
};

// A file to make: a link to one of the frame's files, or bytes.
struct ExportFile {
  std::string path;     // Below out_dir.
  std::string link_to;  // Absolute; empty: `bytes`.
  std::string bytes;
};

struct FrameFiles {
  std::vector<ExportFile> files;
  std::string list_line;  // A line of train.txt or test.txt: "left right disparity".
  int64_t pixels_out_of_range = 0;
  std::vector<uint32_t> disparity_counts;  // By bin of DisparityHistogram().
};

// One layout.
class ExportLayout {
 public:
  virtual ~ExportLayout() = default;
  // Converts one frame. Thread-safe. Errors: kDataLoss for maps or a frame.json that do not fit; as
  // ReadFile.
  virtual absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const = 0;
  // Makes the files of a whole scene, after its frames. Errors: as Convert.
  virtual absl::StatusOr<std::vector<ExportFile>> FinishScene(
      const std::vector<ExportFrame>& frames) const {
    (void)frames;
    return std::vector<ExportFile>();
  }
  // Makes the files of the whole export, after its scenes. Errors: as Convert.
  virtual absl::StatusOr<std::vector<ExportFile>> Finish(
      const std::vector<ExportFrame>& frames) const {
    (void)frames;
    return std::vector<ExportFile>();
  }
  // Returns whether the layout is for sequences with flow: its scenes are runs of frames
  // (sequence_runs.h).
  virtual bool Sequences() const { return false; }
  // Returns whether a frame's files are members of a shard, in this order (webdataset).
  virtual bool Shards() const { return false; }
};

// Returns the name of a frame's picture of an eye, "left" or "right": the colour or the infrared
// one.
std::string PictureOf(const ExportFrame& frame, const std::string& eye);
// Reads a frame's depth or disparity as truth to train on: `map` without its ".exr", of an eye, 0
// where there is no truth. Sky and the exterior of rooms have none, as in the paper, where the
// frame has masks. Errors: kDataLoss for masks of another size; as ReadFile.
absl::StatusOr<ImageF> ReadTruthMap(const ExportFrame& frame, const std::string& map,
                                    const std::string& eye);
// Reads one of the frame's files as it is. Errors: kDataLoss for content that is not what the index
// says; as ReadFile.
absl::StatusOr<std::string> ReadUnchanged(const ExportFrame& frame, const std::string& file);
// Makes a link at `path` to one of the frame's files.
ExportFile LinkTo(std::string path, const ExportFrame& frame, const std::string& file);

// Makes the layout "flyingthings" with disparity 0, not infinite, where there is no truth. Readers
// of flow and depth divide by the disparity: 0 is infinitely far to them, and left out.
std::unique_ptr<ExportLayout> MakeFlyingThingsWithFiniteTruth();

// Returns the layouts for sequences; nullptr for another name.
std::unique_ptr<ExportLayout> MakeSequenceLayout(const std::string& name);

// Makes the layout that the options name; nullptr for an unknown name.
std::unique_ptr<ExportLayout> MakeExportLayout(const ExportOptions& options);

}  // namespace parallax
