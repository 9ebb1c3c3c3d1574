// Measures the cost and quality of a stereo pair; prints one JSON line.
//   bench_render [SCENE.pb | solve:SEED[:CONFIG]] [--profile default] [--pairs 20] [--quick]
//   bench_render solve:1 --pairs 2 --baselines 0.06,0.12,0.24
//   bench_render solve:1 --pairs 2 --raster
// First the whole job `render`, as a worker does it: geometry, acceleration structure, radiance
// cache, two images and all ground truth a rig, denoising, encoding, writing. Then PSNR and FLIP of
// parts of the profile's pictures of some rigs against the unbiased reference, all at the exposure
// of the reference's whole view, as in a dataset. The noise that is left in a reference does not
// count: two independent ones are made, and the squared error is estimated by the mean product of
// the differences from one and from the other. Nor does what the display's curve makes of it (a
// noisy pixel looks darker than it is): each of the two is made of two halves, by the jackknife.
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/image/io.h"
#include "tests/bench/program_main.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/load_scene.h"
#include "tests/bench/render/where_time_goes.h"
#include "tests/worker/render/raster/agreement.h"
#include "worker/dataset/frame/render_frames.h"
#include "worker/render/film/exposure.h"
#include "worker/render/paths/profiles.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {
namespace {

using bench::WhereTimeGoes;
using Json = nlohmann::ordered_json;

struct Options {
  std::string scene = "solve:1", profile = "default", size, out, reference_dir, denoise, cache;
  uint64_t seed = 1;
  int pairs = 20, samples = 0, quality_rigs = 5, reference_samples = 192, quality_width = 208;
  bool quick = false;
  std::vector<double> baselines;  // For each left eye; none: the recipe's own rigs.
  bool flow = false, raster = false;
};

double CpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double WallSeconds() {
  return std::chrono::duration<double>(Clock::System().Steady().time_since_epoch()).count();
}

v1::Rig Resized(v1::Rig rig, int width, int height) {
  const double scale = static_cast<double>(width) / rig.width_px();
  rig.set_fx_px(rig.fx_px() * scale);
  rig.set_fy_px(rig.fy_px() * scale);
  rig.set_cx_px(0.5 * width);
  rig.set_cy_px(0.5 * height);
  rig.set_width_px(width);
  rig.set_height_px(height);
  return rig;
}

// A part of the rig's pictures, `width` pixels wide, with their pixels: reduced pictures would have
// finer detail in every pixel than those that are made. The middle, then places around it.
v1::Rig Part(v1::Rig rig, int width, int index) {
  constexpr double kPlaces[][2] = {{0.5, 0.5}, {0.15, 0.8}, {0.85, 0.7}, {0.3, 0.3}, {0.8, 0.2}};
  width = std::min(width, static_cast<int>(rig.width_px()));
  const int height = width * static_cast<int>(rig.height_px()) / static_cast<int>(rig.width_px());
  const auto& place = kPlaces[index % 5];
  rig.set_cx_px(rig.cx_px() - std::floor(place[0] * (static_cast<int>(rig.width_px()) - width)));
  rig.set_cy_px(rig.cy_px() - std::floor(place[1] * (static_cast<int>(rig.height_px()) - height)));
  rig.set_width_px(width);
  rig.set_height_px(height);
  return rig;
}

// Looks at frames on their way to the writer.
class Watched final : public Renderer {
 public:
  struct Totals {
    double cache_s = 0, trace_s = 0, denoise_s = 0, truth_s = 0;
    uint64_t rays = 0;
    // Core seconds when the first and the last pair were rendered. In between, each pair was also
    // written.
    double first_end_core_s = 0, last_end_core_s = 0;
  };
  Watched(std::unique_ptr<Renderer> inner, Totals* totals)
      : inner_(std::move(inner)), totals_(totals) {}

