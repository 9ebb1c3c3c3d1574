// Small open-air scenes with objects in a row, and their pictures. For the
// catalogue's sheets and for tests/preview.
#pragma once

#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "parallax/v1/scene.pb.h"
#include "worker/assets/asset.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/choose_materials.h"

namespace parallax {

inline constexpr int kRowCells = 6;

// The content of one renderer: each picture of the rigs' eyes is one cell of the row, or holds
// several cells side by side.
struct SheetRow {
  v1::Scene recipe;
  SceneGeometry geometry;
  std::vector<v1::Rig> rigs;
};

// Axes of a camera without roll that looks from the direction `from` at the origin.
struct ViewFrame {
  Vec3d right, up, forward;
  explicit ViewFrame(const Vec3d& from);
  // Returns a rig whose left eye is at `eye` in the world frame, metres; baseline 6 cm, square
  // pixels, the principal point in the middle.
  v1::Rig RigAt(const Vec3d& eye, double focal_px, int width_px, int height_px) const;
};

// Adds an object of a class at the origin. Returns it; the recipe owns it.
v1::SceneObject& AddObject(v1::Scene& recipe, const std::string& asset_class, uint64_t seed,
                           const std::string& relation);
// Gives the objects the materials that rooms would give them and makes their meshes. Errors: those
// of ChooseMaterials and BuildSceneGeometry.
absl::StatusOr<SheetRow> DressRow(SceneInProgress& scene);
// Adds a material of the catalogue; returns its index. Errors: kNotFound for an unknown name.
absl::StatusOr<uint32_t> AddMaterial(SheetRow& row, const std::string& name, uint64_t seed);
// Adds a slab with its top at z = 0, `half_m` from `middle` to each side.
void AddFloor(SheetRow& row, uint32_t material, const Vec3d& middle, float half_m);

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
