// assets: a contact sheet of the catalogue in flat colours under sky and sun, to look at the
// modelling.
#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>

#include "common/base/rng.h"
#include "common/base/seconds.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/preview/preview.h"
#include "worker/assets/detail.h"
#include "worker/catalogue/sheet_scene.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/geometry/ray_scene.h"

namespace parallax::preview {
namespace {

constexpr double kFocal = 2.34;  // Focal length over a cell's width: 24 degrees.
constexpr int kSamples = 9;      // A pixel.

struct Options {
  std::string out;
  std::vector<std::string> names;
  int seeds = 2, cell_px = 300, columns = 8, edge_mm = 0;
  uint64_t first_seed = 1;
};

struct FamilyColor {
  std::string_view family;
  float r, g, b;
};
constexpr FamilyColor kFamilyColors[] = {
    {"wood", .42f, .25f, .13f},       {"fabric", .34f, .42f, .46f},
    {"leather", .3f, .14f, .08f},     {"metal", .42f, .43f, .45f},
    {"plastic", .62f, .6f, .56f},     {"ceramic", .7f, .7f, .66f},
    {"glass", .55f, .68f, .66f},      {"paper", .75f, .72f, .64f},
    {"picture", .3f, .35f, .6f},      {"leaf", .13f, .3f, .08f},
    {"soil", .12f, .08f, .05f},       {"paint", .65f, .64f, .6f},
    {"stone", .55f, .54f, .5f},       {"carpet", .45f, .2f, .18f},
    {"mirror", .7f, .75f, .8f},       {"bark", .25f, .17f, .11f},
    {"AutumnLeaf", .4f, .25f, .1f},   {"DryLeaf", .4f, .25f, .1f},
    {"DryGrass", .4f, .25f, .1f},     {"BirchBark", .7f, .68f, .62f},
    {"WhitePetal", .7f, .68f, .62f},  {"FurrowedBark", .22f, .17f, .13f},
    {"ConiferBark", .22f, .17f, .13f}};

// The colour of the slot's first family, with a tint of its own for each name.
Vec3f SlotColor(const MaterialSlot& slot) {
  if (slot.emissive) return {1.4f, 1.3f, 1.0f};
  Vec3f color = slot.sheet ? Vec3f(0.12f, 0.2f, 0.06f) : Vec3f(0.5f, 0.5f, 0.5f);
  for (const FamilyColor& row : kFamilyColors) {
    if (!slot.families.empty() && slot.families[0] == row.family) color = {row.r, row.g, row.b};
  }
  Rng rng(SceneSeed{1}, slot.name);
  for (int c = 0; c < 3; ++c) color[c] *= static_cast<float>(rng.Uniform(0.7, 1.3));
  return color;
}

// An asset, with the ground below it or the wall behind it.
class Studio {
 public:
  Studio(const Mesh& mesh, Placement placement) : mesh_(mesh), box_(mesh.Bounds()) {
    for (const MaterialSlot& slot : mesh.slots) colors_.push_back(SlotColor(slot));
    const float radius = 0.5f * box_.diagonal().norm(), far = 40 * radius;
    const bool wall = placement == Placement::kOnWall || placement == Placement::kOpening;
    const float ground = box_.min().z() - (placement == Placement::kCeiling ? 30 * radius : 0);
    Mesh back;
    for (const Vec2f& c : {Vec2f(-1, -1), Vec2f(1, -1), Vec2f(1, 1), Vec2f(-1, 1)}) {
      back.positions.push_back(wall ? Vec3f(-far * c.x(), box_.min().y(), far * c.y())
                                    : Vec3f(far * c.x(), far * c.y(), ground));
    }
    back.triangles = {{0, 1, 2, 0}, {0, 2, 3, 0}};
    solid_.Add(mesh, Eigen::Affine3f::Identity());
    solid_.Add(back, Eigen::Affine3f::Identity());
    solid_.Commit();
  }

  // The camera from which the box just fits the cell.
  v1::Rig Camera(Placement placement, int cell_px) const {
    const ViewFrame view(placement == Placement::kCeiling  ? Vec3d(0.55, 0.8, -0.12)
                         : placement == Placement::kGround ? Vec3d(0.62, 0.85, 0.2)
                                                           : Vec3d(0.62, 0.85, 0.48));
    const Vec3d target = box_.center().cast<double>();
    double distance = 0;
    for (int c = 0; c < 8; ++c) {
      const Vec3d p = box_.corner(static_cast<Box3f::CornerType>(c)).cast<double>() - target;
      const double side = std::max(std::abs(p.dot(view.right)), std::abs(p.dot(view.up)));
      distance = std::max(distance, 2.13 * kFocal * side - p.dot(view.forward));
    }
    return view.RigAt(target - distance * view.forward, kFocal * cell_px, cell_px, cell_px);
  }