  absl::StatusOr<StereoFrame> RenderRig(const v1::Rig& rig, const CancelToken& cancel,
                                        const ProgressFn& progress) override {
    // Progress says when tracing is under way; the previous frame's writer is counted as others'.
    const ProgressFn watch = [&](double fraction) {
      WhereTimeGoes::Count(fraction > 0 && fraction < 0.949);
      if (progress) progress(fraction);
    };
    auto frame = inner_->RenderRig(rig, cancel, watch);
    WhereTimeGoes::Count(false);
    if (!frame.ok()) return frame;
    totals_->cache_s += frame->cache_s;
    totals_->trace_s += frame->trace_s;
    totals_->denoise_s += frame->denoise_s;
    totals_->truth_s += frame->truth_s;
    totals_->rays += frame->rays;
    totals_->last_end_core_s = CpuSeconds();
    if (totals_->first_end_core_s == 0) totals_->first_end_core_s = totals_->last_end_core_s;
    return frame;
  }

 private:
  const std::unique_ptr<Renderer> inner_;
  Totals* const totals_;
};

v1::RenderConfig ConfigOf(const Options& options) {
  v1::RenderConfig config;
  config.set_profile(options.profile);
  config.set_samples_per_pixel(options.samples);
  if (options.denoise == "on") config.set_denoise(v1::RenderConfig::DENOISE_ON);
  if (options.denoise == "off") config.set_denoise(v1::RenderConfig::DENOISE_OFF);
  if (options.cache == "on") config.set_cache(v1::RenderConfig::CACHE_ON);
  if (options.cache == "off") config.set_cache(v1::RenderConfig::CACHE_OFF);
  for (const char* map :
       {"depth", "disparity", "occlusion", "objects", "materials", "normals", "masks"}) {
    config.add_maps(map);
  }
  if (options.flow) config.add_maps("flow");
  return config;
}

absl::Status MeasureCost(const Options& options, const v1::Scene& recipe, Json* json) {
  const std::string dir =
      options.out.empty()
          ? (std::filesystem::temp_directory_path() / ("bench_render." + std::to_string(getpid())))
                .string()
          : options.out;
  v1::RenderJob job;
  *job.mutable_scene() = recipe;
  *job.mutable_render() = ConfigOf(options);
  for (int i = 0; i < options.pairs; ++i) job.add_rigs(recipe.rigs(i).index());
  Watched::Totals totals;
  double geometry_core_s = 0, build_core_s = 0;
  const RendererFactory factory =
      [&](const v1::Scene& scene,
          const v1::RenderConfig& config) -> absl::StatusOr<std::unique_ptr<Renderer>> {
    const double start = CpuSeconds();
    ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(scene));
    geometry_core_s = CpuSeconds() - start;
    ASSIGN_OR_RETURN(auto renderer, Renderer::Create(scene, std::move(geometry), config));
    build_core_s = CpuSeconds() - start - geometry_core_s;
    return std::make_unique<Watched>(std::move(renderer), &totals);
  };
  RenderJobContext context;
  context.attempt_dir = std::filesystem::absolute(dir).string();
  context.attempt_path = "bench";
  const WhereTimeGoes profiler;
  const double core_start = CpuSeconds(), wall_start = WallSeconds();
  {
    RendererCache cache;
    ASSIGN_OR_RETURN(const v1::RenderResult result, RenderFrames(job, context, factory, cache));
    double write_s = 0, statistics_s = 0;
    for (const v1::FrameResult& frame : result.frames()) {
      write_s += frame.stage_s().at("write");
      statistics_s += frame.stage_s().at("statistics");
    }
    const double n = options.pairs, core_s = CpuSeconds() - core_start;
    (*json)["core_s_per_pair"] = core_s / n;
    if (options.pairs > 1) {
      // What a scene costs once is shared by all pairs of the recipe, rendered here or not.
      const double further_s = (totals.last_end_core_s - totals.first_end_core_s) / (n - 1);
      (*json)["core_s_per_further_pair"] = further_s;
      (*json)["core_s_per_pair_of_scene"] =
          further_s + (core_s - n * further_s) / recipe.rigs_size();
    }
    (*json)["wall_s_per_pair"] = (WallSeconds() - wall_start) / n;
    (*json)["geometry_core_s_per_scene"] = geometry_core_s;
    (*json)["build_core_s_per_scene"] = build_core_s;
    (*json)["cache_s_per_scene"] = totals.cache_s;
    // Wall seconds a pair; encoding and writing overlap with the next rig's.
    (*json)["stage_s"] = {{"truth", totals.truth_s / n},
                          {"trace", totals.trace_s / n},
                          {"denoise", totals.denoise_s / n},
                          {"statistics", statistics_s / n},
                          {"encode_and_write", write_s / n}};
    (*json)["mrays_per_s"] = static_cast<double>(totals.rays) / totals.trace_s * 1e-6;
    (*json)["rays_per_pair"] = static_cast<double>(totals.rays) / n;
    const bench::TimeShares shares = WhereTimeGoes::Shares();
    // Share of tracing alone; neither part includes what other threads write meanwhile.
    (*json)["embree_share"] = shares.embree / std::max(1e-9, shares.embree + shares.program);
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  (*json)["peak_mb"] = usage.ru_maxrss / 1024;
  std::error_code ignored;
  if (options.out.empty()) std::filesystem::remove_all(dir, ignored);
  return absl::OkStatus();
}

// Core-seconds of a pair with one right eye and with several, of the same left eyes; what a scene's
// pairs share (geometry, cache) is made before.
absl::StatusOr<double> WarmPairSeconds(const Options& options, const v1::Scene& recipe, int pairs) {
  const std::string dir =
      (std::filesystem::temp_directory_path() / ("bench_render." + std::to_string(getpid())))
          .string();
  const RendererFactory factory =
      [](const v1::Scene& scene,
         const v1::RenderConfig& config) -> absl::StatusOr<std::unique_ptr<Renderer>> {
    ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(scene));
    return Renderer::Create(scene, std::move(geometry), config);
  };
  RenderJobContext context;
  context.attempt_dir = dir;
  context.attempt_path = "bench";
  v1::RenderJob job;
  *job.mutable_scene() = recipe;
  *job.mutable_render() = ConfigOf(options);
  job.add_rigs(recipe.rigs(recipe.rigs_size() - 1).index());
  RendererCache cache;
  RETURN_IF_ERROR(RenderFrames(job, context, factory, cache).status());
  job.clear_rigs();
  for (int i = 0; i < pairs; ++i) job.add_rigs(recipe.rigs(i).index());
  const double start = CpuSeconds();
  RETURN_IF_ERROR(RenderFrames(job, context, factory, cache).status());
  const double seconds = (CpuSeconds() - start) / pairs;
  std::error_code ignored;
  std::filesystem::remove_all(dir, ignored);
  return seconds;
}

