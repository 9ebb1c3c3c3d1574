// The real way: a solved scene, the real renderer, frames on disk.
#include "worker/dataset/frame/render_job.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_statistics.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

v1::RenderJob SmallJob() {
  v1::SolveJob solve;
  *solve.mutable_config() = *ParseSceneConfig(
      "floating: {count: 4}\nrigs: {count: 2, width_px: 160, height_px: 96}\n"
      "lighting: {point_lights: 3, ceiling_removed_p: 0}\nrender: {profile: preview}\n",
      "test");
  v1::RenderJob job;
  for (uint64_t seed = 1; seed < 20 && !job.has_scene(); ++seed) {
    solve.set_scene_seed(seed);
    const auto result = Solve(solve, CancelToken());
    EXPECT_TRUE(result.ok()) << result.status();
    if (result->has_scene()) *job.mutable_scene() = result->scene();
  }
  *job.mutable_render() = solve.config().render();
  job.add_rigs(0);
  job.add_rigs(1);
  return job;
}

TEST(RenderJob, ARealSceneBecomesFramesWhoseTruthIsTheSameEachTime) {
  const std::string dir = ::testing::TempDir() + "render_job_test";
  fs::remove_all(dir);
  const v1::RenderJob job = SmallJob();
  const auto first = RunRenderJob(job, {.attempt_dir = dir + "/a", .attempt_path = "a"});
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_GT(first->build_s(), 0);
  const auto second = RunRenderJob(job, {.attempt_dir = dir + "/b", .attempt_path = "b"});
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->build_s(), 0) << "the renderer of the scene is kept";
  ASSERT_EQ(first->frames_size(), 2);

  for (int i = 0; i < 2; ++i) {
    const v1::FrameResult& frame = first->frames(i);
    ASSERT_EQ(frame.files_size(), 17);
    for (int f = 0; f < frame.files_size(); ++f) {
      const std::string& name = frame.files(f).name();
      if (name == "left.png" || name == "right.png" || name == "frame.json") continue;
      EXPECT_EQ(frame.files(f).sha256(), second->frames(i).files(f).sha256()) << name;
    }
    EXPECT_GT(frame.statistics().at("mean_intensity"), 5);
    EXPECT_GT(frame.statistics().at("max_disparity_px"), 0);

    const std::string folder = dir + "/a/00" + std::to_string(i);
    const nlohmann::json json = nlohmann::json::parse(std::ifstream(folder + "/frame.json"));
    const ImageF depth = *ReadExrY(folder + "/depth_left.exr");
    const ImageF disparity = *ReadExrY(folder + "/disparity_left.exr");
    const ImageU16 objects = *ReadPngU16(folder + "/objects_left.png");
    const double fx_baseline =
        json["intrinsics"]["fx"].get<double>() * json["baseline_m"].get<double>();
    for (size_t p = 0; p < depth.pixels(); ++p) {
      const float z = depth.values()[p];
      ASSERT_TRUE(std::isfinite(z) && std::isfinite(disparity.values()[p]));
      ASSERT_EQ(z > 0, objects.values()[p] != 0);
      if (z > 0) {
        ASSERT_NEAR(disparity.values()[p], fx_baseline / z, 1e-5 * fx_baseline / z);
      }
    }
  }
  fs::remove_all(dir);
}

TEST(RenderJob, ACancelledJobStops) {
  const std::string dir = ::testing::TempDir() + "render_job_cancel_test";
  fs::remove_all(dir);
  RenderJobContext context{.attempt_dir = dir, .attempt_path = "a"};
  context.progress = [token = context.cancel](double) { token.Cancel(); };
  EXPECT_EQ(RunRenderJob(SmallJob(), context).status().code(), absl::StatusCode::kCancelled);
  fs::remove_all(dir);
}

TEST(RenderJob, ABrokenRecipeIsAnErrorThatNamesTheObject) {
  v1::RenderJob job = SmallJob();
  job.mutable_scene()->mutable_objects(0)->set_part("");
  job.mutable_scene()->mutable_objects(0)->set_asset_class("NoSuchThing");
  const absl::Status status =
      RunRenderJob(job,
                   {.attempt_dir = ::testing::TempDir() + "render_job_broken", .attempt_path = "a"})
          .status();
  EXPECT_FALSE(status.ok());
  EXPECT_NE(ToStd(status.message()).find(job.scene().objects(0).name()), std::string_view::npos)
      << status;
}

}  // namespace
}  // namespace parallax
