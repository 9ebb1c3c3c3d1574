#include "coordinator/rpc/notifier.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/names.h"
#include "common/base/system/child_process.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/base/system/temporary_folder.h"
#include "coordinator/rpc/workers/wait_reasons.h"
#include "coordinator/study/job_counts.h"
#include "coordinator/view/status_view.h"

namespace parallax {
namespace {

constexpr char kWebhook[] = "webhook";
constexpr char kCommand[] = "command";
constexpr int kAtOnce = 100;           // Notices in one look.
constexpr int kMostFailed = 3;         // Then a look ends: the receiver is away.
constexpr double kKept_s = 7 * 86400;  // A notice that is older is dropped.
constexpr int kMostStudies = 10'000;
constexpr size_t kMostSaid = 500;  // Bytes of a receiver's words in the log.
constexpr std::chrono::milliseconds kAskEvery{20};

std::string TextOf(const Notice& notice, const v1::StudyStatus& study, double stall_s) {
  const PairCounts counts = CountsOf(study);
  const std::string name = fmt::format("study {} ({})", study.study_id(), study.name());
  const std::string pairs = fmt::format("{} of {} pairs done", counts.done, counts.wanted);
  if (notice.event == kNoticeDone) {
    return fmt::format("{} is {}: {}", name, StateName(study.state()), pairs);
  }
  if (notice.event == kNoticeFailed) {
    std::string text = fmt::format("{}: {} jobs have failed", name, counts.failed);
    for (const v1::VariantStatus& variant : study.variants()) {
      if (variant.problems().empty()) continue;
      return text + "; the last: " + variant.problems(0).error();
    }
    return text;
  }
  std::string text = fmt::format("{}: no job of it has run for {:.0f} minutes, {} are ready", name,
                                 stall_s / 60, JobsInState(study, "READY"));
  for (const v1::WaitingJobs& jobs : study.waiting()) {
    text += fmt::format("; {} {} jobs: {}", jobs.jobs(), jobs.kind(), jobs.text());
  }
  return text;
}

// Whether it still says what is the case. An end is told again when the study ends again.
bool IsWanted(const Notice& notice, const v1::StudyStatus& study) {
  return notice.event != kNoticeDone || study.finished_unix_s() > 0;
}

// The host of a URL, without name and password: its path may be a secret.
std::string HostOf(const std::string& url) {
  const size_t begin = url.find("://") + 3;
  const std::string authority = url.substr(begin, url.find_first_of("/?#", begin) - begin);
  return authority.substr(authority.rfind('@') + 1);
}

}  // namespace

std::vector<std::string> NotifierOptions::Targets() const {
  std::vector<std::string> targets;
  if (!url.empty()) targets.push_back(kWebhook);
  if (!command.empty()) targets.push_back(kCommand);
  return targets;
}

absl::Status CheckNotifierOptions(const NotifierOptions& options) {
  const std::string& url = options.url;
  const bool http = url.rfind("http://", 0) == 0 || url.rfind("https://", 0) == 0;
  if (!url.empty() && (!http || HostOf(url).empty())) {
    return InvalidArgument("--notify {}: wanted http://HOST/... or https://HOST/...", Quoted(url));
  }
  const std::string& command = options.command;
  if (command.find('/') != std::string::npos && access(command.c_str(), X_OK) != 0) {
    return NotFound("--notify-command {}: is no program that can be run", Quoted(command));
  }
  return absl::OkStatus();
}

std::string NoticeJson(const Notice& notice, const v1::StudyStatus& study, double stall_s) {
  const nlohmann::ordered_json json = {{"event", notice.event},
                                       {"text", TextOf(notice, study, stall_s)},
                                       {"unix_s", notice.since_unix_s},
                                       {"study", StudyLineJson(study)}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Notifier::Notifier(JobQueue& queue, const WaitReasons& waits, const NotifierOptions& options)
    : queue_(queue), waits_(waits), options_(options) {
  if (options_.every_s > 0) thread_ = std::thread([this] { Loop(); });
}

Notifier::~Notifier() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool Notifier::IsStopping() const {
  const std::lock_guard lock(mu_);
  return stopping_;
}

void Notifier::Loop() {
  std::unique_lock lock(mu_);
  while (!stopping_) {
    lock.unlock();
    if (const auto looked = Look(); !looked.ok()) {
      LogWarning("notices can't be read", {{"error", looked.status()}});
    }
    lock.lock();
    stop_.wait_for(lock, std::chrono::duration<double>(options_.every_s),
                   [this] { return stopping_; });
  }
}

absl::StatusOr<int> Notifier::Look() {
  RETURN_IF_ERROR(LookForStalls());
  ASSIGN_OR_RETURN(const std::vector<Notice> notices, queue_.ListNotices(kAtOnce));
  int delivered = 0, failed = 0;
  for (const Notice& notice : notices) {
    if (IsStopping() || failed == kMostFailed) break;
    const absl::Status status = Deliver(notice);
    if (status.ok()) {
      RETURN_IF_ERROR(queue_.EndNotice(notice));
      ++delivered;
      continue;
    }
    ++failed;
    const bool over = options_.clock->UnixSeconds() - notice.since_unix_s > kKept_s;
    LogWarning(over ? "a notice is dropped after a week" : "a notice is not delivered",
               {{"to", notice.target},
                {"event", notice.event},
                {"study", notice.study},
                {"tries", notice.tries + 1},
                {"error", status}});
    RETURN_IF_ERROR(over ? queue_.EndNotice(notice)
                         : queue_.DelayNotice(
                               notice, options_.retry_s * std::exp2(std::min(notice.tries, 20))));
  }
  return delivered;
}

absl::Status Notifier::LookForStalls() {
  if (options_.stall_s <= 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(const auto studies,
                   queue_.ListStudies(kMostStudies, 0, /*only_unfinished=*/true));
  const double now =
      std::chrono::duration<double>(options_.clock->Steady().time_since_epoch()).count();
  std::map<int64_t, double> idle;
  for (const v1::StudyStatus& study : studies) {
    const bool stands = study.state() == v1::STUDY_STATE_RUNNING &&
                        JobsInState(study, "READY") > 0 && JobsInState(study, "LEASED") == 0;
    const int64_t id = study.study_id();
    if (!stands) continue;
    const auto before = idle_since_s_.find(id);
    idle[id] = before == idle_since_s_.end() ? now : before->second;
    if (now - idle[id] < options_.stall_s || !told_stalled_.insert(id).second) continue;
    RETURN_IF_ERROR(queue_.RaiseStalled(StudyId{id}));
  }
  idle_since_s_ = std::move(idle);
  std::erase_if(told_stalled_, [&](int64_t id) { return idle_since_s_.count(id) == 0; });
  return absl::OkStatus();
}

absl::Status Notifier::Deliver(const Notice& notice) const {
  absl::StatusOr<v1::StudyStatus> study = queue_.GetStudy(StudyId{notice.study});
  if (absl::IsNotFound(study.status())) return absl::OkStatus();  // It is forgotten.
  RETURN_IF_ERROR(study.status());
  if (!IsWanted(notice, *study)) return absl::OkStatus();
  waits_.AddTo(*study);
  const std::string json = NoticeJson(notice, *study, options_.stall_s);
  if (notice.target == kWebhook && !options_.url.empty()) return Post(json);
  if (notice.target == kCommand && !options_.command.empty()) return RunCommand(json);
  return absl::OkStatus();  // Its receiver is no longer wanted.
}

absl::Status Notifier::Post(const std::string& json) const {
  const HttpAnswer answer = http_.Send({.method = "POST",
                                        .url = options_.url,
                                        .body = {.bytes = json},
                                        .content_type = "application/json",
                                        .most_s = static_cast<long>(std::ceil(options_.most_s))});
  if (answer.code >= 200 && answer.code < 300) return absl::OkStatus();
  const std::string host = HostOf(options_.url);
  if (answer.code == 0) return Unavailable("{}: {}", host, answer.error);
  return Unavailable("{} answers {}: {}", host, answer.code,
                     CutText(Printable(answer.body), kMostSaid));
}

absl::Status Notifier::RunCommand(const std::string& json) const {
  ASSIGN_OR_RETURN(const TemporaryFolder folder, TemporaryFolder::Make("notify"));
  const std::string log = folder.path() + "/log";
  ASSIGN_OR_RETURN(const auto child,
                   ChildProcess::Start({.command = {options_.command, json}, .log = log}));
  const auto end =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.most_s);
  std::optional<int> status;
  while (!(status = child->Poll())) {
    if (IsStopping()) return Cancelled("{}: the coordinator stops", options_.command);
    if (std::chrono::steady_clock::now() > end) {
      return DeadlineExceeded("{}: has not ended after {:.0f} s", options_.command,
                              options_.most_s);
    }
    std::this_thread::sleep_for(kAskEvery);
  }
  if (*status == 0) return absl::OkStatus();
  const std::string said = ReadFile(log, 1 << 20).value_or("");
  return Unavailable("{}: {}{}", options_.command, DescribeExit(*status),
                     said.empty() ? "" : ": " + CutText(Printable(said), kMostSaid));
}

}  // namespace parallax
