#include "coordinator/rpc/notifier.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/http_url.h"
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
  const bool waits = notice.event == kNoticeWaits;
  std::string text = waits
                         ? name + ": jobs wait for a person"
                         : fmt::format("{}: no job of it has run for {:.0f} minutes, {} are ready",
                                       name, stall_s / 60, JobsInState(study, "READY"));
  for (const v1::WaitingJobs& jobs : study.waiting()) {
    if (waits && !NeedsPerson(jobs.reason())) continue;
    text += fmt::format("; {} {} jobs: {}", jobs.jobs(), jobs.kind(), jobs.text());
  }
  return text;
}

// Whether it still says what is the case. An end is told again when the study ends again.
bool IsWanted(const Notice& notice, const v1::StudyStatus& study) {
  if (notice.event == kNoticeWaits) {
    return std::any_of(study.waiting().begin(), study.waiting().end(),
                       [](const v1::WaitingJobs& jobs) { return NeedsPerson(jobs.reason()); });
  }
  return notice.event != kNoticeDone || study.finished_unix_s() > 0;
}

// Names the receiver in the log: an address without its path, which may be a secret.
std::string ReceiverOf(const Notice& notice) {
  return notice.target == kStudyTarget ? HostOfUrl(notice.url) : notice.target;
}

}  // namespace

std::vector<std::string> NotifierOptions::Targets() const {
  std::vector<std::string> targets;
  if (!url.empty()) targets.push_back(kWebhook);
  if (!command.empty()) targets.push_back(kCommand);
  if (!hosts.empty()) targets.push_back(kStudyTarget);
  return targets;
}

absl::Status CheckNotifierOptions(const NotifierOptions& options) {
  if (!options.url.empty() && !WhyNotHttpUrl(options.url).empty()) {
    return InvalidArgument("--notify {}: {}", Quoted(options.url), WhyNotHttpUrl(options.url));
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

Notifier::~Notifier() { StopThread(); }

void Notifier::Finish() {
  StopThread();
  {
    const std::lock_guard lock(mu_);
    stopping_ = false;
  }
  if (const auto looked = Look(); !looked.ok()) {
    LogWarning("notices can't be read", {{"error", looked.status()}});
  }
}

void Notifier::StopThread() {
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
  RETURN_IF_ERROR(LookAtStudies());
  ASSIGN_OR_RETURN(const std::vector<Notice> notices, queue_.ListNotices(kAtOnce));
  int delivered = 0;
  std::map<std::string, int> failed;  // By receiver.
  for (const Notice& notice : notices) {
    if (IsStopping()) break;
    // A receiver that is away is not asked again before the next look. Users' receivers are many.
    int& failures = failed[ReceiverOf(notice)];
    const bool is_own = notice.target == kStudyTarget;
    if (!is_own && failures == kMostFailed) continue;
    const absl::Status status =
        is_own && failures > 0 ? Unavailable("the host has just not answered") : Deliver(notice);
    if (status.ok()) {
      RETURN_IF_ERROR(queue_.EndNotice(notice));
      ++delivered;
      continue;
    }
    ++failures;
    const bool over = options_.clock->UnixSeconds() - notice.since_unix_s > kKept_s;
    LogWarning(over ? "a notice is dropped after a week" : "a notice is not delivered",
               {{"to", ReceiverOf(notice)},
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

bool Notifier::IsNews(Finding& finding, double now_s, double least_s, int64_t look) {
  if (finding.seen == 0) finding.since_s = now_s;
  finding.seen = look;
  return !finding.told && now_s - finding.since_s >= least_s;
}

absl::Status Notifier::LookAtStudies() {
  ASSIGN_OR_RETURN(const auto studies,
                   queue_.ListStudies(kMostStudies, 0, /*only_unfinished=*/true));
  const double now =
      std::chrono::duration<double>(options_.clock->Steady().time_since_epoch()).count();
  ++look_;
  for (const v1::StudyStatus& study : studies) {
    if (study.state() != v1::STUDY_STATE_RUNNING || JobsInState(study, "READY") == 0) continue;
    RETURN_IF_ERROR(LookForStall(study, now));
    RETURN_IF_ERROR(LookForNeeds(study, now));
  }
  // A finding that this look did not make is forgotten, so that its next time is news.
  std::erase_if(stalls_, [this](const auto& entry) { return entry.second.seen != look_; });
  std::erase_if(needs_, [this](const auto& entry) { return entry.second.seen != look_; });
  return absl::OkStatus();
}

absl::Status Notifier::LookForStall(const v1::StudyStatus& study, double now_s) {
  if (options_.stall_s <= 0 || JobsInState(study, "LEASED") > 0) return absl::OkStatus();
  Finding& stall = stalls_[study.study_id()];
  if (!IsNews(stall, now_s, options_.stall_s, look_)) return absl::OkStatus();
  RETURN_IF_ERROR(queue_.RaiseNotice(StudyId{study.study_id()}, kNoticeStalled));
  stall.told = true;  // Not before: what the database does not keep is news again.
  return absl::OkStatus();
}

absl::Status Notifier::LookForNeeds(v1::StudyStatus study, double now_s) {
  const int64_t id = study.study_id();
  waits_.AddTo(study);
  std::vector<Finding*> news;
  for (const v1::WaitingJobs& jobs : study.waiting()) {
    if (jobs.reason() == "no_worker") {  // Nobody knows what the next ones bring.
      for (auto& [key, need] : needs_) {
        if (key.first == id) need.seen = look_;
      }
    }
    if (!NeedsPerson(jobs.reason())) continue;
    // The text of memory names what workers have, which changes as they come and go.
    const std::string what = jobs.reason() == "memory" ? jobs.reason() : jobs.text();
    Finding& need = needs_[{id, jobs.kind() + " " + what}];
    if (IsNews(need, now_s, options_.waits_s, look_)) news.push_back(&need);
  }
  if (news.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(queue_.RaiseNotice(StudyId{id}, kNoticeWaits));
  for (Finding* need : news) need->told = true;
  return absl::OkStatus();
}

absl::Status Notifier::Deliver(const Notice& notice) const {
  absl::StatusOr<v1::StudyStatus> study = queue_.GetStudy(StudyId{notice.study});
  if (absl::IsNotFound(study.status())) return absl::OkStatus();  // It is forgotten.
  RETURN_IF_ERROR(study.status());
  waits_.AddTo(*study);
  if (!IsWanted(notice, *study)) return absl::OkStatus();
  const std::string json = NoticeJson(notice, *study, options_.stall_s);
  if (notice.target == kWebhook && !options_.url.empty()) return Post(options_.url, json);
  if (notice.target == kStudyTarget && options_.hosts.Allows(notice.url)) {
    return Post(notice.url, json);
  }
  if (notice.target == kCommand && !options_.command.empty()) return RunCommand(json);
  return absl::OkStatus();  // Its receiver is no longer wanted.
}

absl::Status Notifier::Post(const std::string& url, const std::string& json) const {
  const HttpAnswer answer = http_.Send({.method = "POST",
                                        .url = url,
                                        .body = {.bytes = json},
                                        .content_type = "application/json",
                                        .most_s = static_cast<long>(std::ceil(options_.most_s))});
  if (answer.code >= 200 && answer.code < 300) return absl::OkStatus();
  const std::string host = HostOfUrl(url);
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
