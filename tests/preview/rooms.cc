// rooms: solved rooms by the renderer, each from above with its ceiling cut away, and from inside,
// from a corner at eye height.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "common/config/config.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/preview/preview.h"
#include "worker/catalogue/sheet_scene.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/geometry/ray_scene.h"
#include "worker/render/renderer.h"
#include "worker/scene/solve_scene.h"

namespace parallax::preview {
namespace {

struct Options {
  int rooms = 24, house = 1, floating = 0, width_px = 480, samples = 16, columns = 4;
  uint64_t first = 1;
  std::string kind, out = "rooms.png", profile = "preview", mode = "full", each;
  bool furniture = true;
};

v1::Rig LookAt(const Vec3d& eye, const Vec3d& target, double fov_rad, int width, int height) {
  return ViewFrame(eye - target).RigAt(eye, width / 2.0 / std::tan(fov_rad / 2), width, height);
}

// The corner from which the room looks deepest and nothing is right before the eye.
v1::Rig FromCorner(const v1::Scene& scene, const SceneGeometry& geometry, int width, int height) {
  RayScene solid;
  for (const PlacedMesh& placed : geometry.meshes) {
    solid.Add(*placed.mesh, placed.world_from_object);
  }
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
      const v1::Rig rig = LookAt(eye, middle, 82 * M_PI / 180, width, height);
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

v1::Scene WithoutCeiling(v1::Scene scene) {
  scene.clear_lights();
  scene.mutable_place()->mutable_house()->set_ceiling_removed(true);
  auto& objects = *scene.mutable_objects();
  objects.erase(std::remove_if(objects.begin(), objects.end(),
                               [](const v1::SceneObject& object) {
                                 return object.part() == "ceiling" || object.part() == "cornice" ||
                                        object.relation() == "on_ceiling";
                               }),
                objects.end());
  scene.mutable_sky()->set_sun_strength(0);
  return scene;
}

// A little from the south, so that walls and fronts show.
v1::Rig FromAbove(const v1::House& house, int width, int height) {
  const v1::Room& room = house.rooms(0);
  Vec3d low(0, 0, 0), high(room.width_m(), room.depth_m(), 0);
  for (const v1::Room& other : house.rooms()) {
    const Vec3d origin(other.origin_x_m(), other.origin_y_m(), 0);
    low = low.cwiseMin(origin);
    high = high.cwiseMax(Vec3d(origin + Vec3d(other.width_m(), other.depth_m(), 0)));
  }
  constexpr double kFov = 0.7;
  const Vec3d size = high - low + Vec3d(0.5, 0.5, 0), middle = 0.5 * (low + high);
  const double reach = std::max(size.x(), size.y() * 4 / 3) / 2 / std::tan(kFov / 2);
  return LookAt(middle + Vec3d(0, -0.12 * reach, room.height_m() * 0.6 + reach), middle, kFov,
                width, height);
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

v1::SolveJob JobOf(int number, const Options& options) {
  v1::SolveJob job;
  job.set_scene_seed(options.first + static_cast<uint64_t>(number));
  v1::SceneConfig& config = *job.mutable_config();
  config = DefaultSceneConfig();
  config.mutable_solver()->set_mode(options.mode == "full" ? v1::SolverConfig::MODE_FULL
                                                           : v1::SolverConfig::MODE_REDUCED);
  SetRoom(number, options.kind, *config.mutable_room());
  config.mutable_room()->mutable_rooms()->set_constant(options.house);
  config.mutable_furniture()->set_enabled(options.furniture);
  config.mutable_floating()->mutable_count()->set_constant(options.floating);
  config.mutable_lighting()->set_mode(v1::LightingConfig::MODE_REALISTIC);
  config.mutable_materials()->set_replace_probability(0);
  config.mutable_rigs()->set_count(1);
  return job;
}

absl::Status Run(const Options& options) {
  const int w = options.width_px, h = w * 3 / 4;
  const int columns = std::min(options.columns, options.rooms);
  const int rows = (options.rooms + columns - 1) / columns;
  Canvas sheet(columns * w, rows * 2 * h);
  for (int i = 0; i < options.rooms; ++i) {
    const v1::SolveJob job = JobOf(i, options);
    ASSIGN_OR_RETURN(const v1::SolveResult result, Solve(job, {}));
    if (result.has_rejected()) {
      fmt::print(stderr, "seed {}: rejected: {}\n", job.scene_seed(), result.rejected().reason());
      continue;
    }
    const v1::Scene& scene = result.scene();
    const v1::Scene cut = WithoutCeiling(scene);
    ASSIGN_OR_RETURN(const SceneGeometry open, BuildSceneGeometry(cut));
    ASSIGN_OR_RETURN(const SceneGeometry closed, BuildSceneGeometry(scene));
    ASSIGN_OR_RETURN(const ImageRgb8 top,
                     Picture(cut, open, FromAbove(scene.place().house(), w, h), options));
    ASSIGN_OR_RETURN(const ImageRgb8 inside,
                     Picture(scene, closed, FromCorner(scene, closed, w, h), options));
    const int x = i % columns * w, y = i / columns * 2 * h;
    sheet.DrawImage(x, y, w, h, top);
    sheet.DrawImage(x, y + h, w, h, inside);
    fmt::print(stderr,
               "{:2} seed {} {}: {} objects, loss {:.1f}, layout {:.2f} s, dress {:.2f} s\n", i,
               job.scene_seed(), scene.place().house().rooms(0).kind(), scene.objects_size(),
               scene.report().final_loss(), result.layout_s(), result.dress_s());
    if (options.each.empty()) continue;
    const std::string stem = options.each + "_" + std::to_string(i);
    RETURN_IF_ERROR(WritePng(stem + ".png", inside));
    std::ofstream(stem + ".pb", std::ios::binary) << scene.SerializeAsString();
  }
  return WritePng(options.out, sheet.image());
}

}  // namespace

Action Rooms(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command.add_option("--out", options->out, "PNG to write");
  command.add_option("--rooms", options->rooms, "How many");
  command.add_option("--first", options->first, "Seed of the first");
  command.add_option("--kind", options->kind, "Default: in turn");
  command.add_option("--house", options->house, "Rooms of each house");
  command.add_option("--mode", options->mode)->check(CLI::IsMember({"full", "reduced"}));
  command.add_option("--floating", options->floating, "Objects in the air");
  command.add_flag("!--no-furniture", options->furniture);
  command.add_option("--width", options->width_px, "Of one picture");
  command.add_option("--columns", options->columns);
  command.add_option("--spp", options->samples);
  command.add_option("--profile", options->profile);
  command.add_option(
      "--each", options->each,
      "Also writes EACH_<i>.png, the views from inside, and EACH_<i>.pb, the recipes "
      "(`parallax scene show` prints them)");
  return [options] { return Run(*options); };
}

}  // namespace parallax::preview
