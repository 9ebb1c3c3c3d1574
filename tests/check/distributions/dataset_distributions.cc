#include "tests/check/distributions/dataset_distributions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <mutex>
#include <numbers>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/assets/asset.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

using Samples = std::map<std::string, std::vector<double>>;

// Source: Kolmogorov's limiting distribution with Stephens' correction for finite n.
double KolmogorovP(double d, int64_t n) {
  const double root = std::sqrt(static_cast<double>(n));
  const double x = (root + 0.12 + 0.11 / root) * d;
  if (x < 0.2) return 1;  // Where the series converges badly; 1 to twelve digits.
  double sum = 0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * x * x);
  return std::clamp(sum, 0.0, 1.0);
}

// The distribution function by its inverse: the largest u whose value does not exceed x.
double Cdf(const v1::Distribution& distribution, double x) {
  if (Draw(distribution, 0) > x) return 0;
  double low = 0, high = 1;
  for (int i = 0; i < 52; ++i) {
    const double middle = (low + high) / 2;
    (Draw(distribution, middle) <= x ? low : high) = middle;
  }
  return high;
}

DistributionRow Row(const std::string& quantity, const std::string& configured,
                    std::vector<double> samples, const std::function<double(double)>& cdf,
                    double expected_mean) {
  DistributionRow row{quantity, configured, static_cast<int64_t>(samples.size()), 0, expected_mean};
  if (samples.empty()) {
    row.p = 0;
    return row;
  }
  std::sort(samples.begin(), samples.end());
  const double n = static_cast<double>(samples.size());
  for (size_t i = 0; i < samples.size();) {
    size_t end = i;
    while (end < samples.size() && samples[end] == samples[i]) row.mean += samples[end++];
    const double at = cdf(samples[i]);
    const double before = cdf(std::nextafter(samples[i], -1e300));
    row.statistic = std::max({row.statistic, std::abs(static_cast<double>(end) / n - at),
                              std::abs(static_cast<double>(i) / n - before)});
    i = end;
  }
  row.mean /= n;
  row.p = KolmogorovP(row.statistic, row.samples);
  return row;
}

DistributionRow Row(const std::string& quantity, const v1::Distribution& distribution,
                    const std::vector<double>& samples) {
  double mean = 0;
  constexpr int kSteps = 4096;
  for (int i = 0; i < kSteps; ++i) mean += Draw(distribution, (i + 0.5) / kSteps) / kSteps;
  std::string text = MessageToYaml(distribution);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return Row(
      quantity, text, samples, [&](double x) { return Cdf(distribution, x); }, mean);
}

v1::Distribution Uniform(double low, double high) {
  v1::Distribution d;
  d.mutable_uniform()->set_low(low);
  d.mutable_uniform()->set_high(high);
  return d;
}

v1::Distribution Bernoulli(double p) {
  v1::Distribution d;
  d.mutable_bernoulli()->set_p(p);
  return d;
}

v1::SceneConfig RoomConfig() {
  v1::SceneConfig config = DefaultSceneConfig();
  config.mutable_solver()->set_steps(1);
  config.mutable_rigs()->set_count(1);
  config.mutable_floating()->add_classes("Book");
  config.mutable_floating()->add_classes("Can");
  // Small enough that each finds a place at once, whatever its orientation.
  *config.mutable_floating()->mutable_size_m() = Uniform(0.05, 0.1);
  return config;
}

v1::SceneConfig DenseConfig(int keyframes) {
  v1::SceneConfig config = LoadSceneConfig("dense").value();
  config.mutable_floating()->mutable_count()->set_constant(6);
  config.mutable_floating()->add_classes("Can");
  config.mutable_rigs()->set_count(keyframes);
  return config;
}

v1::SolveResult SolveOf(const v1::SceneConfig& config, uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = config;
  const auto result = Solve(job, CancelToken());
  if (!result.ok()) {
    std::cerr << result.status() << "\n";
    std::abort();
  }
  return *result;
}

