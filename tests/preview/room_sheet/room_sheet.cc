// A contact sheet of solved rooms by the renderer: each from above with its ceiling cut away, and
// from inside, from a corner at eye height.
//   room_sheet --rooms 24 --out rooms.png [--kind living_room] [--house 4] [--width 480] [--spp 16]
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numbers>
#include <string>

#include "common/config/config.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

struct Options {
  int rooms = 24, house = 1, width_px = 480, samples = 16, columns = 4;
  uint64_t first = 1;
  std::string kind, out = "rooms.png", profile = "preview", mode = "full", each;
};

// A camera at `eye` that looks at `target`, without roll.
v1::Rig LookAt(const Vec3d& eye, const Vec3d& target, double fov_rad, int width, int height) {
  const Vec3d forward = (target - eye).normalized();
  Vec3d right = forward.cross(Vec3d::UnitZ());
  right = right.norm() < 1e-6 ? Vec3d::UnitX() : right.normalized();
  Eigen::Matrix3d axes;
  axes << right, forward.cross(right), forward;
  v1::Rig rig;
  *rig.mutable_world_from_left() = ToProto(Pose{eye, Eigen::Quaterniond(axes).normalized(), 1.0});
  rig.set_baseline_m(0.06);
  rig.set_width_px(width);
  rig.set_height_px(height);
  rig.set_fx_px(width / 2.0 / std::tan(fov_rad / 2));
  rig.set_fy_px(rig.fx_px());
  rig.set_cx_px(width / 2.0);
  rig.set_cy_px(height / 2.0);
  return rig;
}

// The corner from which the room looks deepest and nothing stands right before the eye.
v1::Rig FromCorner(const v1::Scene& scene, const SceneGeometry& geometry, int width, int height) {
  RayScene solid;
  for (const PlacedMesh& placed : geometry.meshes)
    solid.Add(*placed.mesh, placed.world_from_object);
  solid.Commit();
  const v1::Room& room = scene.place().house().rooms(0);
  const Vec3d middle(room.width_m() / 2, room.depth_m() / 2, 0.95);
  v1::Rig best;
  double best_value = -1;
  for (int corner = 0; corner < 4; ++corner) {
    for (const double inset : {0.35, 0.6, 0.9}) {
      const Vec3d eye(corner % 2 == 0 ? inset : room.width_m() - inset,
                      corner / 2 == 0 ? inset : room.depth_m() - inset, 1.6);
      const Vec3f at = eye.cast<float>();
      if (solid.NearestDistance(at, 0.3f) < 0.28f || solid.Inside(at)) continue;
      const v1::Rig rig = LookAt(eye, middle, 82 * std::numbers::pi / 180, width, height);
      const Pose pose = FromProto(rig.world_from_left());
      double value = 0;
      for (int i = 0; i < 24 * 14; ++i) {
        const Vec3d ray(((i % 24 + 0.5) / 24 * width - rig.cx_px()) / rig.fx_px(),
                        ((i / 24 + 0.5) / 14 * height - rig.cy_px()) / rig.fy_px(), 1);
        const auto hit = solid.Intersect(at, (pose.rotation * ray).cast<float>());
        value += hit ? std::min(4.0, static_cast<double>(hit->distance)) : 1.0;
        if (hit && hit->distance < 0.5f) value -= 3;
      }
      if (value > best_value) best_value = value, best = rig;
    }
  }
  return best;
}

v1::Scene WithoutCeiling(const v1::Scene& scene) {
  v1::Scene cut = scene;
  cut.clear_objects();
  cut.clear_lights();
  cut.mutable_place()->mutable_house()->set_ceiling_removed(true);
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.part() == "ceiling" || object.part() == "cornice" ||
        object.relation() == "on_ceiling") {
      continue;
    }
    *cut.add_objects() = object;
  }
  cut.mutable_sky()->set_sun_strength(0);
  return cut;
}

absl::StatusOr<ImageRgb8> Picture(const v1::Scene& scene, const SceneGeometry& geometry,
                                  const v1::Rig& rig, const Options& options) {
  v1::RenderConfig config;
  config.set_profile(options.profile);
  config.set_samples_per_pixel(options.samples);
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(scene, geometry, config));
  ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(rig, {}, {}));
  return frame.left.color;
}

void Paste(const ImageRgb8& from, int x0, int y0, ImageRgb8& to) {
  for (int y = 0; y < from.height(); ++y) {
    for (int x = 0; x < from.width(); ++x) {
      for (int c = 0; c < 3; ++c) to(x0 + x, y0 + y, c) = from(x, y, c);
    }
  }
}

