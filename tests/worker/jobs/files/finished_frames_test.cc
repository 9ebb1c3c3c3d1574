// Pairs that an attempt has finished are taken over by the next one: whole, checked, or not at all.
#include "worker/jobs/files/finished_frames.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "common/base/hash.h"
#include "common/config/config.h"
#include "common/config/frame_files.h"
#include "tests/folder_test.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

class FinishedFramesTest : public FolderTest {
 protected:
  void SetUp() override {
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    job_.mutable_render()->add_maps("depth");
    for (uint32_t rig = 0; rig < 3; ++rig) job_.add_rigs(rig);
  }

  // The folder that the agent gives to attempt `fence`; `far` stands for a worker that does not see
  // the store.
  AttemptFolder FolderOf(int fence, bool far = false) {
    AttemptFolder folder;
    folder.path = "ab/cd/.attempt-" + std::to_string(fence);
    folder.store = store_;
    folder.dir = dir_ + (far ? "/staging/" : "/store/ab/cd/.attempt-") + std::to_string(fence);
    if (far) folder.store = folder.send_to = std::make_shared<DistantStore>(store_);
    return folder;
  }
  v1::RenderJob JobAfter(const std::vector<int>& fences) const {
    v1::RenderJob job = job_;
    for (const int fence : fences) {
      job.add_earlier_folders("ab/cd/.attempt-" + std::to_string(fence));
    }
    return job;
  }
  // Writes a frame's files as the writer of frames does.
  v1::FrameResult Write(const AttemptFolder& folder, uint32_t rig) const {
    v1::FrameResult frame;
    frame.set_rig(rig);
    frame.set_path(folder.path + "/00" + std::to_string(rig));
    (*frame.mutable_statistics())["mean_intensity"] = 40 + rig;
    const std::string dir = folder.dir + "/00" + std::to_string(rig);
    fs::create_directories(dir);
    for (const std::string& name : FrameFileNames(job_.render())) {
      const std::string content = name + " of rig " + std::to_string(rig);
      std::ofstream(dir + "/" + name) << content;
      v1::FileEntry& file = *frame.add_files();
      file.set_name(name);
      file.set_size(static_cast<int64_t>(content.size()));
      file.set_sha256(Sha256Hex(content));
    }
    return frame;
  }
  // Attempt 1 has finished rigs 0 and 1 and begun rig 2.
  void LeaveTwo(bool far = false) {
    const AttemptFolder folder = FolderOf(1, far);
    FinishedFrames finished(folder);
    finished.Note(Write(folder, 0));
    finished.Note(Write(folder, 1));
    Write(folder, 2);
    if (far) fs::remove_all(folder.dir);  // The machine is gone.
  }
  static std::vector<uint32_t> RigsOf(const absl::StatusOr<std::vector<v1::FrameResult>>& frames) {
    EXPECT_TRUE(frames.ok()) << frames.status();
    std::vector<uint32_t> rigs;
    for (const v1::FrameResult& frame : *frames) rigs.push_back(frame.rig());
    return rigs;
  }
  std::string InStore(const std::string& path) const { return dir_ + "/store/ab/cd/" + path; }

  std::shared_ptr<Store> store_;
  v1::RenderJob job_;
};

TEST_F(FinishedFramesTest, TheNextAttemptTakesOverWhatIsWholeAndItsNextFromIt) {
  LeaveTwo();
  const AttemptFolder second = FolderOf(2);
  const auto taken = FinishedFrames(second).TakeOver(JobAfter({1}), CancelToken());
  ASSERT_THAT(RigsOf(taken), ElementsAre(0, 1));
  const v1::FrameResult& frame = (*taken)[1];
  EXPECT_EQ(frame.path(), "ab/cd/.attempt-2/001");
  EXPECT_EQ(frame.statistics().at("mean_intensity"), 41);
  EXPECT_EQ(ReadFile(InStore(".attempt-2/001/left.png")).value_or(""), "left.png of rig 1");
  struct stat file {};
  ASSERT_EQ(stat(InStore(".attempt-2/001/left.png").c_str(), &file), 0);
  EXPECT_EQ(file.st_nlink, 2u) << "no second copy";
  EXPECT_FALSE(fs::exists(InStore(".attempt-2/002")));

  fs::remove_all(InStore(".attempt-1"));
  const AttemptFolder third = FolderOf(3);
  FinishedFrames finished(third);
  EXPECT_THAT(RigsOf(finished.TakeOver(JobAfter({2, 1}), CancelToken())), ElementsAre(0, 1));
  EXPECT_TRUE(fs::exists(InStore(".attempt-3/finished/000.pb")));
  EXPECT_TRUE(fs::exists(InStore(".attempt-3/000/left.png")));
}