absl::Status MeasureBaselines(const Options& options, const v1::Scene& recipe, Json* json) {
  v1::RigConfig rigs;
  rigs.mutable_baselines_m()->Add(options.baselines.begin(), options.baselines.end());
  v1::Scene single = recipe, several = recipe;
  for (v1::Rig& rig : *single.mutable_rigs()) rig.set_baseline_m(options.baselines[0]);
  AddBaselines(rigs, several);
  const int eyes = rigs.baselines_m_size();
  ASSIGN_OR_RETURN(const double one_s, WarmPairSeconds(options, single, options.pairs));
  ASSIGN_OR_RETURN(const double all_s, WarmPairSeconds(options, several, options.pairs * eyes));
  (*json)["baselines_m"] = options.baselines;
  (*json)["core_s_per_pair_of_one"] = one_s;
  (*json)["core_s_per_pair_of_all"] = all_s;
  (*json)["further_over_first"] = (all_s * eyes - one_s) / ((eyes - 1) * one_s);
  return absl::OkStatus();
}

// Cost of rasterising what both eyes see, and how far it agrees with Embree.
absl::Status MeasureRaster(const Options& options, const bench::LoadedScene& scene, Json* json) {
  ASSIGN_OR_RETURN(const auto built, RenderScene::Build(scene.geometry, 0));
  const double start = CpuSeconds();
  ASSIGN_OR_RETURN(const Rasteriser rasteriser, Rasteriser::Create(*built));
  (*json)["clusters_core_s_per_scene"] = CpuSeconds() - start;
  Rng rng(SceneSeed{1}, "samples");
  test::Agreement sum;
  double core_s = 0;
  for (int i = 0; i < options.pairs; ++i) {
    const v1::Rig& rig = scene.recipe.rigs(i * scene.recipe.rigs_size() / options.pairs);
    ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
    for (const PinholeCamera& eye : stereo.eyes) {
      const double before = CpuSeconds();
      const VisibilityBuffer visible = rasteriser.Draw(eye, 1, {});
      core_s += CpuSeconds() - before;
      Compare(*built, eye, visible, 10'000, rng, &sum);
    }
  }
  const double samples = sum.samples;
  (*json)["raster_core_s_per_pair"] = core_s / options.pairs;
  (*json)["samples_per_pixel"] = VisibilityBuffer::kSamples;
  (*json)["same_triangle"] = sum.same_triangle / samples;
  (*json)["same_depth"] = sum.same_depth / samples;
  (*json)["missed"] = sum.missed / samples;
  (*json)["invented"] = sum.invented / samples;
  return absl::OkStatus();
}

// Both eyes' radiance. One of the four runs of a rig's references; read from the folder of
// references when it is there.
absl::StatusOr<std::vector<ImageF3>> ReferenceRun(const Options& options, v1::Scene recipe,
                                                  const SceneGeometry& geometry, const v1::Rig& rig,
                                                  int run) {
  const int samples = options.reference_samples / 2;
  const std::string key = Sha256Hex(recipe.SerializeAsString() + rig.SerializeAsString() +
                                    std::to_string(samples) + "/" + std::to_string(run))
                              .substr(0, 16);
  const std::string path = options.reference_dir + "/" + key + ".f32";
  const auto width = static_cast<int>(rig.width_px()), height = static_cast<int>(rig.height_px());
  std::vector<ImageF3> images(2, ImageF3(width, height));
  const auto bytes = static_cast<std::streamsize>(images[0].values().size() * sizeof(float));
  if (!options.reference_dir.empty() && std::filesystem::exists(path)) {
    std::ifstream file(path, std::ios::binary);
    for (ImageF3& image : images) file.read(reinterpret_cast<char*>(image.data()), bytes);
    if (!file) return DataLoss("{}: too short", path);
    return images;
  }
  v1::RenderConfig config;
  config.set_profile("reference");
  config.set_samples_per_pixel(samples);
  // The seed of a recipe names its samples only: geometry has its own in its objects.
  recipe.set_scene_seed(recipe.scene_seed() + 0x5eed0000u + static_cast<uint64_t>(run));
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(recipe, geometry, config));
  ASSIGN_OR_RETURN(StereoFrame frame, renderer->RenderRig(rig, {}, {}));
  images = {std::move(frame.left.radiance), std::move(frame.right.radiance)};
  if (!options.reference_dir.empty()) {
    std::filesystem::create_directories(options.reference_dir);
    std::ofstream file(path + ".part", std::ios::binary);
    for (const ImageF3& image : images) {
      file.write(reinterpret_cast<const char*>(image.data()), bytes);
    }
    file.close();
    std::filesystem::rename(path + ".part", path);
  }
  return images;
}

