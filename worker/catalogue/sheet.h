// Contact sheets of both catalogues, rendered: to look at every class and every material.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

struct SheetOptions {
  std::string dir;                // Is made when it is missing.
  std::vector<std::string> only;  // Names of classes and materials, families; empty = everything.
  uint64_t first_seed = 1;
  int cell_px = 192;
  int samples = 12;  // A pixel, before the denoiser.
};

struct SheetResult {
  // assets-01.png..., materials-01.png..., assets.jpg, materials.jpg.
  std::vector<std::string> files;
  int classes = 0, materials = 0;
};

// Pages of twelve rows a file: a class in six seeds, or a material on a ball, a board and a chair
// in two seeds; and one reduced JPEG of each catalogue. `progress` gets the fraction done and what
// is being drawn.
// Errors: kNotFound for a name that nothing has; as WriteFile; kCancelled.
absl::StatusOr<SheetResult> WriteCatalogueSheets(
    const SheetOptions& options, const CancelToken& cancel,
    const std::function<void(double, const std::string&)>& progress = {});

}  // namespace parallax
