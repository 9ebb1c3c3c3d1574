#include "worker/dataset/frame/render_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/status.h"
#include "common/config/config.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_scene.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Counts what is built and rendered; may cancel or fail at a rig.
struct Log {
  int built = 0;
  std::vector<uint32_t> rendered;
  int fail_at = -1;
  int cancel_at = -1;
  CancelToken cancel;
};

class FakeRenderer final : public Renderer {
 public:
  FakeRenderer(const v1::Scene& scene, Log* log) : scene_(scene), log_(log) {}
  absl::StatusOr<StereoFrame> RenderRig(const v1::Rig& rig, const CancelToken& cancel,
                                        const ProgressFn& progress) override {
    if (static_cast<int>(rig.index()) == log_->fail_at) return Internal("broken");
    if (static_cast<int>(rig.index()) == log_->cancel_at) log_->cancel.Cancel();
    if (cancel.cancelled()) return Cancelled("by the test");
    progress(0.5);
    log_->rendered.push_back(rig.index());
    return RenderSyntheticFrame(scene_, rig);
  }

 private:
  const v1::Scene scene_;
  Log* log_;
};

class RenderFramesTest : public FolderTest {
 protected:
  void SetUp() override {
    *job_.mutable_scene() = MakeSyntheticScene(4, 64, 36);
    *job_.mutable_render() = DefaultSceneConfig().render();
    for (uint32_t rig : {2, 0, 3}) job_.add_rigs(rig);
  }

  absl::StatusOr<v1::RenderResult> Run() {
    const RenderJobContext context{.attempt_dir = dir_ + "/key/.attempt-7",
                                   .attempt_path = "key/.attempt-7",
                                   .cancel = log_.cancel,
                                   .progress = [this](double f) { progress_.push_back(f); }};
    const RendererFactory factory =
        [this](const v1::Scene& scene,
               const v1::RenderConfig&) -> absl::StatusOr<std::unique_ptr<Renderer>> {
      ++log_.built;
      return std::make_unique<FakeRenderer>(scene, &log_);
    };
    return RenderFrames(job_, context, factory, cache_);
  }

  v1::RenderJob job_;
  Log log_;
  RendererCache cache_;
  std::vector<double> progress_;
};

TEST_F(RenderFramesTest, WritesTheRigsOfTheJobAndNoOthers) {
  const auto result = Run();
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->frames_size(), 3);
  EXPECT_EQ(result->frames(0).rig(), 2u);
  EXPECT_EQ(result->frames(0).path(), "key/.attempt-7/002");
  EXPECT_EQ(result->frames(2).rig(), 3u);
  EXPECT_TRUE(fs::exists(dir_ + "/key/.attempt-7/003/frame.json"));
  EXPECT_FALSE(fs::exists(dir_ + "/key/.attempt-7/001"));
  EXPECT_GT(result->build_s(), 0);
  EXPECT_TRUE(std::is_sorted(progress_.begin(), progress_.end()));
  EXPECT_EQ(progress_.back(), 1);
}

TEST_F(RenderFramesTest, TheNextJobOfTheSceneReusesItsRenderer) {
  ASSERT_TRUE(Run().ok());
  job_.clear_rigs();
  job_.add_rigs(1);
  job_.mutable_render()->clear_maps();  // Written maps don't affect the renderer.
  const auto result = Run();
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(log_.built, 1);
  EXPECT_EQ(result->build_s(), 0);
  job_.mutable_render()->set_samples_per_pixel(9);
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(log_.built, 2);
  job_.mutable_scene()->set_scene_seed(1);
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(log_.built, 3);
}

TEST_F(RenderFramesTest, ARendererInUseIsNotShared) {
  cache_.Keep("a", std::make_unique<FakeRenderer>(job_.scene(), &log_));
  EXPECT_EQ(cache_.Take("b"), nullptr);  // And what was kept is dropped.
  EXPECT_EQ(cache_.Take("a"), nullptr);
  cache_.Keep("a", std::make_unique<FakeRenderer>(job_.scene(), &log_));
  EXPECT_NE(cache_.Take("a"), nullptr);
  EXPECT_EQ(cache_.Take("a"), nullptr);
}

TEST_F(RenderFramesTest, CancelStopsAndKeepsTheRenderer) {
  log_.cancel_at = 0;
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(log_.rendered, (std::vector<uint32_t>{2}));
  log_.cancel_at = -1;
  log_.cancel = CancelToken();
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(log_.built, 1);
}

TEST_F(RenderFramesTest, AFailureNamesTheRigAndDropsTheRenderer) {
  log_.fail_at = 3;
  EXPECT_EQ(std::string(Run().status().message()), "rig 3: broken");
  log_.fail_at = -1;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(log_.built, 2);
}

TEST_F(RenderFramesTest, BrokenJobsAreInvalidArguments) {
  job_.add_rigs(9);
  EXPECT_EQ(std::string(Run().status().message()), "rig 9 is not among the scene's 4 rigs");
  job_.clear_rigs();
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(log_.built, 0);
}

}  // namespace
}  // namespace parallax