double MeanW(const v1::Light& light) {
  return (light.power_w().x() + light.power_w().y() + light.power_w().z()) / 3;
}

void MeasureRoom(const v1::SolveResult& result, Samples& out) {
  const v1::Scene& scene = result.scene();
  int floating = 0;
  std::map<uint32_t, std::string> material_class;
  for (const v1::SceneMaterial& m : scene.materials())
    material_class[m.index()] = m.material_class();
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.role() != v1::OBJECT_ROLE_FLOATING) continue;
    ++floating;
    const Asset asset = MakeAsset(object.asset_class(), object.seed()).value();
    const Pose pose = FromProto(object.world_from_object());
    out["size"].push_back(pose.scale * double{asset.mesh.Bounds().diagonal().maxCoeff()});
    out["turn"].push_back((pose.rotation * Vec3d::UnitX()).z());
    out["class"].push_back(object.asset_class() == "Book" ? 1 : 0);
  }
  out["count"].push_back(floating);
  double point_w = 0;
  int points = 0;
  std::map<std::string, double> lamps;
  for (const v1::Light& light : scene.lights()) {
    if (light.kind() == v1::Light::KIND_POINT) {
      point_w += MeanW(light);
      ++points;
    } else {
      lamps[light.name()] = MeanW(light);
    }
  }
  out["points"].push_back(points);
  if (points > 0) out["power"].push_back(point_w);
  out["ceiling"].push_back(scene.place().house().ceiling_removed());
  if (!scene.place().house().ceiling_removed()) {
    std::map<uint32_t, std::string> relation;
    for (const auto& object : scene.objects()) relation[object.index()] = object.relation();
    for (const v1::Light& light : result.layout().lights()) {
      const auto now = lamps.find(light.name());
      if (now == lamps.end() || relation[light.object_index()] != "on_ceiling") continue;
      out["dimmed"].push_back(std::abs(now->second - MeanW(light)) > 1e-9 * MeanW(light));
      break;
    }
  }
  out["sky"].push_back(scene.sky().strength());
  for (const v1::Rig& rig : scene.rigs()) out["baseline"].push_back(rig.baseline_m());
}

void MeasureKeyframes(const v1::Scene& scene, Samples& out) {
  for (int k = 0; k < scene.keyframes_size(); ++k) {
    const v1::Keyframe& keyframe = scene.keyframes(k);
    for (int i = 0; i < scene.objects_size(); ++i) {
      const Asset asset =
          MakeAsset(scene.objects(i).asset_class(), scene.objects(i).seed()).value();
      const Pose pose = KeyframePose(keyframe, i);
      // A warped mesh's middle is near the unwarped one's; distances are 5 m and more.
      out["distance"].push_back((pose * asset.mesh.Bounds().center().cast<double>()).norm());
      out["dense turn"].push_back((pose.rotation * Vec3d::UnitX()).z());
    }
    double power = 0;
    for (const v1::Light& light : keyframe.lights()) {
      power += MeanW(light);
      out["light distance"].push_back(FromProto(light.position_m()).norm());
    }
    out["dense points"].push_back(keyframe.lights_size());
    if (power > 0) out["dense power"].push_back(power);
    out["dense sky"].push_back(keyframe.sky().strength());
    const Vec3d tint = FromProto(keyframe.sky().tint());
    out["dense hue"].push_back(tint.x() - tint.z());
    const v1::Rig& rig = scene.rigs(k);
    out["dense baseline"].push_back(rig.baseline_m());
    out["fov"].push_back(2 * std::atan(rig.width_px() / 2.0 / rig.fx_px()) * 180 /
                         std::numbers::pi);
    const Vec3d forward = FromProto(rig.world_from_left()).rotation * Vec3d::UnitZ();
    out["pitch"].push_back(std::acos(-forward.z()) * 180 / std::numbers::pi);
  }
}

