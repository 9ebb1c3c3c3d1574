#include <fmt/core.h>

#include <filesystem>

#include "common/base/status.h"
#include "common/image/io.h"
#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/predictors/predictor.h"

namespace parallax {
namespace {

// Reads a prediction. A PNG of 8 bits is a picture for people.
absl::StatusOr<ImageF> ReadPrediction(const std::string& path) {
  if (path.ends_with(".png")) RETURN_IF_ERROR(ReadPngU16(path).status());
  return ReadDisparity(path);
}

class FolderPredictor : public Predictor {
 public:
  explicit FolderPredictor(std::string dir) : dir_(std::move(dir)) {}
  std::string name() const override { return dir_; }

  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext& context) override {
    RETURN_IF_ERROR(CheckAllThere(tasks));
    int done = 0;
    for (const PredictionTask& task : tasks) {
      if (context.cancel.cancelled()) return Cancelled("{}: stopped", dir_);
      ASSIGN_OR_RETURN(const ImageF disparity_px, ReadPrediction(FileOf(task.name)));
      RETURN_IF_ERROR(WritePfm(task.output, disparity_px));
      context.progress(++done);
    }
    return absl::OkStatus();
  }

 private:
  // "" when none exists. A PNG comes last: beside other files it may be a picture for people.
  std::string FileOf(const std::string& pair) const {
    std::error_code error;
    for (const char* extension : {".pfm", ".npy", ".exr", ".png"}) {
      const std::string path = dir_ + "/" + pair + extension;
      if (std::filesystem::is_regular_file(path, error)) return path;
    }
    return "";
  }

  absl::Status CheckAllThere(const std::vector<PredictionTask>& tasks) const {
    std::string first;
    int missing = 0;
    for (const PredictionTask& task : tasks) {
      if (!FileOf(task.name).empty()) continue;
      if (missing++ == 0) first = task.name;
    }
    if (missing == 0) return absl::OkStatus();
    return NotFound("{}/{}.pfm (or .npy, .exr, .png): missing{}", dir_, first,
                    missing > 1 ? fmt::format(", and {} more", missing - 1) : "");
  }

  std::string dir_;
};

}  // namespace

std::unique_ptr<Predictor> MakeFolderPredictor(std::string dir) {
  return std::make_unique<FolderPredictor>(std::move(dir));
}

}  // namespace parallax
