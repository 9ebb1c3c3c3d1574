// Contact sheets of both catalogues, rendered: every class and every material.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

// The content of the sheets, and their resolution.
struct SheetOptions {
  std::string dir;                // Made if missing.
  std::vector<std::string> only;  // Names of classes and materials, families; empty = everything.
  uint64_t first_seed = 1;
  int cell_px = 192;
  int samples = 12;  // A pixel, before the denoiser.
};

// The files written, and the number of entries.
struct SheetResult {
  // assets-01.png..., materials-01.png..., assets.jpg, materials.jpg.
  std::vector<std::string> files;
  int classes = 0, materials = 0;
};

// Writes pages of twelve rows: an asset class in six seeds, or a material on a ball, a board and a
// chair in two seeds; and one reduced JPEG of each catalogue. `progress` gets the fraction done and
// the name being drawn. Errors: kNotFound for an unknown name; as WriteFile; kCancelled.
absl::StatusOr<SheetResult> WriteCatalogueSheets(
    const SheetOptions& options, const CancelToken& cancel,
    const std::function<void(double, const std::string&)>& progress = {});

}  // namespace parallax