TEST_F(FinishedFramesTest, WhatIsNotAsItsNoteSaysIsMadeAgain) {
  const struct {
    const char* what;
    std::function<void(const std::string& dir)> damage;
  } kCases[] = {
      {"another byte", [](const auto& dir) { std::ofstream(dir + "/001/left.png") << "?"; }},
      {"a file is gone", [](const auto& dir) { fs::remove(dir + "/001/right.png"); }},
      {"cut off", [](const auto& dir) { fs::resize_file(dir + "/001/frame.json", 3); }},
      {"no note", [](const auto& dir) { fs::remove(dir + "/finished/001.pb"); }},
      {"half a note", [](const auto& dir) { fs::resize_file(dir + "/finished/001.pb", 20); }},
      {"another rig's note",
       [](const auto& dir) {
         fs::copy_file(dir + "/finished/000.pb", dir + "/finished/001.pb",
                       fs::copy_options::overwrite_existing);
       }},
  };
  for (const auto& one : kCases) {
    for (const int fence : {1, 2}) fs::remove_all(InStore(".attempt-" + std::to_string(fence)));
    LeaveTwo();
    one.damage(InStore(".attempt-1"));
    const AttemptFolder second = FolderOf(2);
    FinishedFrames finished(second);
    EXPECT_THAT(RigsOf(finished.TakeOver(JobAfter({1}), CancelToken())), ElementsAre(0))
        << one.what;
    finished.RemoveUnfinished();
    EXPECT_FALSE(fs::exists(InStore(".attempt-2/001"))) << one.what;
    EXPECT_TRUE(fs::exists(InStore(".attempt-2/000"))) << one.what;
  }
}

TEST_F(FinishedFramesTest, OfOtherMapsAreNotTakenOver) {
  LeaveTwo();
  v1::RenderJob job = JobAfter({1});
  job.mutable_render()->add_maps("disparity");
  const AttemptFolder second = FolderOf(2);
  EXPECT_THAT(RigsOf(FinishedFrames(second).TakeOver(job, CancelToken())), IsEmpty());
}

TEST_F(FinishedFramesTest, AWorkerThatDoesNotSeeTheStoreSendsEachAndBringsThemBack) {
  LeaveTwo(/*far=*/true);
  EXPECT_TRUE(fs::exists(InStore(".attempt-1/001/left.png")));
  EXPECT_FALSE(fs::exists(InStore(".attempt-1/002"))) << "it was not finished";
  const AttemptFolder second = FolderOf(2, /*far=*/true);
  FinishedFrames finished(second);
  EXPECT_THAT(RigsOf(finished.TakeOver(JobAfter({1}), CancelToken())), ElementsAre(0, 1));
  EXPECT_EQ(ReadFile(second.dir + "/000/left.png").value_or(""), "left.png of rig 0");
  EXPECT_TRUE(finished.IsSent(1));
  EXPECT_FALSE(finished.IsSent(2));
  EXPECT_EQ(ReadFile(InStore(".attempt-2/001/right.png")).value_or(""), "right.png of rig 1");
}

TEST_F(FinishedFramesTest, ACancelledAttemptTakesNothingMore) {
  LeaveTwo();
  CancelToken cancel;
  cancel.Cancel();
  const AttemptFolder second = FolderOf(2);
  EXPECT_TRUE(absl::IsCancelled(FinishedFrames(second).TakeOver(JobAfter({1}), cancel).status()));
}

// ---- With the real renderer
class RenderHandlerTest : public FinishedFramesTest {
 protected:
  static constexpr int kRigs = 4;

