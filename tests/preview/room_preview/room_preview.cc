// Draws a solved scene for people: one view from above without the ceiling, and views of some rigs.
// Flat colours by object (or by material class) under a headlight.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

struct Options {
  uint64_t seed = 1;
  std::string kind, mode = "full", out = "room";
  int floating = -1, views = 4, width_px = 640;
  bool furniture = true;
  std::string recipe;
};

class Painter {
 public:
  explicit Painter(const v1::Scene& recipe) : recipe_(recipe) {
    const SceneGeometry geometry = BuildSceneGeometry(recipe).value();
    meshes_ = geometry.meshes;
    for (const PlacedMesh& placed : meshes_) {
      solid_.Add(*placed.mesh, placed.world_from_object);
      triangles_ += placed.mesh->triangles.size();
    }
    solid_.Commit();
  }
  size_t triangles() const { return triangles_; }
  void HideCeiling() {
    for (int i = 0; i < recipe_.objects_size(); ++i) {
      if (recipe_.objects(i).part() == "ceiling")
        solid_.SetEnabled(static_cast<uint32_t>(i), false);
    }
    solid_.Commit();
  }

  Vec3f Shade(const Vec3f& origin, const Vec3f& direction) const {
    const auto hit = solid_.Intersect(origin, direction);
    if (!hit) return {0.75f, 0.85f, 0.95f};
    const v1::SceneObject& object = recipe_.objects(static_cast<int>(hit->body));
    const Mesh& mesh = *meshes_[hit->body].mesh;
    const std::string& slot = mesh.slots[mesh.triangles[hit->triangle].slot].name;
    Rng rng(SceneSeed{object.seed()}, object.asset_class() + "/" + slot);
    Vec3f color;
    for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(rng.Uniform(0.25, 0.9));
    if (object.part() == "walls") color = {0.85f, 0.82f, 0.76f};
    if (object.part() == "floor") color = {0.55f, 0.42f, 0.3f};
    const float facing = std::abs(hit->normal.dot(direction.normalized()));
    const Vec3f sun = Vec3f(0.4f, 0.25f, 0.88f);
    const float light = 0.25f + 0.5f * facing + 0.25f * std::abs(hit->normal.dot(sun));
    // Corners are darker: a few fixed probes tell how much room there is.
    const Vec3f at = origin + hit->distance * direction;
    const Vec3f n = hit->normal.dot(direction) > 0 ? Vec3f(-hit->normal) : hit->normal;
    const float near = solid_.NearestDistance(at + 0.05f * n, 0.05f) / 0.05f;
    return color * light * (0.6f + 0.4f * near);
  }

 private:
  const v1::Scene& recipe_;
  RayScene solid_;
  std::vector<PlacedMesh> meshes_;
  size_t triangles_ = 0;
};

void Put(ImageRgb8& image, int x, int y, const Vec3f& color) {
  for (int c = 0; c < 3; ++c) {
    const float v = std::pow(std::clamp(color[c], 0.0f, 1.0f), 1 / 2.2f);
    image(x, y, c) = static_cast<uint8_t>(v * 255 + 0.5f);
  }
}

ImageRgb8 RigView(const Painter& painter, const v1::Rig& rig, int width) {
  const int height = width * rig.height_px() / rig.width_px();
  ImageRgb8 image(width, height);
  const Pose pose = FromProto(rig.world_from_left());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int s = 0; s < 2; ++s) {
        const double u = (x + 0.25 + 0.5 * s) * rig.width_px() / width;
        const double v = (y + 0.75 - 0.5 * s) * rig.height_px() / height;
        const Vec3d d((u - rig.cx_px()) / rig.fx_px(), (v - rig.cy_px()) / rig.fy_px(), 1);
        sum += painter.Shade(pose.translation.cast<float>(), (pose.rotation * d).cast<float>());
      }
      Put(image, x, y, sum / 2);
    }
  }
  return image;
}

