// Small open-air scenes with objects in a row, and their pictures. Private to worker/catalogue.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "parallax/v1/scene.pb.h"
#include "worker/assets/asset.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/build_geometry.h"

namespace parallax {

inline constexpr int kRowCells = 6;

// The content of one renderer: each picture of the rigs' eyes is one cell of the row, or holds
// several cells side by side.
struct SheetRow {
  v1::Scene recipe;
  SceneGeometry geometry;
  std::vector<v1::Rig> rigs;
};

// Returns a row with six seeds of a class from `first_seed` on, with the materials that rooms would
// give them, at one common scale. Errors: the catalogue's.
absl::StatusOr<SheetRow> MakeAssetRow(const AssetClass& asset_class, uint64_t first_seed,
                                      int cell_px);

// Returns a row with a ball of 24 cm, an upright board of 40 cm and a chair, each in two seeds of
// the material.
// Errors: the catalogue's.
absl::StatusOr<SheetRow> MakeMaterialRow(const MaterialClass& material_class, uint64_t first_seed,
                                         int cell_px);

// Renders the row. Returns its six cells from left to right, each `cell_px` square. Errors:
// kCancelled, kResourceExhausted.
absl::StatusOr<std::vector<ImageRgb8>> RenderRow(SheetRow row, int cell_px, int samples,
                                                 const CancelToken& cancel);

}  // namespace parallax