// 8-bit levels, not rounded, of what two noisy runs agree on: twice the levels of their mean, less
// the mean of their levels. Quenouille's jackknife: what the curve's bend makes of noise falls from
// the order of 1 / samples to that of its square.
ImageF3 Levels(const ImageF3& first, const ImageF3& second, float exposure) {
  ImageF3 levels = first;
  for (size_t i = 0; i < levels.values().size(); ++i) {
    const float a = exposure * first.values()[i], b = exposure * second.values()[i];
    levels.values()[i] =
        2 * DisplayLevel(0.5f * (a + b)) - 0.5f * (DisplayLevel(a) + DisplayLevel(b));
  }
  return levels;
}

// Mean of (picture - a) (picture - b): the squared error without the noise of a and b.
double CrossError(const ImageRgb8& picture, const ImageF3& a, const ImageF3& b) {
  double sum = 0;
  for (size_t i = 0; i < picture.values().size(); ++i) {
    const double p = picture.values()[i];
    sum += (p - static_cast<double>(a.values()[i])) * (p - static_cast<double>(b.values()[i]));
  }
  return sum / static_cast<double>(picture.values().size());
}

// The mean of two pictures.
ImageF3 Mean(const ImageF3& a, const ImageF3& b) {
  ImageF3 mean = a;
  for (size_t i = 0; i < mean.values().size(); ++i) {
    mean.values()[i] = 0.5f * (a.values()[i] + b.values()[i]);
  }
  return mean;
}

