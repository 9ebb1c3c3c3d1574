#include "coordinator/rpc/validation.h"

#include <algorithm>
#include <cmath>

#include "common/base/names.h"
#include "common/config/check/limit_rules.h"
#include "common/config/check/limits.h"
#include "common/config/config.h"

namespace parallax {
namespace {

constexpr int kMaxHeld = 4096;
constexpr size_t kMaxKey = 200;
constexpr int kMaxStages = 64;
constexpr int kMaxFigures = 8;  // A job's progress has no more.
constexpr size_t kMaxPath = 1024;

// A word of another program, such as a version: plain and short.
absl::Status CheckWord(const char* field, const std::string& text) {
  return CheckPlainText(field, text, kMaxNameBytes);
}

// A name, or two with a colon between them; see common/base/ability_tags.h.
absl::Status CheckTag(std::string_view tag) {
  const size_t colon = tag.find(':');
  if (colon == std::string_view::npos) return CheckName("hello.tags: tag", tag);
  RETURN_IF_ERROR(CheckName("hello.tags: tag before its colon", tag.substr(0, colon)));
  return CheckName("hello.tags: tag behind its colon", tag.substr(colon + 1));
}

constexpr int kMaxRanks = 65'536;
constexpr int kMaxPairsAtOnce = 1024;
constexpr double kMaxWait_s = 60;

template <typename Value>
absl::Status CheckRange(const char* field, Value value, Value low, Value high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return InvalidArgument("{} is {}, allowed is [{}, {}]", field, value, low, high);
}

// Why a worker with these versions must not do jobs of `kind`; empty if it may. It would publish
// other bytes under keys of ours.
std::string WhyNot(const v1::Hello& hello, const JobKind& kind, const StageVersions& ours) {
  for (const std::string& stage : kind.traits().stages) {
    const auto theirs = hello.stage_versions().find(stage);
    const bool told = theirs != hello.stage_versions().end();
    const std::string own = VersionOf(ours, stage);
    if (told && theirs->second == own) continue;
    return "no " + kind.name() + " jobs: its stage " + stage + " has version " +
           (told ? theirs->second : hello.build_id()) + ", this coordinator's has version " + own;
  }
  return "";
}

}  // namespace

absl::Status CheckHello(const v1::Hello& hello, const KindRegistry& kinds) {
  RETURN_IF_ERROR(CheckName("worker name", hello.name()));
  if (hello.protocol() != kWorkProtocol) {
    return FailedPrecondition(
        "worker {} speaks work protocol {}, this coordinator speaks {}: give both the same release",
        hello.name(), hello.protocol(), kWorkProtocol);
  }
  if (hello.kinds().empty()) return InvalidArgument("hello without kinds of jobs");
  RETURN_IF_ERROR(CheckRange("hello.kinds", hello.kinds_size(), 1, static_cast<int>(kinds.size())));
  for (const std::string& kind : hello.kinds()) {
    if (const auto known = kinds.IdOf(kind); !known.ok()) {
      return InvalidArgument("hello: {}", known.status().message());
    }
  }
  RETURN_IF_ERROR(CheckRange("hello.slots", hello.slots(), 1, kMaxSlots));
  RETURN_IF_ERROR(CheckRange("hello.cores", int64_t{hello.cores()}, int64_t{0}, kMaxCores));
  RETURN_IF_ERROR(CheckRange("hello.memory_mb", hello.memory_mb(), int64_t{0}, kMaxMemoryMb));
  RETURN_IF_ERROR(CheckRange("hello.tags", hello.tags_size(), 0, kMaxTags));
  for (const std::string& tag : hello.tags()) RETURN_IF_ERROR(CheckTag(tag));
  RETURN_IF_ERROR(CheckWord("hello.version", hello.version()));
  RETURN_IF_ERROR(CheckWord("hello.build_id", hello.build_id()));
  RETURN_IF_ERROR(CheckWord("hello.instance", hello.instance()));
  RETURN_IF_ERROR(CheckWord("hello.machine", hello.machine()));
  RETURN_IF_ERROR(CheckRange("hello.holding", hello.holding_size(), 0, kMaxHeld));
  for (const v1::AttemptId& attempt : hello.holding()) RETURN_IF_ERROR(CheckAttempt(attempt));
  for (const auto& [stage, version] : hello.stage_versions()) {
    RETURN_IF_ERROR(CheckWord("hello.stage_versions: stage", stage));
    RETURN_IF_ERROR(CheckWord("hello.stage_versions: version", version));
  }
  return CheckRange("hello.stage_versions", hello.stage_versions_size(), 0, kMaxStages);
}

absl::StatusOr<std::vector<std::string>> DropKindsOfOtherVersions(const StageVersions& ours,
                                                                  const KindRegistry& registry,
                                                                  v1::Hello& hello) {
  std::vector<std::string> notes;
  // Simulators make no data.
  if (hello.stage_versions().empty() && hello.build_id().rfind("generator-", 0) != 0) return notes;
  const std::string worker = "worker " + hello.name() + " (" + hello.version() + "): ";
  const std::vector<std::string> kinds(hello.kinds().begin(), hello.kinds().end());
  hello.clear_kinds();
  for (const std::string& kind : kinds) {
    ASSIGN_OR_RETURN(const KindId id, registry.IdOf(kind));
    const std::string why = WhyNot(hello, registry[id], ours);
    if (why.empty()) {
      hello.add_kinds(kind);
    } else {
      notes.push_back(worker + why);
    }
  }
  if (hello.kinds().empty()) {
    return FailedPrecondition("{}; give both the same release", notes.front());
  }
  // Its attempts may be of a kind that it must not finish.
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
      return InvalidArgument("heartbeat: progress {:f} is not in [0, 1]", progress.fraction());
    }
    RETURN_IF_ERROR(CheckWord("heartbeat.stage", progress.stage()));
    RETURN_IF_ERROR(CheckRange("heartbeat.figures", progress.figures_size(), 0, kMaxFigures));
    for (const auto& [figure, value] : progress.figures()) {
      RETURN_IF_ERROR(CheckName("heartbeat: figure", figure));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckAttempt(const v1::AttemptId& attempt) {
  if (attempt.job_id() > 0 && attempt.fence() > 0) return absl::OkStatus();
  return InvalidArgument("attempt without job or fence (job {}, fence {})", attempt.job_id(),
                         attempt.fence());
}

absl::Status CheckComplete(const v1::CompleteRequest& request) {
  RETURN_IF_ERROR(CheckAttempt(request.attempt()));
  RETURN_IF_ERROR(CheckName("worker name", request.worker()));
  RETURN_IF_ERROR(CheckWord("complete.coordinator_id", request.coordinator_id()));
  if (request.kind().empty()) return InvalidArgument("complete without a result");
  for (double seconds : {request.wall_s(), request.cpu_s()}) {
    if (!std::isfinite(seconds) || seconds < 0) {
      return InvalidArgument("complete with a negative time");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckFail(const v1::FailRequest& request) {
  RETURN_IF_ERROR(CheckAttempt(request.attempt()));
  RETURN_IF_ERROR(CheckWord("fail.coordinator_id", request.coordinator_id()));
  return CheckName("worker name", request.worker());
}

std::string CleanText(std::string_view text) {
  return CutText(Printable(text.substr(0, kMaxErrorBytes)), kMaxErrorBytes);
}

v1::FailRequest CleanFail(const v1::FailRequest& request) {
  v1::FailRequest clean = request;
  clean.set_error(CleanText(request.error()));
  clean.set_fingerprint(CleanText(request.fingerprint()));
  return clean;
}

absl::Status CheckSubmit(const v1::SubmitRequest& request) {
  if (!request.has_study()) return InvalidArgument("submit without a study");
  RETURN_IF_ERROR(CheckPlainText("submit.idempotency_key", request.idempotency_key(), kMaxKey));
  RETURN_IF_ERROR(CheckRange("submit.max_running", request.max_running(), 0, kMostRunning));
  return ValidateStudy(request.study());
}

absl::Status CheckStudyChange(const v1::StudyRequest& request) {
  RETURN_IF_ERROR(CheckStudyId(request.study_id()));
  return CheckPlainText("reason", request.reason(), kMaxReasonBytes);
}

absl::Status CheckSetMaxRunning(const v1::SetMaxRunningRequest& request) {
  RETURN_IF_ERROR(CheckStudyId(request.study_id()));
  RETURN_IF_ERROR(CheckRange("max_running", request.max_running(), 0, kMostRunning));
  return CheckPlainText("reason", request.reason(), kMaxReasonBytes);
}

absl::Status CheckSetPriority(const v1::SetPriorityRequest& request) {
  RETURN_IF_ERROR(CheckStudyId(request.study_id()));
  RETURN_IF_ERROR(CheckRange("priority", request.priority(), -kMaxPriority, kMaxPriority));
  return CheckPlainText("reason", request.reason(), kMaxReasonBytes);
}

absl::Status CheckRetryJob(const v1::RetryJobRequest& request) {
  RETURN_IF_ERROR(CheckStudyId(request.study_id()));
  RETURN_IF_ERROR(CheckJobId(request.job_id()));
  return CheckPlainText("reason", request.reason(), kMaxReasonBytes);
}

absl::Status CheckJobId(int64_t job_id) {
  if (job_id > 0) return absl::OkStatus();
  return InvalidArgument("job id {}: ids start at 1", job_id);
}

absl::Status CheckDrain(const v1::DrainWorkersRequest& request) {
  std::string name = request.pattern();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '*' || c == '?'; }, 'x');
  if (!IsName(name)) {
    return InvalidArgument(
        "pattern {} matches no name of a worker; it is a name in which * matches any characters "
        "and ? one",
        Quoted(request.pattern()));
  }
  return CheckPlainText("reason", request.reason(), kMaxReasonBytes);
}

absl::Status CheckJobState(const std::string& state) {
  return state.empty() ? absl::OkStatus() : CheckName("state", state);
}

absl::Status CheckPutHeader(const v1::PutFileHeader& header) {
  RETURN_IF_ERROR(CheckName("worker name", header.worker()));
  return CheckPlainText("path", header.path(), kMaxPath);
}

absl::Status CheckStudyId(int64_t study_id) {
  if (study_id > 0) return absl::OkStatus();
  return InvalidArgument("study id {}: ids start at 1", study_id);
}

absl::Status CheckNextPairs(const v1::NextPairsRequest& request) {
  if (!IsFolderName(request.stream())) {
    return InvalidArgument("stream: {}", WhyNotFolderName(request.stream()));
  }
  RETURN_IF_ERROR(CheckName("consumer", request.consumer()));
  RETURN_IF_ERROR(CheckRange("ranks", request.ranks(), 1, kMaxRanks));
  RETURN_IF_ERROR(CheckRange("rank", request.rank(), 0, request.ranks() - 1));
  RETURN_IF_ERROR(CheckRange("wait_s", request.wait_s(), 0.0, kMaxWait_s));
  return CheckLimit(request.limit(), kMaxPairsAtOnce);
}

absl::Status CheckLimit(int32_t limit, int32_t most) { return CheckRange("limit", limit, 0, most); }

}  // namespace parallax
