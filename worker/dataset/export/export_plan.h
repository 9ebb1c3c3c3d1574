// The plan of an export: which frames go where, and which split each is in.
#pragma once

#include <utility>
#include <vector>

#include "common/base/status.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/export/export.h"
#include "worker/dataset/export/export_layouts.h"

namespace parallax {

// Frames in the order of their numbers; they point into the variants.
struct ExportPlan {
  std::vector<ExportFrame> frames;
  std::vector<std::pair<size_t, size_t>> scenes;  // [first, end) into frames.
};

// Assigns frames to splits. Scenes with one number show the same room in every variant, so they go
// to the same split. With `sequences` the export's scenes are runs of frames.
// Counts into `result`, and notes there what a user should know. Errors: kFailedPrecondition, as
// FindRuns.
absl::StatusOr<ExportPlan> MakeExportPlan(const std::vector<DatasetVariant>& variants,
                                          const ExportOptions& options, bool sequences,
                                          ExportResult& result);

}  // namespace parallax