double MeanOf(const ImageF3& image) {
  double sum = 0;
  for (const float value : image.values()) sum += value;
  return sum / static_cast<double>(image.values().size());
}

double Psnr(double mean_square) {
  return 10 * std::log10(255.0 * 255.0 / std::max(mean_square, 1e-3));
}

// Materials that scatter about alike to all sides wherever they were asked.
std::vector<bool> DiffuseMaterials(const SceneGeometry& geometry) {
  std::vector<bool> diffuse(geometry.materials.size(), true);
  for (size_t m = 0; m < geometry.materials.size(); ++m) {
    if (!geometry.materials[m]) continue;
    for (int k = 0; k < 64; ++k) {
      SurfacePoint point;
      point.texture_m = Vec3f(0.137f, 0.211f, 0.173f) * static_cast<float>(k);
      point.uv = Vec2f(static_cast<float>(k % 8) / 8, static_cast<float>(k / 8) / 8);
      point.footprint_m = 1e-3f;
      const SurfaceSample s = geometry.materials[m]->Evaluate(point);
      if (s.roughness < 0.4f || s.metallic > 0.1f || s.transmission > 0 || s.clearcoat > 0.1f ||
          s.opacity < 1) {
        diffuse[m] = false;
      }
    }
  }
  return diffuse;
}

// Root mean square of left minus right, in 8-bit levels, where both eyes see the same place and
// nothing in its neighbourhood hides another: what a matcher takes for texture that differs.
// Diffuse pixels only: what shines looks different to each eye by rights.
class StereoDifference {
 public:
  explicit StereoDifference(const std::vector<bool>& diffuse) : diffuse_(diffuse) {}
  void Add(const StereoFrame& truth, const ImageRgb8& left, const ImageRgb8& right) {
    const ImageF& disparity = truth.left.disparity_px;
    for (int y = 0; y < disparity.height(); ++y) {
      for (int x = 0; x < disparity.width(); ++x) {
        const float d = disparity(x, y);
        if (d <= 0 || truth.left.occlusion(x, y) || truth.left.masks(x, y)) continue;
        if (!diffuse_[truth.left.materials(x, y)]) continue;
        const float at = static_cast<float>(x) - d;
        const int x0 = static_cast<int>(std::floor(at));
        if (x0 < 0 || x0 + 1 >= disparity.width()) continue;
        const auto meets = [&](int xr) {
          return std::abs(truth.right.disparity_px(xr, y) - d) < 0.25f;
        };
        if (!meets(x0) || !meets(x0 + 1)) continue;
        const float t = at - static_cast<float>(x0);
        for (int c = 0; c < 3; ++c) {
          const float seen = (1 - t) * static_cast<float>(right(x0, y, c)) +
                             t * static_cast<float>(right(x0 + 1, y, c));
          sum_ += std::pow(seen - static_cast<float>(left(x, y, c)), 2);
          ++count_;
        }
      }
    }
  }
  double rms() const { return count_ > 0 ? std::sqrt(sum_ / count_) : 0; }
  double pixels() const { return count_ / 3; }

 private:
  const std::vector<bool> diffuse_;
  double sum_ = 0, count_ = 0;
};

// Exposure of a rig's whole view, from a small picture: exposure looks at coarse blocks only.
absl::StatusOr<float> ExposureOfView(Renderer* renderer, const v1::Rig& rig) {
  constexpr int kWidth = 160;
  const int height = kWidth * static_cast<int>(rig.height_px()) / static_cast<int>(rig.width_px());
  ASSIGN_OR_RETURN(const StereoFrame frame,
                   renderer->RenderRig(Resized(rig, kWidth, height), {}, {}));
  return frame.exposure;
}

