// nature_check [--biome NAME|FILE.yaml] [--season NAME] [--seed N] [--scenes N] [--frames N]
// [--render K] [--size WxH] [--profile NAME] [--out DIR]:
// solves scenes of the type nature, makes them solid, checks how things stand, renders K frames of
// each (evenly along the walk) and prints one JSON line a scene: sizes, core-seconds of all
// threads, memory, and what was found. With --out the rendered left images are written.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "common/math/stereo.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/nature/walk/arena.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct Options {
  v1::SceneConfig config;
  uint64_t seed = 1;
  int scenes = 1, render = 1;
  std::string out;
};

// Gaps between the rendered ground and the objects within 40 m of the eyes.
struct Rooting {
  int checked = 0, daylight = 0;
  double worst_m = 0;
};

Rooting CheckRoots(const v1::Terrain& land, const Expansion& expansion, const Vec2f& from) {
  Rooting rooting;
  size_t index = 0;
  for (int l = 0; l < land.layers_size(); ++l) {
    const v1::ScatterLayer& layer = land.layers(l);
    for (uint32_t k = 0; k < expansion.of_layer[static_cast<size_t>(l)]; ++k, ++index) {
      if (layer.hangs()) continue;
      const Instance& instance = expansion.instances[index];
      const Vec2f p = instance.world_from_object.col(3).head<2>();
      if ((p - from).norm() > 40) continue;
      // Half of the ground that it claims, or a stem; in its own frame.
      const auto radius = static_cast<float>(std::max(0.02, 0.5 * layer.claim_m()));
      if (layer.floats()) continue;
      ++rooting.checked;
      double highest = -1;
      for (const Vec3f& q :
           {Vec3f(radius, 0, 0), Vec3f(-radius, 0, 0), Vec3f(0, radius, 0), Vec3f(0, -radius, 0)}) {
        const Vec3f at = instance.Affine() * q;
        highest = std::max(highest,
                           static_cast<double>(at.z() - expansion.ground.HeightAt(at.head<2>())));
      }
      rooting.worst_m = std::max(rooting.worst_m, highest);
      rooting.daylight += highest > 0.005;
    }
  }
  return rooting;
}

double Clearance(const v1::Scene& scene, const RayScene& nearby, double baseline_m) {
  float least = 5;
  for (const v1::Rig& rig : scene.rigs()) {
    const Vec3d left = EyePosition(rig, 0), right = RigAxes(rig).col(0);
    for (int k = 0; k <= 8; ++k) {
      const Vec3d eye = left + k / 8.0 * baseline_m * right;
      least = nearby.NearestDistance(eye.cast<float>(), least);
    }
  }
  return static_cast<double>(least);
}