// The part of objects whose materials were replaced, over many objects of one room.
void MeasureMaterials(uint64_t seed, int objects, Samples& out) {
  v1::SceneConfig config = DenseConfig(1);
  config.mutable_floating()->mutable_count()->set_constant(objects);
  config.mutable_floating()->set_allow_intersections(true);
  config.mutable_materials()->set_replace_probability(0.5);
  const v1::Scene scene = SolveOf(config, seed).scene();
  config.mutable_materials()->set_replace_probability(0);
  const v1::Scene own = SolveOf(config, seed).scene();
  const auto bound = [](const v1::Scene& s, int object, int slot) {
    const uint32_t index = s.objects(object).materials(slot).material_index();
    for (const v1::SceneMaterial& m : s.materials()) {
      if (m.index() == index) return m.material_class() + std::to_string(m.seed());
    }
    return std::string();
  };
  for (int i = 0; i < scene.objects_size(); ++i) {
    // A print (the label of a can) is never replaced; the other slots go together.
    bool replaced = false;
    for (int slot = 0; slot < scene.objects(i).materials_size(); ++slot) {
      replaced = replaced || bound(scene, i, slot) != bound(own, i, slot);
    }
    out["replaced"].push_back(replaced);
  }
}

}  // namespace

std::vector<DistributionRow> CheckDistributions(int scenes, uint64_t first_seed) {
  constexpr int kKeyframes = 100;
  const v1::SceneConfig room = RoomConfig(), dense = DenseConfig(kKeyframes);
  std::vector<Samples> of_scene(static_cast<size_t>(scenes));
  tbb::parallel_for(0, scenes, [&](int i) {
    Samples& out = of_scene[static_cast<size_t>(i)];
    const uint64_t seed = first_seed + static_cast<uint64_t>(i);
    const v1::SolveResult result = SolveOf(room, seed);
    if (result.has_scene()) MeasureRoom(result, out);
    if (i % kKeyframes == 0) {
      MeasureKeyframes(SolveOf(dense, seed).scene(), out);
      MeasureMaterials(seed, kKeyframes, out);
    }
  });
  Samples all;
  for (const Samples& samples : of_scene) {
    for (const auto& [name, values] : samples) {
      all[name].insert(all[name].end(), values.begin(), values.end());
    }
  }
  const v1::LightingConfig &light = room.lighting(), &dense_light = dense.lighting();
  return {
      Row("floating: count", room.floating().count(), all["count"]),
      Row("floating: longest side, m", room.floating().size_m(), all["size"]),
      Row("floating: orientation (z of the x axis)", Uniform(-1, 1), all["turn"]),
      Row("floating: class (one of two)", Bernoulli(0.5), all["class"]),
      Row("point lights: count", light.point_lights(), all["points"]),
      Row("point lights: total power, W", light.point_power_w(), all["power"]),
      Row("ceiling removed", Bernoulli(light.ceiling_removed_p()), all["ceiling"]),
      Row("ceiling lights dimmed", Bernoulli(light.ceiling_dimmed_p()), all["dimmed"]),
      Row("sky strength", light.sky_strength(), all["sky"]),
      Row("baseline, m", room.rigs().baseline_m(), all["baseline"]),
      Row("materials replaced", Bernoulli(0.5), all["replaced"]),
      Row("dense: distance, m", dense.floating().distance_m(), all["distance"]),
      Row("dense: orientation", Uniform(-1, 1), all["dense turn"]),
      Row("dense: baseline, m", dense.rigs().baseline_m(), all["dense baseline"]),
      Row("dense: point lights", dense_light.point_lights(), all["dense points"]),
      Row("dense: light distance, m", dense_light.point_distance_m(), all["light distance"]),
      Row("dense: total power, W", dense_light.point_power_w(), all["dense power"]),
      Row("dense: sky strength", dense_light.sky_strength(), all["dense sky"]),
      Row("dense: field of view, degrees", dense.rigs().horizontal_fov_deg(), all["fov"]),
      Row("dense: pitch, degrees", dense.rigs().pitch_deg(), all["pitch"]),
  };
}

}  // namespace parallax
