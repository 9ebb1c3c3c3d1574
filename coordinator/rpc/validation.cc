#include "coordinator/rpc/validation.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

constexpr size_t kMaxName = 100;
constexpr size_t kMaxText = 4000;
constexpr int kMaxTags = 64;
constexpr int kMaxSlots = 1024;
constexpr int kMaxHeld = 4096;
constexpr size_t kMaxKey = 200;
constexpr int kMaxStages = 64;

absl::Status Bad(const std::string& message) { return absl::InvalidArgumentError(message); }

bool IsName(const std::string& text) {
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) || c == '.' || c == '_' || c == '-';
  };
  return !text.empty() && text.size() <= kMaxName &&
         std::isalnum(static_cast<unsigned char>(text[0])) &&
         std::all_of(text.begin(), text.end(), allowed);
}

absl::Status CheckWorker(const std::string& name) {
  if (IsName(name)) return absl::OkStatus();
  return Bad("worker name '" + name.substr(0, kMaxName) + "': wanted at most " +
             std::to_string(kMaxName) + " letters, digits, '.', '_' or '-'");
}

absl::Status CheckText(const char* field, const std::string& text, size_t most) {
  if (text.size() <= most) return absl::OkStatus();
  return Bad(std::string(field) + " has " + std::to_string(text.size()) + " bytes, allowed are " +
             std::to_string(most));
}

template <typename Value>
absl::Status CheckRange(const char* field, Value value, Value low, Value high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return Bad(std::string(field) + " is " + std::to_string(value) + ", allowed is [" +
             std::to_string(low) + ", " + std::to_string(high) + "]");
}

struct Stage {
  const char* name;  // In Hello.stage_versions.
  std::string StageVersions::*version;
};
constexpr Stage kLayout = {"layout", &StageVersions::layout};
constexpr Stage kScene = {"scene", &StageVersions::scene};
constexpr Stage kFrame = {"frame", &StageVersions::frame};

// The stages whose results a kind of job makes.
struct StagesOfKind {
  v1::JobKind kind;
  const char* name;
  std::vector<Stage> stages;
};
const std::vector<StagesOfKind>& StagesOfKinds() {
  static const auto& kinds = *new std::vector<StagesOfKind>{
      {v1::JOB_KIND_SOLVE, "solve", {kLayout, kScene}},
      {v1::JOB_KIND_RENDER, "render", {kFrame}},
  };
  return kinds;
}

// Why a worker with these versions must not do jobs of `kind`; empty if it may. It would publish
// other bytes under keys of ours.
std::string WhyNot(const v1::Hello& hello, const StagesOfKind& kind, const StageVersions& ours) {
  for (const Stage& stage : kind.stages) {
    const auto theirs = hello.stage_versions().find(stage.name);
    const bool told = theirs != hello.stage_versions().end();
    if (told && theirs->second == ours.*stage.version) continue;
    return std::string("no ") + kind.name + " jobs: its stage " + stage.name + " has version " +
           (told ? theirs->second : hello.build_id()) + ", this coordinator's has version " +
           ours.*stage.version;
  }
  return "";
}

}  // namespace

absl::Status CheckHello(const v1::Hello& hello) {
  RETURN_IF_ERROR(CheckWorker(hello.name()));
  if (hello.kinds().empty()) return Bad("hello without kinds of jobs");
  for (int kind : hello.kinds()) {
    if (kind != v1::JOB_KIND_SOLVE && kind != v1::JOB_KIND_RENDER) {
      return Bad("hello names an unknown kind of job: " + std::to_string(kind));
    }
  }
  RETURN_IF_ERROR(CheckRange("hello.slots", hello.slots(), 1, kMaxSlots));
  RETURN_IF_ERROR(CheckRange("hello.cores", hello.cores(), 0, 1 << 20));
  RETURN_IF_ERROR(CheckRange("hello.memory_mb", hello.memory_mb(), int64_t{0}, int64_t{1} << 40));
  RETURN_IF_ERROR(CheckRange("hello.tags", hello.tags_size(), 0, kMaxTags));
  for (const std::string& tag : hello.tags()) {
    if (!IsName(tag))
      return Bad("hello has a tag that is no name: '" + tag.substr(0, kMaxName) + "'");
  }
  RETURN_IF_ERROR(CheckText("hello.version", hello.version(), kMaxName));
  RETURN_IF_ERROR(CheckText("hello.build_id", hello.build_id(), kMaxName));
  RETURN_IF_ERROR(CheckText("hello.instance", hello.instance(), kMaxName));
  RETURN_IF_ERROR(CheckRange("hello.holding", hello.holding_size(), 0, kMaxHeld));
  for (const v1::AttemptId& attempt : hello.holding()) RETURN_IF_ERROR(CheckAttempt(attempt));
  return CheckRange("hello.stage_versions", hello.stage_versions_size(), 0, kMaxStages);
}