  Vec3f Shade(const Vec3f& eye, const Vec3f& direction, Rng& rng) const {
    const auto hit = solid_.Intersect(eye, direction);
    if (!hit) return {0.75f, 0.8f, 0.85f};
    const Vec3f p = eye + hit->distance * direction;
    Vec3f n = hit->normal, color = Vec3f::Constant(0.6f);
    const bool behind = n.dot(direction) > 0;
    if (hit->body == 0) {
      const Triangle& triangle = mesh_.triangles[hit->triangle];
      const MaterialSlot& slot = mesh_.slots[triangle.slot];
      if (behind && !slot.sheet) return {1, 0, 1};  // An error of winding, or a hole.
      color = colors_[triangle.slot];
      if (slot.emissive) return color;
      if (slot.sheet) color *= 0.75f + 0.5f * mesh_.uv[triangle.a].x();
      n = ShadingNormal(triangle, p);
    }
    if (n.dot(direction) > 0) n = -n;
    const Vec3f from = p + 1e-4f * box_.diagonal().norm() * n;
    const auto sphere = [&] {
      return Vec3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                   static_cast<float>(rng.Normal()))
          .normalized();
    };
    const auto lit = [&](const Vec3f& towards) {
      return n.dot(towards) > 0 && !solid_.Intersect(from, towards);
    };
    Vec3f light = Vec3f::Constant(0.22f * std::abs(n.dot(direction)));
    const Vec3f sky = (n + 0.999f * sphere()).normalized();
    if (lit(sky)) light += Vec3f(0.62f, 0.66f, 0.72f) * (0.75f + 0.35f * sky.z());
    const Vec3f sun = (Vec3f(0.75f, 0.35f, 1).normalized() + 0.1f * sphere()).normalized();
    if (lit(sun)) light += Vec3f(1.25f, 1.15f, 1.0f) * n.dot(sun);
    return color.cwiseProduct(light);
  }

 private:
  Vec3f ShadingNormal(const Triangle& t, const Vec3f& p) const {
    const Vec3f a = mesh_.positions[t.a], b = mesh_.positions[t.b] - a,
                c = mesh_.positions[t.c] - a;
    const Vec3f cross = b.cross(c);
    const float v = (p - a).cross(c).dot(cross) / cross.squaredNorm();
    const float w = b.cross(p - a).dot(cross) / cross.squaredNorm();
    return ((1 - v - w) * mesh_.normals[t.a] + v * mesh_.normals[t.b] + w * mesh_.normals[t.c])
        .normalized();
  }

  const Mesh& mesh_;
  Box3f box_;
  std::vector<Vec3f> colors_;  // By slot.
  RayScene solid_;
};

ImageRgb8 Draw(const Mesh& mesh, Placement placement, int cell_px) {
  const Studio studio(mesh, placement);
  const v1::Rig rig = studio.Camera(placement, cell_px);
  const Pose pose = FromProto(rig.world_from_left());
  ImageRgb8 image(cell_px, cell_px);
  tbb::parallel_for(0, cell_px, [&](int y) {
    Rng rng(SceneSeed{static_cast<uint64_t>(y)}, "preview");
    for (int x = 0; x < cell_px; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int s = 0; s < kSamples; ++s) {
        const Vec3d ray((x + (s % 3 + rng.Uniform(0, 1)) / 3 - rig.cx_px()) / rig.fx_px(),
                        (y + (s / 3 + rng.Uniform(0, 1)) / 3 - rig.cy_px()) / rig.fy_px(), 1);
        sum += studio.Shade(pose.translation.cast<float>(),
                            (pose.rotation * ray).normalized().cast<float>(), rng);
      }
      for (int c = 0; c < 3; ++c) {
        const float value = std::clamp(0.62f * sum[c] / kSamples, 0.0f, 1.0f);
        image(x, y, c) = static_cast<uint8_t>(255 * std::pow(value, 1 / 2.2f) + 0.5f);
      }
    }
  });
  return image;
}

absl::Status Run(const Options& options) {
  std::vector<std::string> names = options.names;
  if (names.empty()) {
    for (const AssetClass& c : AssetCatalogue()) names.push_back(c.name);
  }
  const int cell = options.cell_px, count = static_cast<int>(names.size()) * options.seeds;
  const int columns = std::min(options.columns, count), rows = (count + columns - 1) / columns;
  Canvas sheet(columns * cell, rows * cell);
  for (int i = 0; i < count; ++i) {
    const std::string& name = names[static_cast<size_t>(i / options.seeds)];
    const uint64_t seed = options.first_seed + static_cast<uint64_t>(i % options.seeds);
    const auto start = std::chrono::steady_clock::now();
    ASSIGN_OR_RETURN(const Asset asset,
                     MakeAsset(name, seed, 1e-3f * static_cast<float>(options.edge_mm)));
    const double ms = 1e3 * SecondsSince(start);
    const Mesh& mesh = asset.mesh;
    if (const absl::Status valid = ValidateMesh(mesh); !valid.ok()) {
      fmt::print(stderr, "{} seed {}: {}\n", name, seed, ToStd(valid.message()));
    }
    const Vec3f size = mesh.Bounds().sizes();
    fmt::print("{:<22} {:2}  {:7} triangles  {:6.2f} ms  {:.2f} x {:.2f} x {:.2f} m\n", name, seed,
               mesh.triangles.size(), ms, size.x(), size.y(), size.z());
    const int x = i % columns * cell, y = i / columns * cell;
    sheet.DrawImage(x, y, cell, cell, Draw(mesh, FindAssetClass(name)->placement, cell));
    sheet.DrawText(x + 6, y + 16,
                   fmt::format("{}  {:.2f} x {:.2f} x {:.2f}  {}k", name, size.x(), size.y(),
                               size.z(), (mesh.triangles.size() + 500) / 1000),
                   8.5, {0, 0, 0});
  }
  return WritePng(options.out, sheet.image());
}

}  // namespace

Action Assets(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command.add_option("OUT", options->out, "PNG to write")->required();
  command.add_option("CLASS", options->names, "Default: all");
  command.add_option("--seeds", options->seeds, "Cells of a class");
  command.add_option("--first-seed", options->first_seed);
  command.add_option("--cell", options->cell_px, "Pixels");
  command.add_option("--columns", options->columns);
  command.add_option("--edge-mm", options->edge_mm, "0: the class's own detail");
  return [options] { return Run(*options); };
}

}  // namespace parallax::preview