// Adds what the rendered frames show.
absl::Status Render(const v1::Scene& scene, SceneGeometry geometry, const Options& options,
                    Json& json) {
  double start = CpuSeconds();
  ASSIGN_OR_RETURN(auto renderer,
                   Renderer::Create(scene, std::move(geometry), options.config.render()));
  json["create_s"] = CpuSeconds() - start;
  std::vector<float> disparities;
  double sky = 0, pixels = 0, far = 0, mixed = 0, veiled = 0, level = 0;
  start = CpuSeconds();
  Json parts = Json::object();
  for (int k = 0; k < options.render; ++k) {
    const int index = options.render == 1 ? scene.rigs_size() / 2
                                          : k * (scene.rigs_size() - 1) / (options.render - 1);
    const v1::Rig& rig = scene.rigs(index);
    ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(rig, CancelToken(), {}));
    const View& left = frame.left;
    float nearest = 1e9f;
    double sum = 0;
    for (const uint8_t value : left.color.values()) sum += value;
    level += sum / static_cast<double>(left.color.values().size());
    for (size_t i = 0; i < left.depth_m.values().size(); ++i) {
      const float depth = left.depth_m.values()[i];
      ++pixels;
      mixed += (left.masks.values()[i] & 16) != 0;
      veiled += (left.masks.values()[i] & 32) != 0;
      if (depth <= 0) {
        ++sky;
        continue;
      }
      nearest = std::min(nearest, depth);
      if (i % 7 == 0) disparities.push_back(left.disparity_px.values()[i]);
    }
    far += nearest >= 5;
    parts = {{"truth", frame.truth_s},
             {"cache", frame.cache_s},
             {"trace", frame.trace_s},
             {"denoise", frame.denoise_s}};
    if (options.out.empty()) continue;
    char name[96];
    std::snprintf(name, sizeof name, "/%s_%llu_%03d", scene.place().terrain().biome().c_str(),
                  static_cast<unsigned long long>(scene.scene_seed()), index);
    RETURN_IF_ERROR(WriteJpeg(options.out + name + ".jpg", left.color, 92));
    RETURN_IF_ERROR(WritePng(options.out + name + ".png", left.color));
  }
  json["render_s_a_pair"] = (CpuSeconds() - start) / options.render;
  json["last_wall_s"] = parts;
  std::sort(disparities.begin(), disparities.end());
  Json quantiles = Json::object();
  for (const double q : {0.05, 0.25, 0.5, 0.75, 0.95}) {
    if (disparities.empty()) break;
    quantiles[std::to_string(static_cast<int>(100 * q))] =
        disparities[static_cast<size_t>(q * static_cast<double>(disparities.size() - 1))];
  }
  json["disparity_px"] = quantiles;
  // Shares and quantiles are of pixels that show a thing; 4 pixels are those of a picture 1280
  // wide.
  const double four_px = 4.0 * options.config.rigs().width_px() / 1280;
  const auto below = std::lower_bound(disparities.begin(), disparities.end(), four_px);
  json["below_4_px_of_1280_share"] = static_cast<double>(below - disparities.begin()) /
                                     std::max<double>(1, static_cast<double>(disparities.size()));
  json["sky_share"] = sky / pixels;
  json["mixed_share"] = mixed / pixels;
  json["veiled_share"] = veiled / pixels;
  json["mean_level"] = level / options.render;
  json["frames_beyond_5_m"] = far / options.render;
  return absl::OkStatus();
}

absl::StatusOr<Json> Check(const Options& options, uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = options.config;
  double start = CpuSeconds();
  ASSIGN_OR_RETURN(const v1::SolveResult solved, Solve(job, CancelToken()));
  Json json = {{"bench", "nature_check"},
               {"seed", seed},
               {"solve_s", CpuSeconds() - start},
               {"layout_wall_s", solved.layout_s()},
               {"dress_wall_s", solved.dress_s()}};
  if (!solved.has_scene()) {
    json["rejected"] = solved.rejected().reason();
    return json;
  }
  const v1::Scene& scene = solved.scene();
  const v1::Terrain& land = scene.place().terrain();
  json["biome"] = land.biome() + " in " + land.season();
  const v1::Sky& sky = scene.sky();
  json["sky"] = {{"sun_strength", sky.sun_strength()},
                 {"sun_elevation_rad", sky.sun_elevation_rad()},
                 {"turbidity", sky.turbidity()},
                 {"cloud_cover", sky.cloud_cover()},
                 {"haze_per_m", scene.air().haze_per_m()}};
  json["recipe_bytes"] = scene.ByteSizeLong();
  start = CpuSeconds();
  ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(scene));
  json["build_s"] = CpuSeconds() - start;
  size_t unique = geometry.meshes[0].mesh->triangles.size(), placed = unique;
  json["ground_triangles"] = unique;
  for (const Prototype& prototype : geometry.prototypes) unique += prototype.mesh->triangles.size();
  for (const Instance& instance : geometry.instances) {
    placed += geometry.prototypes[instance.prototype].mesh->triangles.size();
  }
  json["instances"] = geometry.instances.size();
  json["unique_triangles"] = unique;
  json["placed_triangles"] = placed;
  ASSIGN_OR_RETURN(const auto expansion, ExpandTerrain(land, scene.rigs()));
  Json layers = Json::object();
  for (int l = 0; l < land.layers_size(); ++l) {
    layers[land.layers(l).name()] = expansion->of_layer[static_cast<size_t>(l)];
  }
  json["layers"] = layers;
  const Rooting rooting =
      CheckRoots(land, *expansion, EyePosition(scene.rigs(0), 0).head<2>().cast<float>());
  json["roots"] = {
      {"checked", rooting.checked}, {"daylight", rooting.daylight}, {"worst_m", rooting.worst_m}};
  ASSIGN_OR_RETURN(const auto nearby, MakeNearby(land, *expansion, scene.rigs(), 1));
  json["clearance_m"] = Clearance(scene, *nearby, options.config.rigs().clearance_baseline_m());
  if (options.render > 0) RETURN_IF_ERROR(Render(scene, std::move(geometry), options, json));
  json["peak_mb"] = PeakMegabytes();
  return json;
}