absl::StatusOr<std::vector<std::string>> DropKindsOfOtherVersions(const StageVersions& ours,
                                                                  v1::Hello& hello) {
  std::vector<std::string> notes;
  // Simulators make no data.
  if (hello.stage_versions().empty() && hello.build_id().rfind("generator-", 0) != 0) return notes;
  const std::string worker = "worker " + hello.name() + " (" + hello.version() + "): ";
  const google::protobuf::RepeatedField<int> kinds = hello.kinds();
  hello.clear_kinds();
  for (const int kind : kinds) {
    std::string why;
    for (const StagesOfKind& stages : StagesOfKinds()) {
      if (stages.kind == kind) why = WhyNot(hello, stages, ours);
    }
    if (why.empty()) {
      hello.add_kinds(static_cast<v1::JobKind>(kind));
    } else {
      notes.push_back(worker + why);
    }
  }
  if (hello.kinds().empty()) {
    return absl::FailedPreconditionError(notes.front() + "; give both the same release");
  }
  // What it holds may be of a kind that it must not finish.
  if (!notes.empty()) hello.clear_holding();
  return notes;
}

absl::Status CheckCredit(const v1::Credit& credit) {
  RETURN_IF_ERROR(CheckRange("credit.jobs", credit.jobs(), 1, kMaxCredit));
  return CheckRange("credit.ahead", credit.ahead(), 0, credit.jobs());
}

absl::Status CheckHeartbeat(const v1::Heartbeat& heartbeat) {
  RETURN_IF_ERROR(CheckRange("heartbeat.running", heartbeat.running_size(), 0, kMaxHeld));
  for (const v1::Progress& progress : heartbeat.running()) {
    RETURN_IF_ERROR(CheckAttempt(progress.attempt()));
    if (!(progress.fraction() >= 0 && progress.fraction() <= 1)) {
      return Bad("heartbeat: progress " + std::to_string(progress.fraction()) +
                 " is not in [0, 1]");
    }
    RETURN_IF_ERROR(CheckText("heartbeat.stage", progress.stage(), kMaxName));
  }
  return absl::OkStatus();
}

absl::Status CheckAttempt(const v1::AttemptId& attempt) {
  if (attempt.job_id() > 0 && attempt.fence() > 0) return absl::OkStatus();
  return Bad("attempt without job or fence (job " + std::to_string(attempt.job_id()) + ", fence " +
             std::to_string(attempt.fence()) + ")");
}

absl::Status CheckComplete(const v1::CompleteRequest& request) {
  RETURN_IF_ERROR(CheckAttempt(request.attempt()));
  RETURN_IF_ERROR(CheckWorker(request.worker()));
  if (!request.has_solve() && !request.has_render()) return Bad("complete without a result");
  for (double seconds : {request.wall_s(), request.cpu_s()}) {
    if (!std::isfinite(seconds) || seconds < 0) return Bad("complete with a negative time");
  }
  return absl::OkStatus();
}

absl::Status CheckFail(const v1::FailRequest& request) {
  RETURN_IF_ERROR(CheckAttempt(request.attempt()));
  RETURN_IF_ERROR(CheckWorker(request.worker()));
  RETURN_IF_ERROR(CheckText("fail.error", request.error(), kMaxText));
  return CheckText("fail.fingerprint", request.fingerprint(), kMaxText);
}

absl::Status CheckSubmit(const v1::SubmitRequest& request) {
  if (!request.has_study()) return Bad("submit without a study");
  return CheckText("submit.idempotency_key", request.idempotency_key(), kMaxKey);
}

absl::Status CheckStudyId(int64_t study_id) {
  if (study_id > 0) return absl::OkStatus();
  return Bad("study id " + std::to_string(study_id) + ": ids start at 1");
}

absl::Status CheckLimit(int32_t limit, int32_t most) { return CheckRange("limit", limit, 0, most); }

}  // namespace parallax