// The kind asked for, or one after the other; as large as such rooms are built.
void SetRoom(int number, const std::string& kind, v1::RoomConfig& room) {
  struct Size {
    const char* kind;
    double least_m, most_m;
  };
  constexpr Size kSizes[] = {{"living_room", 4.2, 6.0}, {"dining_room", 3.6, 5.0},
                             {"bedroom", 3.3, 4.8},     {"office", 3.0, 4.4},
                             {"kitchen", 3.0, 4.4},     {"bathroom", 2.2, 3.2},
                             {"hallway", 1.7, 4.6},     {"closet", 1.7, 2.6}};
  const Size* size = &kSizes[static_cast<size_t>(number) % std::size(kSizes)];
  for (const Size& candidate : kSizes) {
    if (kind == candidate.kind) size = &candidate;
  }
  room.clear_kinds();
  room.add_kinds(size->kind);
  const double middle = (size->least_m + size->most_m) / 2;
  room.mutable_width_m()->mutable_uniform()->set_low(middle);
  room.mutable_width_m()->mutable_uniform()->set_high(size->most_m);
  room.mutable_depth_m()->mutable_uniform()->set_low(size->least_m);
  room.mutable_depth_m()->mutable_uniform()->set_high(middle);
}

absl::Status Run(const Options& options) {
  const int w = options.width_px, h = w * 3 / 4;
  const int columns = std::min(options.columns, options.rooms);
  const int rows = (options.rooms + columns - 1) / columns;
  ImageRgb8 sheet(columns * w, rows * 2 * h);
  for (int i = 0; i < options.rooms; ++i) {
    v1::SolveJob job;
    job.set_scene_seed(options.first + static_cast<uint64_t>(i));
    v1::SceneConfig& config = *job.mutable_config();
    config = DefaultSceneConfig();
    config.mutable_solver()->set_mode(options.mode == "full" ? v1::SolverConfig::MODE_FULL
                                                             : v1::SolverConfig::MODE_REDUCED);
    SetRoom(i, options.kind, *config.mutable_room());
    config.mutable_room()->mutable_rooms()->set_constant(options.house);
    config.mutable_floating()->mutable_count()->set_constant(0);
    config.mutable_lighting()->set_mode(v1::LightingConfig::MODE_REALISTIC);
    config.mutable_materials()->set_replace_probability(0);
    config.mutable_rigs()->set_count(1);
    ASSIGN_OR_RETURN(const v1::SolveResult result, Solve(job, {}));
    if (result.has_rejected()) {
      std::fprintf(stderr, "seed %llu: rejected\n",
                   static_cast<unsigned long long>(job.scene_seed()));
      continue;
    }
    const v1::Scene& scene = result.scene();
    const v1::Room& room = scene.place().house().rooms(0);
    const v1::Scene cut = WithoutCeiling(scene);
    ASSIGN_OR_RETURN(const SceneGeometry open, BuildSceneGeometry(cut));
    ASSIGN_OR_RETURN(const SceneGeometry closed, BuildSceneGeometry(scene));
    Vec3d low(0, 0, 0), high(room.width_m(), room.depth_m(), 0);
    for (const v1::Room& other : scene.place().house().rooms()) {
      const Vec3d origin(other.origin_x_m(), other.origin_y_m(), 0);
      low = low.cwiseMin(origin);
      high = high.cwiseMax(Vec3d(origin + Vec3d(other.width_m(), other.depth_m(), 0)));
    }
    const Vec3d size = high - low + Vec3d(0.5, 0.5, 0);
    constexpr double kTopFov = 0.7;
    const double reach = std::max(size.x(), size.y() * 4 / 3) / 2 / std::tan(kTopFov / 2);
    const Vec3d middle(0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), 0);
    // A little from the south, so that walls and fronts show.
    const Vec3d above = middle + Vec3d(0, -0.12 * reach, room.height_m() * 0.6 + reach);
    ASSIGN_OR_RETURN(const ImageRgb8 top,
                     Picture(cut, open, LookAt(above, middle, kTopFov, w, h), options));
    ASSIGN_OR_RETURN(const ImageRgb8 inside,
                     Picture(scene, closed, FromCorner(scene, closed, w, h), options));
    const int x = i % columns * w, y = i / columns * 2 * h;
    Paste(top, x, y, sheet);
    Paste(inside, x, y + h, sheet);
    std::fprintf(stderr, "%2d seed %llu %s: %d objects, loss %.1f\n", i,
                 static_cast<unsigned long long>(job.scene_seed()), room.kind().c_str(),
                 scene.objects_size(), scene.report().final_loss());
    if (!options.each.empty()) {
      RETURN_IF_ERROR(WritePng(options.each + "_" + std::to_string(i) + ".png", inside));
    }
  }
  return WritePng(options.out, sheet);
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Contact sheet of solved rooms: from above and from a corner");
  app.add_option("--rooms", options.rooms, "How many");
  app.add_option("--first", options.first, "Seed of the first");
  app.add_option("--kind", options.kind, "Default: in turn");
  app.add_option("--house", options.house, "Rooms of each house");
  app.add_option("--mode", options.mode);
  app.add_option("--width", options.width_px, "Of one picture");
  app.add_option("--columns", options.columns);
  app.add_option("--spp", options.samples);
  app.add_option("--profile", options.profile);
  app.add_option("--each", options.each, "Also writes EACH_<i>.png: the views from inside");
  app.add_option("--out", options.out);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = parallax::Run(options);
  if (status.ok()) return 0;
  std::fprintf(stderr, "room_sheet: %s\n", std::string(status.message()).c_str());
  return 1;
}