// Only the biome of this name, or of this file, is drawn.
absl::Status ChooseBiome(const std::string& name, v1::NatureConfig& nature) {
  v1::BiomeWeights& weights = *nature.mutable_biomes();
  const auto* fields = weights.GetDescriptor();
  if (name.ends_with(".yaml")) {
    v1::OwnBiome& own = *nature.add_own_biomes();
    ASSIGN_OR_RETURN(*own.mutable_biome(), LoadBiome(name));
    own.set_weight(1);
  } else if (fields->FindFieldByName(name) == nullptr) {
    return InvalidArgument("there is no biome {}", name);
  }
  for (int i = 0; i < fields->field_count(); ++i) {
    weights.GetReflection()->SetDouble(&weights, fields->field(i),
                                       fields->field(i)->name() == name);
  }
  return absl::OkStatus();
}

absl::StatusOr<Options> ParseOptions(int argc, char** argv) {
  Options options;
  ASSIGN_OR_RETURN(options.config, LoadSceneConfig("nature"));
  v1::SceneConfig& config = options.config;
  if (argc % 2 == 0) {
    return InvalidArgument(
        "{}: no value; use: nature_check [--biome NAME|FILE.yaml] [--season NAME] [--seed N] "
        "[--scenes N] "
        "[--frames N] [--render K] [--size WxH] [--profile NAME] [--out DIR]",
        argv[argc - 1]);
  }
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--biome") {
      RETURN_IF_ERROR(ChooseBiome(value, *config.mutable_nature()));
    } else if (name == "--season") {
      config.mutable_nature()->clear_seasons();
      config.mutable_nature()->add_seasons(value);
    } else if (name == "--seed") {
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    } else if (name == "--scenes") {
      options.scenes = std::atoi(value.c_str());
    } else if (name == "--frames") {
      config.mutable_rigs()->set_count(std::atoi(value.c_str()));
    } else if (name == "--render") {
      options.render = std::atoi(value.c_str());
    } else if (name == "--profile") {
      config.mutable_render()->set_profile(value);
    } else if (name == "--out") {
      options.out = value;
    } else if (name == "--size") {
      int width = 0, height = 0;
      if (std::sscanf(value.c_str(), "%dx%d", &width, &height) != 2) {
        return InvalidArgument("--size: WxH");
      }
      config.mutable_rigs()->set_width_px(width);
      config.mutable_rigs()->set_height_px(height);
    } else {
      return InvalidArgument("unknown option {}", name);
    }
  }
  return options;
}

int Main(int argc, char** argv) {
  const auto options = ParseOptions(argc, argv);
  if (!options.ok()) {
    std::cerr << options.status() << "\n";
    return 2;
  }
  if (!options->out.empty()) std::filesystem::create_directories(options->out);
  for (int i = 0; i < options->scenes; ++i) {
    const auto json = Check(*options, options->seed + static_cast<uint64_t>(i));
    if (!json.ok()) {
      std::cerr << json.status() << "\n";
      return 1;
    }
    std::cout << json->dump() << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
