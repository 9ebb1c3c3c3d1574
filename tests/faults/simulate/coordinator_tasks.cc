// Tasks of the simulated coordinator that come again and again.
#include <algorithm>
#include <set>

#include "coordinator/rpc/janitor.h"
#include "coordinator/rpc/storage/scrubber.h"
#include "coordinator/rpc/workers/output_check.h"
#include "tests/faults/simulate/coordinator.h"

namespace parallax::faults {
namespace {

constexpr int kMostOutputs = 10'000;

}  // namespace

void SimCoordinator::Often(int life, double every_s, std::function<absl::Status()> task) {
  world_.schedule.After(every_s, [this, life, every_s, task = std::move(task)]() mutable {
    if (!Lives(life)) return;
    Enter([this, &task] {
      pool().Run([this, task] {
        const absl::Status status = task();
        if (status.ok() || VfsHasEnded()) return;
        model_.Expect(status, "a task of the coordinator");
        // A damaged page says so at each read, and the task that needs it is never done.
        if (absl::IsDataLoss(status) && liar_.has_lied()) refused_ = true;
      });
    });
    Often(life, every_s, std::move(task));
  });
}

// ---- Notices: as in coordinator/rpc/notifier.cc
absl::Status SimCoordinator::DeliverNotices() {
  queue().KeepSample({.unix_s = clock_.UnixSeconds(), .ready = lives_});
  ASSIGN_OR_RETURN(const std::vector<Notice> notices, queue().ListNotices(10));
  for (const Notice& notice : notices) {
    if (world_.has_faults && dice_.Bernoulli(0.3)) {
      RETURN_IF_ERROR(queue().DelayNotice(notice, world_.knobs.queue.lease_s));
      continue;
    }
    world_.story.Tell("operator: study {} is {}", notice.study, notice.event);
    if (notice.event == kNoticeDone) told_.insert(notice.study);
    RETURN_IF_ERROR(queue().EndNotice(notice));
  }
  return absl::OkStatus();
}

std::string SimCoordinator::UntoldStudy() {
  const auto studies = queue().ListStudies(kMostOutputs);
  if (world_.knobs.queue.notice_targets.empty() || !studies.ok()) return "";
  for (const v1::StudyStatus& study : *studies) {
    const bool ends =
        study.state() == v1::STUDY_STATE_SUCCEEDED || study.state() == v1::STUDY_STATE_FAILED;
    if (ends && told_.count(study.study_id()) == 0) return study.name();
  }
  return "";
}

// ---- A crash loop
void SimCoordinator::BeginCrashLoop(const std::string& worker,
                                    const std::vector<v1::AttemptId>& attempts) {
  loop_ = {.until_s = world_.schedule.now() + 4 * world_.knobs.queue.lease_s,
           .worker = worker,
           .attempts = attempts};
  Die(/*power_cut=*/false);
}

// Two leases after the first start, the jobs of a dead worker are not its own any more.
void SimCoordinator::CheckCrashLoop() {
  if (!is_up()) {
    return world_.schedule.After(world_.knobs.turn_s, [this] { CheckCrashLoop(); });
  }
  for (const v1::AttemptId& attempt : loop_.attempts) {
    if (!queue().IsHeldBy(loop_.worker, attempt)) continue;
    model_.Complain(fmt::format("job {} is still leased to {}, which died two leases ago",
                                attempt.job_id(), loop_.worker));
  }
}

// ---- The store
void SimCoordinator::LookIntoStoreLater(int life) {
  world_.schedule.After(world_.Next(4 * world_.knobs.queue.lease_s), [this, life] {
    if (!Lives(life)) return;
    const bool repair = !world_.has_faults || dice_.Bernoulli(0.7);
    Enter([this, repair] { pool().Run([this, repair] { ReadStore(repair); }); });
    LookIntoStoreLater(life);
  });
}

void SimCoordinator::ReadStore(bool repair) {
  const auto last = queue().GetScrub();
  const auto outputs = queue().ListStoredOutputs("", kMostOutputs);
  if (!last.ok() || !outputs.ok()) {
    return model_.Expect(last.ok() ? outputs.status() : last.status(), "results");
  }
  const bool is_whole = !*last || (*last)->ended_unix_s;  // It does not go on with an older pass.
  std::set<std::string> damaged, found;
  for (const StoredOutput& output : *outputs) {
    for (const JobKind::OutputFile& file : output.files) {
      if (!disk_.Has(file)) damaged.insert(output.folder);
    }
  }
  const bool sizes_only = world_.mutation.sizes_only;
  Scrubber scrubber(queue(), *life_->store, {.repair = repair && !sizes_only, .clock = &clock_});
  const auto pass = scrubber.Pass([&](const DamagedResult& one) {
    if (!sizes_only || !one.why.ends_with("(SHA-256)")) found.insert(one.folder);
  });
  if (VfsHasEnded()) return;
  if (!pass.ok()) return model_.Expect(pass.status(), "a look into the store");
  world_.story.Tell("coordinator: has read the store, {} results are damaged", found.size());
  for (const std::string& folder : damaged) {
    if (is_whole && found.count(folder) == 0) {
      model_.Complain(folder + " is damaged, and a check of the store does not find it");
    }
  }
  for (const std::string& folder : found) {
    // What an older database names may have been removed since.
    if (!disk_.HasLiedAbout(folder) && world_.knobs.lie != Lie::kOlder) {
      model_.Complain(folder + " is called damaged, and nobody has touched it");
    }
  }
  const Janitor janitor(queue(), *life_->store, nullptr,
                        {.lease_s = world_.knobs.queue.lease_s, .every_s = 0, .clock = &clock_});
  const auto swept = janitor.Sweep();
  if (!swept.ok() && !VfsHasEnded()) model_.Expect(swept.status(), "removal of litter");
}

std::string SimCoordinator::WrongFile() {
  if (!world_.knobs.has_files) return "";
  const auto studies = queue().ListStudies(kMostOutputs);
  if (!studies.ok()) return "";
  for (const v1::StudyStatus& study : *studies) {
    v1::ListFramesRequest request;
    request.set_study_id(study.study_id());
    request.set_limit(kMostOutputs);
    const auto frames = queue().ListFrames(request);
    if (!frames.ok()) continue;
    for (const v1::PublishedFrame& frame : *frames) {
      for (const v1::FileEntry& file : frame.frame().files()) {
        const std::string path = frame.frame().path() + "/" + file.name();
        if (!disk_.Has({path, file.size(), file.sha256()})) return path;
      }
    }
  }
  return "";
}

absl::StatusOr<std::string> SimCoordinator::WhyWrong(const v1::CompleteRequest& request) {
  const auto kind = queue().kinds().Find(request.kind());
  if (!world_.knobs.has_files || !kind) return std::string();
  const std::vector<JobKind::OutputFile> files = queue().kinds()[*kind].FilesOf(request.result());
  ASSIGN_OR_RETURN(std::string why, WhyNotInStore(*life_->store, files));
  if (!why.empty()) return why;
  return WhyNotAsHashed(*life_->store, files, request.attempt().fence());
}

}  // namespace parallax::faults
