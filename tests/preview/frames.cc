// frames: a study's frames without coordinator or workers, for timing the worker's part alone.
// Prints one JSON line with the seconds of each part.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/rng.h"
#include "common/base/system/clock.h"
#include "common/base/system/log.h"
#include "common/config/config.h"
#include "tests/preview/preview.h"
#include "worker/dataset/archive/archive.h"
#include "worker/dataset/frame/render_job.h"
#include "worker/dataset/sheets/contact_sheet.h"
#include "worker/scene/solve_scene.h"

namespace parallax::preview {
namespace {

struct Options {
  std::string study = "quickstart", out, profile;
  int pairs = 0, width_px = 0, height_px = 0, samples = 0;
  uint64_t first_seed = 0;
};

double Now() {
  return std::chrono::duration<double>(Clock::System().Steady().time_since_epoch()).count();
}

absl::Status RunVariant(const Options& options, const v1::StudySpec& study,
                        const v1::VariantSpec& variant, ArchiveWriter& archive,
                        nlohmann::ordered_json& figures) {
  const std::string store = options.out + "/.store";
  int64_t missing = study.pairs();
  for (uint32_t scene = 0; missing > 0 && scene < 100; ++scene) {
    v1::SolveJob solve;
    solve.set_scene_seed(options.first_seed + scene + 1);
    *solve.mutable_config() = variant.config();
    double begin = Now();
    ASSIGN_OR_RETURN(v1::SolveResult solved, Solve(solve, CancelToken()));
    figures["solve_s"] = figures.value("solve_s", 0.0) + Now() - begin;
    if (!solved.has_scene()) {
      LogInfo("rejected", {{"seed", solve.scene_seed()}, {"reason", solved.rejected().reason()}});
      continue;
    }
    RETURN_IF_ERROR(archive.AddScene(variant.name(), scene, solved.scene()));
    v1::RenderJob job;
    *job.mutable_scene() = solved.scene();
    *job.mutable_render() = variant.config().render();
    for (int rig = 0; rig < std::min<int64_t>(missing, study.rigs_per_scene()); ++rig) {
      job.add_rigs(solved.scene().rigs(rig).index());
    }
    const std::string key = variant.name() + std::to_string(scene);
    begin = Now();
    ASSIGN_OR_RETURN(const v1::RenderResult rendered,
                     RunRenderJob(job, {.attempt_dir = store + "/" + key, .attempt_path = key}));
    figures["render_s"] = figures.value("render_s", 0.0) + Now() - begin;
    figures["build_s"] = figures.value("build_s", 0.0) + rendered.build_s();
    for (const v1::FrameResult& frame : rendered.frames()) {
      v1::PublishedFrame published;
      published.set_variant(variant.name());
      published.set_scene(scene);
      *published.mutable_frame() = frame;
      RETURN_IF_ERROR(archive.AddFrame(published, store));
      for (const auto& [stage, seconds] : frame.stage_s()) {
        figures["stages"][stage] = figures["stages"].value(stage, 0.0) + seconds;
      }
      figures["pairs"] = figures.value("pairs", 0) + 1;
      --missing;
    }
  }
  return absl::OkStatus();
}

absl::Status Run(const Options& options) {
  ASSIGN_OR_RETURN(v1::StudySpec study, LoadStudy(options.study));
  if (options.pairs > 0) study.set_pairs(options.pairs);
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    v1::SceneConfig& config = *variant.mutable_config();
    if (!options.profile.empty()) config.mutable_render()->set_profile(options.profile);
    if (options.samples > 0) config.mutable_render()->set_samples_per_pixel(options.samples);
    if (options.width_px > 0) config.mutable_rigs()->set_width_px(options.width_px);
    if (options.height_px > 0) config.mutable_rigs()->set_height_px(options.height_px);
  }
  RETURN_IF_ERROR(ValidateStudy(study));
  ASSIGN_OR_RETURN(const auto archive, ArchiveWriter::Open(options.out, study));
  nlohmann::ordered_json figures = {{"bench", "frames"}, {"study", study.name()}};
  figures["stages"] = nlohmann::ordered_json::object();
  for (const v1::VariantSpec& variant : study.variants()) {
    RETURN_IF_ERROR(RunVariant(options, study, variant, *archive, figures));
  }
  double begin = Now();
  RETURN_IF_ERROR(archive->Finish());
  figures["finish_s"] = Now() - begin;
  begin = Now();
  ASSIGN_OR_RETURN(const ContactSheetResult sheet,
                   MakeContactSheet(options.out, options.out + "/contact_sheet.png"));
  figures["sheet_s"] = Now() - begin;
  figures["warp_median_difference"] = sheet.warp_median_difference;
  figures["sheet"] = sheet.sheet_png;
  std::cout << figures.dump() << "\n";
  return absl::OkStatus();
}

}  // namespace

Action Frames(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command.add_option("study", options->study, "File or built-in name");
  command.add_option("--out", options->out, "Folder of the dataset")->required();
  command.add_option("--pairs", options->pairs, "Instead of the study's");
  command.add_option("--profile", options->profile, "Instead of the study's");
  command.add_option("--samples", options->samples, "Samples per pixel instead of the profile's");
  command.add_option("--width", options->width_px, "Pixels");
  command.add_option("--height", options->height_px, "Pixels");
  command.add_option("--first-seed", options->first_seed, "Scene seeds start after it");
  return [options] { return Run(*options); };
}

}  // namespace parallax::preview
