// Exports of a checkpoint: a TorchScript module, or its weights alone. No torch in this header.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

// Writes a module for pairs of exactly height x width px (multiples of 32), since tracing keeps
// sizes: forward(left, right), each (1, 3, height, width) in [0, 1], gives (1, 1, height, width),
// the left image's disparity in pixels. It searches as far as the checkpoint was trained. Errors:
// kInvalidArgument for other sizes; as ReadCheckpoint and WriteFileAtomically.
absl::Status ExportTorchScript(const std::string& checkpoint, const std::string& path, int height,
                               int width);

// Writes a checkpoint with nothing but the weights that predict, a quarter of the bytes. A run can
// start with it, but not resume from it. Errors: those of ReadCheckpoint and WriteCheckpoint.
absl::Status ExportWeights(const std::string& checkpoint, const std::string& path);

}  // namespace parallax