  void SetUp() override {
    FinishedFramesTest::SetUp();
    v1::SolveJob solve;
    *solve.mutable_config() = *ParseSceneConfig(
        "floating: {count: 1}\nfurniture: {enabled: false}\n"
        "rigs: {count: 4, width_px: 64, height_px: 36}\n"
        "render: {profile: preview, denoise: \"off\"}\n",
        "test");
    job_.Clear();
    for (uint64_t seed = 1; seed < 20 && !job_.has_scene(); ++seed) {
      solve.set_scene_seed(seed);
      const auto result = Solve(solve, CancelToken());
      ASSERT_TRUE(result.ok()) << result.status();
      if (result->has_scene()) *job_.mutable_scene() = result->scene();
    }
    *job_.mutable_render() = solve.config().render();
    for (uint32_t rig = 0; rig < kRigs; ++rig) job_.add_rigs(rig);
  }
  absl::StatusOr<JobOutcome> Run(const v1::RenderJob& job, const AttemptFolder& folder,
                                 const std::function<void(double)>& progress,
                                 const CancelToken& cancel = {}) {
    return MakeRenderHandler(std::make_shared<JobOptions>())
        ->Run(job.SerializeAsString(), folder, cancel,
              [&](double fraction, std::string_view, const JobFigures&) { progress(fraction); });
  }
  // Returns hashes by rig and file, without files that state times.
  static std::map<std::string, std::string> HashesOf(const JobOutcome& outcome) {
    std::map<std::string, std::string> hashes;
    for (const OutputFile& file : outcome.files) {
      if (file.name.find("frame.json") == std::string::npos) hashes[file.name] = file.sha256;
    }
    return hashes;
  }
};

TEST_F(RenderHandlerTest, OnlyThePairAtHandIsLostAndTheFilesAreThoseOfACalmRun) {
  for (const bool far : {false, true}) {
    const auto calm = Run(job_, FolderOf(9), [](double) {});
    ASSERT_TRUE(calm.ok()) << calm.status();
    CancelToken cancel;
    const auto first = Run(
        job_, FolderOf(1, far),
        [&](double fraction) {
          if (fraction > 0.6) cancel.Cancel();
        },
        cancel);
    EXPECT_TRUE(absl::IsCancelled(first.status())) << first.status();
    // Rigs 0 and 1 were done at half of the job.
    double begin = 1;
    const auto second = Run(JobAfter({1}), FolderOf(2, far),
                            [&](double fraction) { begin = std::min(begin, fraction); });
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_GE(begin, 2.0 / kRigs);
    EXPECT_LT(begin, 1);
    EXPECT_EQ(HashesOf(*second), HashesOf(*calm));
    v1::RenderResult result;
    ASSERT_TRUE(result.ParseFromString(second->result));
    ASSERT_EQ(result.frames_size(), kRigs);
    for (int rig = 0; rig < kRigs; ++rig) {
      EXPECT_EQ(result.frames(rig).rig(), static_cast<uint32_t>(rig));
      EXPECT_EQ(result.frames(rig).path(), "ab/cd/.attempt-2/00" + std::to_string(rig));
      EXPECT_GT(result.frames(rig).stage_s().at("cpu"), 0);
    }
    for (const int fence : {1, 2, 9}) fs::remove_all(InStore(".attempt-" + std::to_string(fence)));
    fs::remove_all(dir_ + "/staging");
  }
}

// The worker dies between the end of its job and the coordinator's answer: its report is lost.
TEST_F(RenderHandlerTest, AJobWhoseReportIsLostWithItsWorkerIsNotRenderedAgain) {
  for (const bool far : {false, true}) {
    const AttemptFolder first = FolderOf(1, far);
    const auto whole = Run(job_, first, [](double) {});
    ASSERT_TRUE(whole.ok()) << whole.status();
    if (far) fs::remove_all(first.dir);  // Its staging folder goes with it.
    double begin = 1;
    const auto second =
        Run(JobAfter({1}), FolderOf(2, far), [&](double fraction) { begin = fraction; });
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_EQ(begin, 1) << "no progress to tell";
    EXPECT_EQ(HashesOf(*second), HashesOf(*whole));
    for (const int fence : {1, 2}) fs::remove_all(InStore(".attempt-" + std::to_string(fence)));
    fs::remove_all(dir_ + "/staging");
  }
}

}  // namespace
}  // namespace parallax