ImageRgb8 TopView(const Painter& painter, const v1::Room& room, int width) {
  const double margin = 0.4, w = room.width_m() + 2 * margin, d = room.depth_m() + 2 * margin;
  const int height = static_cast<int>(width * d / w);
  ImageRgb8 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec3f from(static_cast<float>((x + 0.5) / width * w - margin),
                       static_cast<float>((1 - (y + 0.5) / height) * d - margin),
                       static_cast<float>(room.height_m() - 0.05));
      Put(image, x, y, painter.Shade(from, {0.0f, 0.0f, -1.0f}));
    }
  }
  return image;
}

int Main(const Options& options) {
  v1::SolveJob job;
  job.set_scene_seed(options.seed);
  v1::SceneConfig& config = *job.mutable_config();
  config = DefaultSceneConfig();
  if (!options.kind.empty()) {
    config.mutable_room()->clear_kinds();
    config.mutable_room()->add_kinds(options.kind);
  }
  config.mutable_solver()->set_mode(options.mode == "full" ? v1::SolverConfig::MODE_FULL
                                                           : v1::SolverConfig::MODE_REDUCED);
  config.mutable_furniture()->set_enabled(options.furniture);
  if (options.floating >= 0)
    config.mutable_floating()->mutable_count()->set_constant(options.floating);
  const auto result = Solve(job, CancelToken());
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().ToString().c_str());
    return 1;
  }
  if (result->has_rejected()) {
    std::fprintf(stderr, "rejected: %s\n", result->rejected().reason().c_str());
    return 2;
  }
  const v1::Scene& scene = result->scene();
  for (const v1::SceneObject& o : scene.objects()) {
    if (o.role() == v1::OBJECT_ROLE_FLOATING) continue;
    std::printf("%3u %-24s %-14s parent %3u  at %6.2f %6.2f %6.2f\n", o.index(), o.name().c_str(),
                o.relation().c_str(), o.parent_index(), o.world_from_object().tx(),
                o.world_from_object().ty(), o.world_from_object().tz());
  }
  for (const auto& c : scene.report().constraints()) {
    std::printf("%-45s %s %.3f\n", c.name().c_str(), c.hard() ? "hard" : "soft", c.violation());
  }
  if (!options.recipe.empty()) {
    std::ofstream file(options.recipe, std::ios::binary);
    if (!scene.SerializeToOstream(&file)) return 1;
  }
  Painter painter(scene);
  std::printf(
      "%s %.2f x %.2f x %.2f m, layout %.2f s, dress %.2f s, %d objects, %d materials, %zu "
      "triangles\n",
      scene.place().house().rooms(0).kind().c_str(), scene.place().house().rooms(0).width_m(),
      scene.place().house().rooms(0).depth_m(), scene.place().house().rooms(0).height_m(),
      result->layout_s(), result->dress_s(), scene.objects_size(), scene.materials_size(),
      painter.triangles());
  for (int i = 0; i < std::min(options.views, scene.rigs_size()); ++i) {
    const std::string path = options.out + "_" + std::to_string(i) + ".png";
    if (!WritePng(path, RigView(painter, scene.rigs(i), options.width_px)).ok()) return 1;
  }
  painter.HideCeiling();
  return WritePng(options.out + "_top.png",
                  TopView(painter, scene.place().house().rooms(0), options.width_px))
                 .ok()
             ? 0
             : 1;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Draws a solved room: OUT_top.png and OUT_<rig>.png");
  app.add_option("--seed", options.seed);
  app.add_option("--kind", options.kind);
  app.add_option("--mode", options.mode, "full or reduced");
  app.add_option("--out", options.out);
  app.add_option("--floating", options.floating, "How many; default: as the config draws");
  app.add_option("--views", options.views);
  app.add_option("--width", options.width_px);
  app.add_flag("!--no-furniture", options.furniture);
  app.add_option("--recipe", options.recipe, "Also write the Scene message to this file");
  CLI11_PARSE(app, argc, argv);
  return parallax::Main(options);
}