absl::Status MeasureQuality(const Options& options, const v1::Scene& recipe,
                            const SceneGeometry& geometry, Json* json) {
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(recipe, geometry, ConfigOf(options)));
  v1::RenderConfig clean;
  clean.set_profile("reference");
  clean.set_samples_per_pixel(64);
  ASSIGN_OR_RETURN(const auto clean_renderer, Renderer::Create(recipe, geometry, clean));
  double squares = 0, flip = 0, ours = 0, wanted = 0, exposure_ratio = 0;
  int pictures = 0;
  Json by_rig = Json::array();
  const std::vector<bool> diffuse = DiffuseMaterials(geometry);
  StereoDifference stereo(diffuse), wanted_stereo(diffuse);
  for (int i = 0; i < options.quality_rigs; ++i) {
    // Spread over the scene's rigs.
    const v1::Rig& full = recipe.rigs(i * recipe.rigs_size() / options.quality_rigs);
    const v1::Rig rig = Part(full, options.quality_width, i);
    ASSIGN_OR_RETURN(StereoFrame frame, renderer->RenderRig(rig, {}, {}));
    std::vector<ImageF3> runs[4];
    for (int k = 0; k < 4; ++k) {
      ASSIGN_OR_RETURN(runs[k], ReferenceRun(options, recipe, geometry, rig, k));
    }
    std::vector<ImageF3> mean;
    for (size_t eye = 0; eye < 2; ++eye) {
      mean.push_back(Mean(Mean(runs[0][eye], runs[1][eye]), Mean(runs[2][eye], runs[3][eye])));
    }
    ASSIGN_OR_RETURN(const float exposure, ExposureOfView(clean_renderer.get(), full));
    ASSIGN_OR_RETURN(const float our_exposure, ExposureOfView(renderer.get(), full));
    exposure_ratio += our_exposure / exposure;
    stereo.Add(frame, ToSrgb(frame.left.radiance, exposure),
               ToSrgb(frame.right.radiance, exposure));
    wanted_stereo.Add(frame, ToSrgb(mean[0], exposure), ToSrgb(mean[1], exposure));
    const View* eyes[2] = {&frame.left, &frame.right};
    const double squares_before = squares;
    for (size_t eye = 0; eye < 2; ++eye, ++pictures) {
      const ImageRgb8 picture = ToSrgb(eyes[eye]->radiance, exposure);
      squares += CrossError(picture, Levels(runs[0][eye], runs[1][eye], exposure),
                            Levels(runs[2][eye], runs[3][eye], exposure));
      flip += bench::MeanFlip(picture, ToSrgb(mean[eye], exposure));
      ours += MeanOf(eyes[eye]->radiance);
      wanted += MeanOf(mean[eye]);
    }
    by_rig.push_back(Psnr((squares - squares_before) / 2));
    if (!options.out.empty()) {
      const std::string name = options.out + "/rig" + std::to_string(full.index());
      std::filesystem::create_directories(options.out);
      const ImageRgb8 picture = ToSrgb(frame.left.radiance, exposure);
      const ImageRgb8 reference = ToSrgb(mean[0], exposure);
      RETURN_IF_ERROR(WritePng(name + ".png", bench::SideBySide(picture, reference)));
      RETURN_IF_ERROR(
          WritePng(name + "_difference.png", bench::DifferenceImage(picture, reference, 8)));
    }
  }
  const int n = std::max(pictures, 1);
  (*json)["psnr_db"] = Psnr(squares / n);
  (*json)["psnr_db_by_rig"] = by_rig;
  (*json)["flip"] = flip / n;
  (*json)["radiance_over_reference"] = ours / wanted;
  (*json)["exposure_over_reference"] = exposure_ratio / std::max(options.quality_rigs, 1);
  (*json)["stereo_rms"] = stereo.rms();
  (*json)["stereo_diffuse_pixels"] = stereo.pixels();
  (*json)["stereo_rms_of_reference"] = wanted_stereo.rms();
  (*json)["quality_rigs"] = options.quality_rigs;
  (*json)["quality_width_px"] = options.quality_width;
  (*json)["reference_samples"] = 2 * options.reference_samples;
  return absl::OkStatus();
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  Options options;
  CLI::App app("Core-seconds, memory and error of stereo pairs");
  app.add_option("scene", options.scene, "solve:SEED[:CONFIG], a recipe (.pb), or demo");
  app.add_option("--profile", options.profile);
  app.add_option("--spp", options.samples, "samples a pixel; 0: the profile's");
  app.add_option("--denoise", options.denoise, "on or off; default: the profile's");
  app.add_option("--cache", options.cache, "on or off; default: the profile's");
  app.add_option("--pairs", options.pairs, "rigs to render; 0: measure quality only");
  app.add_option("--size", options.size, "WIDTHxHEIGHT of the pairs; default: the recipe's");
  app.add_option("--quality-rigs", options.quality_rigs, "rigs compared; 0: measure cost only");
  app.add_option("--quality-width", options.quality_width, "of the pictures compared");
  app.add_option("--reference-spp", options.reference_samples, "of each of two references");
  app.add_option("--reference-dir", options.reference_dir, "keeps references for the next time");
  app.add_option("--out", options.out, "keeps frames and compared pictures there");
  app.add_option("--baselines", options.baselines,
                 "measure what a further right eye of a left one costs, with these baselines only")
      ->delimiter(',');
  app.add_flag("--raster", options.raster,
               "measure the rasteriser alone: cost, and agreement with Embree");
  app.add_flag("--flow", options.flow, "flow maps too, as if the rigs were frames of one way");
  app.add_flag("--quick", options.quick, "two pairs and a small comparison: a minute");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  if (options.quick) {
    options.pairs = std::min(options.pairs, 2);
    options.reference_samples = std::min(options.reference_samples, 48);
    options.quality_rigs = std::min(options.quality_rigs, 2);
  }
  ASSIGN_OR_RETURN(bench::LoadedScene scene,
                   bench::LoadScene(options.scene == "demo" ? "" : options.scene, options.seed));
  int width = 0, height = 0;
  if (std::sscanf(options.size.c_str(), "%dx%d", &width, &height) == 2) {
    for (v1::Rig& rig : *scene.recipe.mutable_rigs()) rig = Resized(rig, width, height);
  }
  for (int i = 0; options.flow && i < scene.recipe.rigs_size(); ++i) {
    scene.recipe.mutable_rigs(i)->set_path(1);
    scene.recipe.mutable_rigs(i)->set_time_s(0.1 * i);
  }
  if (options.samples == 0 && scene.recipe.rigs_size() > 0) {
    // Parts of a picture get as many as the whole does.
    ASSIGN_OR_RETURN(const RenderProfile profile, ResolveProfile(ConfigOf(options)));
    options.samples = profile.SamplesPerPixel(static_cast<int>(scene.recipe.rigs(0).width_px()),
                                              static_cast<int>(scene.recipe.rigs(0).height_px()));
  }
  options.pairs = std::min(options.pairs, scene.recipe.rigs_size());
  options.quality_rigs = std::min(options.quality_rigs, scene.recipe.rigs_size());
  size_t triangles = 0;
  for (const PlacedMesh& placed : scene.geometry.meshes) triangles += placed.mesh->triangles.size();
  Json json;
  json["bench"] = "render";
  json["scene"] = options.scene;
  json["profile"] = options.profile;
  json["pairs"] = options.pairs;
  if (scene.recipe.rigs_size() > 0) {
    json["size"] = std::to_string(scene.recipe.rigs(0).width_px()) + "x" +
                   std::to_string(scene.recipe.rigs(0).height_px());
  }
  json["triangles"] = triangles;
  if (options.baselines.size() > 1) {
    RETURN_IF_ERROR(MeasureBaselines(options, scene.recipe, &json));
    std::printf("%s\n", json.dump().c_str());
    return absl::OkStatus();
  }
  if (options.raster) {
    RETURN_IF_ERROR(MeasureRaster(options, scene, &json));
    std::printf("%s\n", json.dump().c_str());
    return absl::OkStatus();
  }
  if (options.pairs > 0) RETURN_IF_ERROR(MeasureCost(options, scene.recipe, &json));
  if (options.quality_rigs > 0) {
    RETURN_IF_ERROR(MeasureQuality(options, scene.recipe, scene.geometry, &json));
  }
  std::printf("%s\n", json.dump().c_str());
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_render", parallax::Run, argc, argv);
}
