#include "worker/catalogue/sheet_scene.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "common/math/proto.h"
#include "worker/assets/kernel/primitives.h"
#include "worker/render/renderer.h"
#include "worker/scene/choose_materials.h"

namespace parallax {
namespace {

constexpr double kViewDistance = 7;  // Distance of the camera, in widths of a cell.
constexpr double kFill = 0.86;       // Share of a cell that the largest object takes.
constexpr double kLampPower_w = 60;

ViewFrame UsualView() { return ViewFrame({0.62, 0.85, 0.48}); }
ViewFrame ViewFromAbove() { return ViewFrame({0.4, 0.62, 1.05}); }
ViewFrame ViewFromBelow() { return ViewFrame({0.55, 0.8, 0.14}); }

// Flat things are looked down at.
ViewFrame ViewOf(const AssetClass& asset_class, const std::vector<Box3f>& boxes) {
  if (asset_class.placement == Placement::kCeiling) return ViewFromBelow();
  const bool flat = std::all_of(boxes.begin(), boxes.end(), [](const Box3f& box) {
    const Vec3f size = box.sizes();
    return size.z() < 0.16f * std::max(size.x(), size.y());
  });
  return flat ? ViewFromAbove() : UsualView();
}

// Both eyes look along the frame, the left one at `target`; a cell is `cell_m` wide there.
v1::Rig CellRig(const ViewFrame& view, const Vec3d& target, double cell_m, double baseline_m,
                int width_px, int cell_px) {
  v1::Rig rig = view.RigAt(target - kViewDistance * cell_m * view.forward, kViewDistance * cell_px,
                           width_px, cell_px);
  rig.set_baseline_m(baseline_m);
  return rig;
}

void SetDaylight(v1::Scene& recipe) {
  recipe.set_type(v1::SCENE_TYPE_DENSE);  // Things under the open sky.
  recipe.mutable_place()->mutable_open_sky();
  recipe.mutable_sky()->set_strength(0.9);
  *recipe.mutable_sky()->mutable_tint() = ToProto(Vec3d(1, 1, 1));
  recipe.mutable_sky()->set_sun_elevation_rad(0.85);
  recipe.mutable_sky()->set_sun_azimuth_rad(0.1);
  recipe.mutable_sky()->set_sun_strength(0.5);
}

// The next object of the recipe's numbering, not of the catalogue.
void AddMesh(SheetRow& row, Mesh mesh, uint32_t material, const Eigen::Affine3f& place) {
  v1::SceneObject& object = *row.recipe.add_objects();
  object.set_index(static_cast<uint32_t>(row.recipe.objects_size()));
  PlacedMesh placed;
  placed.material_of_slot.assign(mesh.slots.size(), material);
  placed.mesh = std::make_shared<const Mesh>(std::move(mesh));
  placed.world_from_object = place;
  placed.object_index = object.index();
  row.geometry.meshes.push_back(std::move(placed));
}

Mesh OneSlot(const kernel::Shape& shape) {
  Mesh mesh;
  mesh.slots.push_back({"surface", {}, false});
  kernel::AppendShape(mesh, shape, {0}, Vec3f::Zero());
  return mesh;
}

// Lets the emissive slots of an object shine.
void LightLamps(v1::Scene& recipe, uint32_t object_index, const Mesh& mesh) {
  for (const MaterialSlot& slot : mesh.slots) {
    if (!slot.emissive) continue;
    v1::Light& light = *recipe.add_lights();
    light.set_kind(v1::Light::KIND_MESH);
    light.set_object_index(object_index);
    light.set_slot(slot.name);
    *light.mutable_power_w() = ToProto(Vec3d(1.2, 1, 0.75) * kLampPower_w);
  }
}

absl::StatusOr<uint32_t> AddGrey(SheetRow& row) { return AddMaterial(row, "PlainGrey", 1); }

}  // namespace

ViewFrame::ViewFrame(const Vec3d& from) : forward(-from.normalized()) {
  right = forward.cross(Vec3d::UnitZ());
  right = right.norm() < 1e-6 ? Vec3d::UnitX() : right.normalized();
  up = right.cross(forward);
}

v1::Rig ViewFrame::RigAt(const Vec3d& eye, double focal_px, int width_px, int height_px) const {
  Eigen::Matrix3d world_from_camera;
  world_from_camera << right, -up, forward;
  Pose pose;
  pose.translation = eye;
  pose.rotation = Eigen::Quaterniond(world_from_camera);
  v1::Rig rig;
  *rig.mutable_world_from_left() = ToProto(pose);
  rig.set_baseline_m(0.06);
  rig.set_fx_px(focal_px);
  rig.set_fy_px(focal_px);
  rig.set_cx_px(0.5 * width_px);
  rig.set_cy_px(0.5 * height_px);
  rig.set_width_px(width_px);
  rig.set_height_px(height_px);
  return rig;
}

v1::SceneObject& AddObject(v1::Scene& recipe, const std::string& asset_class, uint64_t seed,
                           const std::string& relation) {
  v1::SceneObject& object = *recipe.add_objects();
  object.set_index(static_cast<uint32_t>(recipe.objects_size()));
  object.set_name(fmt::format("{}_{}", asset_class, seed));
  object.set_asset_class(asset_class);
  object.set_seed(seed);
  object.set_role(v1::OBJECT_ROLE_FLOATING);
  object.set_relation(relation);
  return object;
}

absl::StatusOr<SheetRow> DressRow(SceneInProgress& scene) {
  v1::MaterialConfig materials;
  materials.set_mode(v1::MaterialConfig::MODE_ALL);
  materials.set_replace_probability(0);
  RETURN_IF_ERROR(ChooseMaterials(materials, nullptr, scene));
  SheetRow row;
  row.recipe = scene.recipe;
  ASSIGN_OR_RETURN(row.geometry, BuildSceneGeometry(row.recipe));
  return row;
}

absl::StatusOr<uint32_t> AddMaterial(SheetRow& row, const std::string& name, uint64_t seed) {
  ASSIGN_OR_RETURN(auto material, MakeMaterial(name, seed));
  if (row.geometry.materials.empty()) row.geometry.materials.resize(1);
  row.geometry.materials.push_back(std::move(material));
  return static_cast<uint32_t>(row.geometry.materials.size() - 1);
}

void AddFloor(SheetRow& row, uint32_t material, const Vec3d& middle, float half_m) {
  const kernel::Shape slab = kernel::RoundedBox({2 * half_m, 2 * half_m, 0.02f * half_m}, {0});
  AddMesh(row, OneSlot(slab), material,
          Eigen::Affine3f(Eigen::Translation3f(static_cast<float>(middle.x()),
                                               static_cast<float>(middle.y()), -0.01f * half_m)));
}

absl::StatusOr<SheetRow> MakeAssetRow(const AssetClass& asset_class, uint64_t first_seed,
                                      int cell_px) {
  const bool hangs = asset_class.placement == Placement::kCeiling;
  const bool on_wall = asset_class.placement == Placement::kOnWall;
  SceneInProgress scene;
  scene.seed = SceneSeed{first_seed};
  SetDaylight(scene.recipe);
  std::vector<Box3f> boxes;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  for (int k = 0; k < kRowCells; ++k) {
    const uint64_t seed = first_seed + static_cast<uint64_t>(k);
    ASSIGN_OR_RETURN(const PooledAsset* asset, scene.pool.Get(asset_class.name, seed));
    const v1::SceneObject& object =
        AddObject(scene.recipe, asset_class.name, seed, on_wall ? "on_wall" : "floating");
    LightLamps(scene.recipe, object.index(), *asset->mesh);
    boxes.push_back(asset->bounds);
    meshes.push_back(asset->mesh);
  }
  const ViewFrame view = ViewOf(asset_class, boxes);
  double low = 1e9, high = -1e9, half = 0;
  for (const auto& mesh : meshes) {
    for (const Vec3f& p : mesh->positions) {
      const Vec3d q = p.cast<double>();
      low = std::min(low, q.dot(view.up));
      high = std::max(high, q.dot(view.up));
      half = std::max(half, std::abs(q.dot(view.right)));
    }
  }
  const double cell_m = std::max(2 * half, high - low) / kFill;
  for (int k = 0; k < kRowCells; ++k) {
    Pose pose;
    pose.translation = k * cell_m * view.right;
    // Things of walls and ceilings float clear of the floor.
    const Box3f& box = boxes[static_cast<size_t>(k)];
    if (hangs) pose.translation.z() = 0;
    if (on_wall) pose.translation.z() = 0.12 * static_cast<double>(box.sizes().z());
    *scene.recipe.mutable_objects(k)->mutable_world_from_object() = ToProto(pose);
  }
  ASSIGN_OR_RETURN(SheetRow row, DressRow(scene));
  ASSIGN_OR_RETURN(const uint32_t grey, AddGrey(row));
  const Vec3d middle = 2.5 * cell_m * view.right;
  const float ground = hangs ? static_cast<float>(low - 2 * cell_m) : 0.0f;
  AddFloor(row, grey, middle, static_cast<float>(40 * cell_m));
  row.geometry.meshes.back().world_from_object.translation().z() += ground;
  if (on_wall) {
    for (int k = 0; k < kRowCells; ++k) {
      const Vec3f size = boxes[static_cast<size_t>(k)].sizes();
      const Vec3f at = (k * cell_m * view.right).cast<float>();
      AddMesh(row,
              OneSlot(kernel::Board({-0.6f * size.x(), -0.04f * size.x(), 0.0f},
                                    {0.6f * size.x(), 0.0f, 1.24f * size.z()})),
              grey, Eigen::Affine3f(Eigen::Translation3f(at)));
    }
  }
  // Three things an eye.
  const double up = 0.5 * (low + high) + (on_wall ? 0.06 * (high - low) : 0);
  row.rigs.push_back(CellRig(view, cell_m * view.right + up * view.up, cell_m, 3 * cell_m,
                             kRowCells / 2 * cell_px, cell_px));
  return row;
}

absl::StatusOr<SheetRow> MakeMaterialRow(const MaterialClass& material_class, uint64_t first_seed,
                                         int cell_px) {
  constexpr double kApart_m = 4;
  constexpr float kBall_m = 0.12f, kBoard_m = 0.4f;
  const ViewFrame view = UsualView();
  SheetRow row;
  SetDaylight(row.recipe);
  ASSIGN_OR_RETURN(const uint32_t grey, AddGrey(row));
  uint32_t materials[2];
  for (uint64_t k = 0; k < 2; ++k) {
    ASSIGN_OR_RETURN(materials[k], AddMaterial(row, material_class.name, first_seed + k));
  }
  ASSIGN_OR_RETURN(const Asset chair, MakeAsset("Chair", 4));
  kernel::Shape ball = kernel::Ball(kBall_m, 96);
  for (kernel::Face& face : ball.faces) {
    for (int c = 0; c < face.corners; ++c) {
      const Vec3f p = ball.points[face.v[static_cast<size_t>(c)]] / kBall_m;
      face.uv[static_cast<size_t>(c)] = {0.5f + 0.5f * p.dot(view.right.cast<float>()),
                                         0.5f + 0.5f * p.dot(view.up.cast<float>())};
    }
  }
  kernel::Shape board = kernel::RoundedBox({kBoard_m, 0.018f, kBoard_m}, {0.004f, 2});
  kernel::PrintFaces(board, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 0);
  board = board.TurnedX(0.25f).TurnedZ(-0.35f);
  const std::vector<Mesh> things = {OneSlot(ball), OneSlot(board), chair.mesh};
  for (size_t t = 0; t < things.size(); ++t) {
    const Box3f box = things[t].Bounds();
    const double lift = -static_cast<double>(box.min().z());
    double low = 1e9, high = -1e9, half = 0;
    for (const Vec3f& p : things[t].positions) {
      const Vec3d q = p.cast<double>() + Vec3d(0, 0, lift);
      low = std::min(low, q.dot(view.up));
      high = std::max(high, q.dot(view.up));
      half = std::max(half, std::abs(q.dot(view.right)));
    }
    const Vec3d first = 2 * kApart_m * static_cast<double>(t) * view.right;
    for (int k = 0; k < 2; ++k) {
      const Vec3d at = first + k * kApart_m * view.right + Vec3d(0, 0, lift);
      AddMesh(row, things[t], materials[k],
              Eigen::Affine3f(Eigen::Translation3f(at.cast<float>())));
    }
    v1::Rig rig = CellRig(view, first + 0.5 * (low + high) * view.up,
                          std::max(2 * half, high - low) / kFill, kApart_m, cell_px, cell_px);
    rig.set_index(static_cast<uint32_t>(t));
    row.rigs.push_back(rig);
  }
  AddFloor(row, grey, 2.5 * kApart_m * view.right, 60);
  return row;
}

absl::StatusOr<std::vector<ImageRgb8>> RenderRow(SheetRow row, int cell_px, int samples,
                                                 const CancelToken& cancel) {
  v1::RenderConfig config;
  config.set_profile("default");
  config.set_samples_per_pixel(samples);
  ASSIGN_OR_RETURN(const auto renderer,
                   Renderer::Create(row.recipe, std::move(row.geometry), config));
  std::vector<ImageRgb8> cells;
  for (const v1::Rig& rig : row.rigs) {
    ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(rig, cancel, {}));
    for (const ImageRgb8* picture : {&frame.left.color, &frame.right.color}) {
      for (int x0 = 0; x0 + cell_px <= picture->width(); x0 += cell_px) {
        ImageRgb8 cell(cell_px, cell_px);
        for (int y = 0; y < cell_px; ++y) {
          std::copy_n(picture->At(x0, y), 3 * cell_px, cell.At(0, y));
        }
        cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

}  // namespace parallax
