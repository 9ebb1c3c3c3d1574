// A store with rendered pairs, a script as trainer, and handlers to give jobs to.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/jobs/jobs.h"

namespace parallax {

// A store that this machine does not see as a folder.
class DistantStore final : public Store {
 public:
  explicit DistantStore(std::shared_ptr<Store> store) : store_(std::move(store)) {}
  std::string Uri() const override { return "distant:"; }
  absl::Status Put(std::string_view path, std::string_view bytes) override {
    if (++puts == busy_put) return Unavailable("busy");
    return store_->Put(path, bytes);
  }
  absl::StatusOr<std::string> Get(std::string_view path) const override {
    return store_->Get(path);
  }
  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    if (++pieces == busy_piece) return Unavailable("busy");
    on_piece();
    return store_->GetPiece(path, offset, max_bytes);
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    return store_->List(prefix);
  }
  absl::Status RemoveTree(std::string_view path) override { return store_->RemoveTree(path); }
  absl::StatusOr<std::string> LocalPath(std::string_view) const override {
    return FailedPrecondition("far away");
  }
  mutable int pieces = 0, puts = 0;
  int busy_piece = 0, busy_put = 0;  // The numbers of calls that are refused; none is 0.
  std::function<void()> on_piece = [] {};

 private:
  const std::shared_ptr<Store> store_;
};

class JobTest : public FolderTest {
 protected:
  static constexpr int kScenes = 4, kRigs = 2;

  void SetUp() override {
    MakeSyntheticArchive(dir_ + "/archive", {.variants = {"a", "b"},
                                             .scenes = kScenes,
                                             .rigs = kRigs,
                                             .last_frame_dark = true,
                                             .keep_hdr = true});
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    for (const char* variant : {"a", "b"}) {
      for (int scene = 0; scene < kScenes; ++scene) {
        const std::string to = dir_ + "/store/" + FolderOf(variant, scene);
        std::filesystem::create_directories(to);
        std::filesystem::copy(
            dir_ + "/archive/" + variant + "/frames/00000" + std::to_string(scene), to,
            std::filesystem::copy_options::recursive);
      }
    }
    WriteTrainer("script", "");
    options_->frame_cache.dir = dir_ + "/cache";
  }

  static std::string FolderOf(const std::string& variant, int scene) {
    return variant + std::to_string(scene) + "/.attempt-1";
  }

  // A trainer that does what `environment` says, allowed from now on.
  void WriteTrainer(const std::string& name, const std::string& environment, bool resumes = true) {
    std::filesystem::create_directories(dir_ + "/trainers");
    std::ofstream(dir_ + "/trainers/" + name + ".yaml")
        << "trainer: " << name << "\nlayout: archive\ntrain: [" PYTHON ", -B, " SCRIPT_TRAINER
        << ", train, '--data={data}={weight}', --out, '{out}', --seed, '{seed}', --steps, "
           "'{steps}',"
           " --every, '{checkpoint_every}']\n"
        << (resumes ? "resume: [--resume, '{resume}']\n" : "")
        << "start: [--start, '{start}']\nlooks: [--looks, '{looks}']\n"
           "size: [--crop, '{width}x{height}']\n"
           "environment: ["
        << environment
        << "]\nsteps: 6\nsteps_per_minute: 8\nprogress: json\nexits: {usage: 2}\n"
           "leaves: {checkpoints: net-*.json, final: last.json}\n"
           "predict: [" PYTHON ", -B, " SCRIPT_TRAINER
           ", predict, --checkpoint, '{checkpoint}', --list, '{list}']\n";
    allowed_.push_back(name);
    auto trainers = InstalledTrainers::Load(allowed_, dir_ + "/trainers");
    ASSERT_TRUE(trainers.ok()) << trainers.status();
    options_->trainers = *std::move(trainers);
  }

  static v1::FrameSet FramesOf(const std::string& variant) {
    v1::FrameSet set;
    set.set_variant(variant);
    set.set_weight(1);
    set.mutable_filters()->set_min_mean_intensity(10);
    set.mutable_filters()->set_max_ambiguous_share(1);
    for (int scene = 0; scene < kScenes; ++scene) {
      v1::FrameFolder& folder = *set.add_folders();
      folder.set_folder(FolderOf(variant, scene));
      folder.set_scene(static_cast<uint32_t>(scene));
      for (uint32_t rig = 0; rig < kRigs; ++rig) folder.add_rigs(rig);
    }
    return set;
  }

  v1::TrainJob TrainJobOf(const std::string& trainer = "script") const {
    v1::TrainJob job;
    job.set_name("a");
    job.set_trainer(trainer);
    job.set_seed(3);
    job.set_threads(1);
    *job.add_parts() = FramesOf("a");
    job.set_share(1);
    job.set_resume_folder("work");
    job.set_checkpoints(1);
    return job;
  }

  // The folder that the agent gives to attempt `fence` of a job.
  AttemptFolder FolderOfAttempt(int fence, std::shared_ptr<Store> store = nullptr) const {
    AttemptFolder folder;
    folder.path = "work/.attempt-" + std::to_string(fence);
    folder.store = store == nullptr ? store_ : store;
    folder.dir = store == nullptr ? dir_ + "/store/" + folder.path
                                  : dir_ + "/staging/" + std::to_string(fence);
    if (store != nullptr) folder.send_to = store;
    folder.scratch = dir_ + "/scratch/" + std::to_string(fence);
    return folder;
  }

  template <typename Job>
  absl::StatusOr<JobOutcome> Do(JobHandler& handler, const Job& job, const AttemptFolder& folder,
                                const CancelToken& cancel = {}) {
    const auto outcome =
        handler.Run(job.SerializeAsString(), folder, cancel,
                    [&](double, std::string_view stage, const JobFigures& figures) {
                      stages_[std::string(stage)]++;
                      if (!figures.empty()) figures_ = figures;
                      on_progress_(figures);
                    });
    std::filesystem::remove_all(folder.scratch);  // As the agent does.
    return outcome;
  }
  absl::StatusOr<JobOutcome> Train(const v1::TrainJob& job, int fence,
                                   const CancelToken& cancel = {}) {
    const AttemptFolder folder = FolderOfAttempt(fence);
    auto outcome = Do(*MakeTrainHandler(options_), job, folder, cancel);
    had_checkpoints_ = std::filesystem::exists(folder.dir + "/resume");
    // As the coordinator does when it has the result.
    if (outcome.ok()) std::filesystem::remove_all(folder.dir + "/resume");
    return outcome;
  }

  std::string TextOf(const std::string& path) const {
    return ReadFile(dir_ + "/store/" + path).value_or("");
  }

  std::shared_ptr<Store> store_;
  std::vector<std::string> allowed_;
  std::shared_ptr<JobOptions> options_ = std::make_shared<JobOptions>();
  std::map<std::string, int> stages_;  // Tellings by stage.
  JobFigures figures_;                 // The newest.
  bool had_checkpoints_ = false;       // The last attempt, when it ended.
  std::function<void(const JobFigures&)> on_progress_ = [](const JobFigures&) {};
};

}  // namespace parallax
