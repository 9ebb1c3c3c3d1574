#include "coordinator/queue/job_queue.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/log.h"
#include "coordinator/queue/commands/finisher.h"
#include "coordinator/queue/commands/lease_book.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/queue/commands/queue_news.h"
#include "coordinator/queue/commands/upkeep.h"
#include "coordinator/queue/database/backup.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/database/migrations.h"
#include "coordinator/queue/database/startup.h"
#include "coordinator/queue/reads/auditor.h"
#include "coordinator/queue/reads/cost_reader.h"
#include "coordinator/queue/reads/output_files.h"
#include "coordinator/queue/reads/readers.h"
#include "coordinator/queue/reads/user_limits.h"
#include "coordinator/queue/tables/ready_board.h"
#include "coordinator/queue/tables/record_table.h"
#include "coordinator/queue/writer.h"

namespace parallax {
namespace {

constexpr int kMostLeases = 1024;  // In one call.

}  // namespace

// Constant after Open, except for thread-safe members.
class JobQueue::Impl {
 public:
  explicit Impl(JobQueueOptions options)
      : options_(std::move(options)),
        book_(*options_.clock,
              options_.lease_s * (options_.unsafe_for_test.expire_early ? 0.5 : 1)) {}
  ~Impl() {
    readers_.reset();
    if (db_ == nullptr) return;
    if (const absl::Status status = PutLogAway(*db_, *lock_); !status.ok()) {
      LogWarning("the database's log stays beside it", {{"error", status}});
    }
  }

  absl::Status Open();
  absl::Status OpenStore();

  // Runs a command on the writing thread and waits for its commit.
  template <typename Command>
  auto Do(const char* name, const Command& command) {
    return writer_->Do(name, [&] { return command(*machine_); });
  }

  // Runs a command on the writing thread; after its commit, `finish` gets the result on the
  // finisher's.
  template <typename Apply, typename Finish>
  void DoAsync(const char* name, Finisher::Turn turn, Apply apply, Finish finish) {
    auto result = std::make_shared<decltype(apply())>();
    writer_->Enqueue({name,
                      [result, apply = std::move(apply)] { return StatusOf(*result = apply()); },
                      [this, turn, result, finish = std::move(finish)](const absl::Status& status) {
                        if (!status.ok()) *result = status;
                        finisher_->Enqueue(turn, [result, finish] { finish(*result); });
                      }});
  }

  // Returns the messages of leases. The job of one that can't be made has failed.
  std::vector<v1::Lease> Messages(const std::vector<GrantedLease>& granted) {
    std::vector<v1::Lease> leases;
    leases.reserve(granted.size());
    for (const GrantedLease& lease : granted) {
      absl::StatusOr<v1::Lease> message = readers_->LeaseMessage(lease);
      if (message.ok()) {
        leases.push_back(*std::move(message));
      } else {
        upkeep_->EndUntold(lease, message.status());
      }
    }
    return leases;
  }
  static absl::StatusOr<v1::ReportOutcome> OutcomeOf(const ReportVerdict& verdict) {
    if (verdict.invalid.empty()) return verdict.outcome;
    return InvalidArgument("{}", verdict.invalid);
  }

  void AddProgress(v1::JobStatus& job) const {
    if (job.state() != NameOf(JobState::kLeased)) return;
    const LeaseProgress progress = book_.ProgressOf(job.job_id());
    job.set_fraction(progress.fraction);
    job.set_stage(progress.stage);
    job.mutable_figures()->insert(progress.figures.begin(), progress.figures.end());
  }

  // Returns how far a leased job has come: its step, if it counts steps, else its fraction.
  double ProgressOf(int64_t job) const {
    const LeaseProgress progress = book_.ProgressOf(job);
    const auto step = progress.figures.find("step");
    return step == progress.figures.end() ? progress.fraction : step->second;
  }

  JobQueueOptions options_;
  std::unique_ptr<DatabaseLock> lock_;
  std::unique_ptr<SqliteConnection> db_;
  uint64_t epoch_ = 0;
  std::string database_id_;
  int64_t schema_version_ = 0;
  LeaseBook book_;
  ReadyBoard ready_;
  QueueNews news_{book_, ready_};
  std::unique_ptr<Machine> machine_;
  std::unique_ptr<Upkeep> upkeep_;
  std::unique_ptr<Readers> readers_;
  std::unique_ptr<Finisher> finisher_;
  std::unique_ptr<Writer> writer_;
};

absl::Status JobQueue::Impl::Open() {
  RETURN_IF_ERROR(CheckLocalFileSystem(options_.db_path));
  ASSIGN_OR_RETURN(lock_, DatabaseLock::Acquire(options_.db_path));
  ASSIGN_OR_RETURN(db_, OpenWriter(options_.db_path, options_.vfs));
  RETURN_IF_ERROR(WithContext(Migrate(*db_), options_.db_path));
  schema_version_ = NewestSchemaVersion();
  if (options_.unsafe_for_test.synchronous_off) {
    RETURN_IF_ERROR(db_->Execute("PRAGMA synchronous = OFF"));
  }
  ASSIGN_OR_RETURN(epoch_, RaiseEpoch(*db_, options_.clock->UnixSeconds(), options_.versions,
                                      options_.unsafe_for_test.keep_epoch));
  RETURN_IF_ERROR(lock_->NoteLog(true));
  ASSIGN_OR_RETURN(database_id_, DatabaseId(*db_));
  RETURN_IF_ERROR(WithContext(EnterKinds(*db_, *options_.kinds), options_.db_path));
  if (options_.open_store) RETURN_IF_ERROR(OpenStore());
  RETURN_IF_ERROR(AuditLimits(*db_, options_.limits, options_.clock->UnixSeconds()));
  machine_ = std::make_unique<Machine>(*db_, options_, epoch_);
  RETURN_IF_ERROR(machine_->Load());
  machine_->reports().SetProgress([this](int64_t job) { return ProgressOf(job); });
  RETURN_IF_ERROR(WithContext(ready_.Load(*db_, *options_.kinds), options_.db_path));
  upkeep_ = std::make_unique<Upkeep>(*machine_, book_, options_);
  ASSIGN_OR_RETURN(readers_, Readers::Open(options_.db_path, options_.vfs, options_.readers,
                                           options_.read_deadline_s, *options_.kinds));
  const double now = options_.clock->UnixSeconds();
  RETURN_IF_ERROR(NoteUnheard(*db_, now));
  SqliteQuery leased(*db_,
                     "SELECT j.id, j.fence, j.worker, u.since_unix_s FROM jobs AS j"
                     " JOIN unheard_workers AS u ON u.worker = j.worker WHERE j.state = 'LEASED'");
  while (leased.Next()) {
    book_.Add({.job = leased.Int(0),
               .fence = static_cast<uint64_t>(leased.Int(1)),
               .worker = std::string(leased.Text(2))},
              options_.unsafe_for_test.hear_at_start
                  ? 0
                  : std::clamp(now - leased.Real(3), 0.0, options_.lease_s));
  }
  RETURN_IF_ERROR(leased.status());

  ASSIGN_OR_RETURN(const std::vector<int64_t> others,
                   LeasesOfOtherVersions(*db_, options_.versions, *options_.kinds));

  finisher_ = std::make_unique<Finisher>(options_.own_threads);
  Writer::Hooks hooks;
  hooks.published = [this](const Effects& effects) { news_.Publish(effects); };
  hooks.tick = [this] { return upkeep_->Tick(); };
  hooks.due = [this] { return upkeep_->IsDue(); };
  if (options_.own_timer) hooks.tick_s = std::clamp(options_.lease_s / 20, 0.01, 0.5);
  // The writing thread may use the connection at once, to make scenes; this thread no longer does.
  writer_ = std::make_unique<Writer>(*db_, *machine_, options_, std::move(hooks));
  if (others.empty() || options_.unsafe_for_test.any_version) return absl::OkStatus();
  return Do("worker_lost", [&](Machine& machine) { return machine.reports().EndEarlier(others); });
}

absl::Status JobQueue::Impl::OpenStore() {
  ASSIGN_OR_RETURN(KnownStore known, ReadKnownStore(*db_, *options_.kinds));
  known.database_id = database_id_;
  ASSIGN_OR_RETURN(const std::string id, options_.open_store(known));
  return id == known.id ? absl::OkStatus()
                        : EnterStore(*db_, known.id, id, options_.clock->UnixSeconds());
}

absl::StatusOr<std::unique_ptr<JobQueue>> JobQueue::Open(JobQueueOptions options) {
  constexpr size_t kLongestPath = 500;  // SQLite's own bound is 512, with the endings of its files.
  std::error_code error;
  const std::string full = std::filesystem::absolute(options.db_path, error);
  if (full.size() > kLongestPath) {
    return InvalidArgument("database {}...: its path has {} bytes, allowed are {}",
                           Printable(full.substr(0, 60)), full.size(), kLongestPath);
  }
  auto impl = std::make_unique<Impl>(std::move(options));
  RETURN_IF_ERROR(impl->Open());
  return std::unique_ptr<JobQueue>(new JobQueue(std::move(impl)));
}

JobQueue::JobQueue(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
JobQueue::~JobQueue() {
  SetObserver(nullptr);
  impl_->writer_.reset();
  impl_->finisher_.reset();
  impl_->readers_.reset();
}

uint64_t JobQueue::epoch() const { return impl_->epoch_; }
const KindRegistry& JobQueue::kinds() const { return *impl_->options_.kinds; }
const std::string& JobQueue::database_id() const { return impl_->database_id_; }
int64_t JobQueue::schema_version() const { return impl_->schema_version_; }
double JobQueue::lease_s() const { return impl_->options_.lease_s; }

void JobQueue::SetObserver(JobQueueObserver* observer) { impl_->news_.SetObserver(observer); }

// ---- Clients
absl::StatusOr<v1::SubmitReply> JobQueue::Submit(const v1::SubmitRequest& request,
                                                 std::string_view actor) {
  RETURN_IF_ERROR(CheckStudySpec(request.study()));
  return impl_->Do("submit",
                   [&](Machine& machine) { return machine.studies().Submit(request, actor); });
}

absl::Status JobQueue::Cancel(StudyId study, std::string_view reason, std::string_view actor) {
  return impl_->Do("cancel", [&](Machine& machine) {
    return machine.studies().Cancel(study.value, reason, actor);
  });
}

absl::Status JobQueue::Pause(StudyId study, std::string_view reason, std::string_view actor) {
  return impl_->Do("pause", [&](Machine& machine) {
    return machine.studies().SetPaused(study.value, true, reason, actor);
  });
}

absl::Status JobQueue::Resume(StudyId study, std::string_view reason, std::string_view actor) {
  return impl_->Do("resume", [&](Machine& machine) {
    return machine.studies().SetPaused(study.value, false, reason, actor);
  });
}

absl::Status JobQueue::Comment(StudyId study, std::string_view text, std::string_view actor) {
  return impl_->Do("comment", [&](Machine& machine) {
    return machine.studies().Comment(study.value, text, actor);
  });
}

absl::Status JobQueue::SetMaxRunning(StudyId study, int64_t max_running, std::string_view reason,
                                     std::string_view actor) {
  return impl_->Do("limit", [&](Machine& machine) {
    return machine.limits().SetMaxRunning(study.value, max_running, reason, actor);
  });
}

absl::Status JobQueue::SetPriority(StudyId study, int priority, std::string_view reason,
                                   std::string_view actor) {
  return impl_->Do("priority", [&](Machine& machine) {
    return machine.limits().SetPriority(study.value, priority, reason, actor);
  });
}

absl::Status JobQueue::RetryJob(StudyId study, int64_t job, std::string_view reason,
                                std::string_view actor) {
  return impl_->Do("retry", [&](Machine& machine) {
    return machine.retries().RetryJob(study.value, job, reason, actor);
  });
}

absl::StatusOr<int64_t> JobQueue::Retry(StudyId study, std::string_view actor,
                                        std::string_view reason) {
  return impl_->Do("retry", [&](Machine& machine) {
    return machine.retries().Retry(study.value, reason, actor);
  });
}

absl::StatusOr<v1::ForgetReply> JobQueue::Forget(StudyId study, std::string_view reason,
                                                 std::string_view actor) {
  return impl_->Do("forget", [&](Machine& machine) -> absl::StatusOr<v1::ForgetReply> {
    ASSIGN_OR_RETURN(const v1::ForgetReply had,
                     machine.forgetting().Forget(study.value, reason, actor));
    impl_->upkeep_->RemoveOldNow();
    return had;
  });
}

absl::StatusOr<bool> JobQueue::CancelAndForget(StudyId study, std::string_view reason,
                                               std::string_view actor) {
  const absl::Status cancelled = Cancel(study, reason, actor);
  if (!cancelled.ok() && !absl::IsFailedPrecondition(cancelled) && !absl::IsNotFound(cancelled)) {
    return cancelled;
  }
  const absl::Status forgotten = Forget(study, reason, actor).status();
  if (absl::IsFailedPrecondition(forgotten)) return false;
  if (!forgotten.ok() && !absl::IsNotFound(forgotten)) return forgotten;
  return true;
}

absl::Status JobQueue::Drain(const v1::DrainOrder& order, bool undo) {
  return impl_->Do("drain", [&](Machine& machine) { return machine.limits().Drain(order, undo); });
}

// ---- Workers
absl::StatusOr<std::vector<v1::Lease>> JobQueue::Lease(const WorkerFacts& worker, int max_jobs) {
  const int n = std::min(max_jobs, kMostLeases);
  ASSIGN_OR_RETURN(
      const std::vector<GrantedLease> granted,
      impl_->Do("lease", [&](Machine& machine) { return machine.scheduler().Lease(worker, n); }));
  return impl_->Messages(granted);
}

void JobQueue::LeaseAsync(const WorkerFacts& worker, int max_jobs,
                          std::function<void(absl::StatusOr<std::vector<v1::Lease>>)> done) {
  Impl* impl = impl_.get();
  impl->DoAsync(
      "lease", Finisher::Turn::kFirst,
      [=] { return impl->machine_->scheduler().Lease(worker, std::min(max_jobs, kMostLeases)); },
      [=](const absl::StatusOr<std::vector<GrantedLease>>& granted) {
        if (!granted.ok()) return done(granted.status());
        done(impl->Messages(*granted));
      });
}

absl::StatusOr<v1::ReportOutcome> JobQueue::Complete(const v1::CompleteRequest& request) {
  const CheckedReport report = CheckReport(request, *impl_->options_.kinds);
  ASSIGN_OR_RETURN(const ReportVerdict verdict, impl_->Do("complete", [&](Machine& machine) {
    return machine.reports().Complete(report);
  }));
  return Impl::OutcomeOf(verdict);
}

void JobQueue::CompleteAsync(const v1::CompleteRequest& request, const std::string& invalid,
                             std::function<void(absl::StatusOr<v1::ReportOutcome>)> done) {
  Impl* impl = impl_.get();
  auto report = std::make_shared<CheckedReport>(CheckReport(request, *impl_->options_.kinds));
  report->of_store = report->invalid.empty() && !invalid.empty();
  if (report->of_store) report->invalid = invalid;
  impl->DoAsync(
      "complete", Finisher::Turn::kAfterThose,
      [=] { return impl->machine_->reports().Complete(*report); },
      [=](const absl::StatusOr<ReportVerdict>& verdict) {
        if (!verdict.ok()) return done(verdict.status());
        done(Impl::OutcomeOf(*verdict));
      });
}

absl::StatusOr<v1::ReportOutcome> JobQueue::Fail(const v1::FailRequest& request) {
  return impl_->Do("fail", [&](Machine& machine) { return machine.reports().Fail(request); });
}

absl::StatusOr<v1::ReportOutcome> JobQueue::HandBack(const std::string& worker,
                                                     const v1::AttemptId& attempt,
                                                     std::string_view reason) {
  return impl_->Do("hand_back", [&](Machine& machine) {
    return machine.reports().HandBack(worker, attempt, reason);
  });
}

absl::StatusOr<std::vector<v1::AttemptId>> JobQueue::Adopt(
    const std::string& worker, const std::vector<v1::AttemptId>& holding, bool same_process) {
  ASSIGN_OR_RETURN(std::vector<v1::AttemptId> adopted, impl_->Do("adopt", [&](Machine& machine) {
    return machine.reports().Adopt(worker, holding, same_process);
  }));
  for (const v1::AttemptId& attempt : adopted) impl_->book_.Touch(worker, attempt);
  return adopted;
}

absl::StatusOr<int> JobQueue::WorkerLost(const std::string& worker) {
  return impl_->Do("worker_lost",
                   [&](Machine& machine) { return machine.reports().WorkerLost(worker); });
}

absl::StatusOr<int> JobQueue::WorkerLeft(const std::string& worker) {
  return impl_->Do("worker_lost",
                   [&](Machine& machine) { return machine.reports().WorkerLeft(worker); });
}

std::vector<v1::AttemptId> JobQueue::Heartbeat(const std::string& worker,
                                               const std::vector<v1::Progress>& running) {
  return impl_->book_.Heartbeat(worker, running);
}

absl::StatusOr<double> JobQueue::Tick() {
  ASSIGN_OR_RETURN(
      const std::optional<double> next,
      impl_->Do("tick", [&](Machine& machine) -> absl::StatusOr<std::optional<double>> {
        RETURN_IF_ERROR(impl_->upkeep_->Tick());
        return machine.tables().jobs.NextBackoff();
      }));
  return impl_->upkeep_->SecondsToNext(next);
}

bool JobQueue::Work() { return impl_->writer_->Work(); }

// ---- Reads
absl::StatusOr<bool> JobQueue::IsArchived(StudyId study) {
  return impl_->readers_->Get(false, [&](SqliteConnection& db) -> absl::StatusOr<bool> {
    ASSIGN_OR_RETURN(const auto archived,
                     db.Integer("SELECT archived FROM studies WHERE id = ?1", study.value));
    return archived.value_or(0) != 0;
  });
}
absl::StatusOr<std::vector<int64_t>> JobQueue::ListSubmitted(const std::string& prefix,
                                                             std::string_view actor) {
  return impl_->readers_->ListSubmitted(prefix, UserOfActor(actor));
}
absl::StatusOr<v1::StudyStatus> JobQueue::GetStudy(StudyId study) {
  ASSIGN_OR_RETURN(v1::StudyStatus status, impl_->readers_->GetStudy(study.value));
  RETURN_IF_ERROR(AddLimits(*impl_->readers_, impl_->options_.limits, {&status, 1}));
  return status;
}
absl::StatusOr<std::vector<v1::StudyStatus>> JobQueue::ListStudies(int limit, int64_t before,
                                                                   bool only_unfinished) {
  ASSIGN_OR_RETURN(std::vector<v1::StudyStatus> studies,
                   impl_->readers_->ListStudies(limit, before, only_unfinished));
  RETURN_IF_ERROR(AddLimits(*impl_->readers_, impl_->options_.limits, studies));
  return studies;
}
absl::StatusOr<std::vector<v1::UserStatus>> JobQueue::ListUsers() {
  return UsersWithLimits(*impl_->readers_, impl_->options_.limits);
}
absl::StatusOr<std::vector<v1::JobStatus>> JobQueue::ListJobs(const v1::ListJobsRequest& request) {
  ASSIGN_OR_RETURN(std::vector<v1::JobStatus> jobs, impl_->readers_->ListJobs(request));
  for (v1::JobStatus& job : jobs) impl_->AddProgress(job);
  return jobs;
}
absl::StatusOr<v1::ListAttemptsReply> JobQueue::ListAttempts(int64_t job) {
  ASSIGN_OR_RETURN(v1::ListAttemptsReply reply, impl_->readers_->ListAttempts(job));
  impl_->AddProgress(*reply.mutable_job());
  for (v1::AttemptStatus& attempt : *reply.mutable_attempts()) {
    if (attempt.ending() == "running") attempt.set_log_tail(impl_->book_.ProgressOf(job).log_tail);
  }
  return reply;
}
absl::StatusOr<std::vector<v1::DrainOrder>> JobQueue::Drains() {
  return impl_->readers_->Get(0, ListDrains);
}
absl::StatusOr<std::vector<v1::PublishedFrame>> JobQueue::ListFrames(
    const v1::ListFramesRequest& request) {
  return impl_->readers_->ListFrames(request);
}
absl::StatusOr<std::vector<v1::JobResult>> JobQueue::ListResults(
    const v1::ListResultsRequest& request) {
  return impl_->readers_->ListResults(request);
}
absl::StatusOr<std::vector<v1::AuditEntry>> JobQueue::ListAudit(
    const v1::ListAuditRequest& request) {
  return impl_->readers_->ListAudit(request);
}
absl::StatusOr<std::string> JobQueue::SubmitterOf(StudyId study) {
  return impl_->readers_->SubmitterOf(study.value);
}
bool JobQueue::IsHeldBy(const std::string& worker, const v1::AttemptId& attempt) const {
  return impl_->book_.Holds(worker, attempt);
}
std::map<ReadyKey, int64_t> JobQueue::ReadyGroups(int64_t study) const {
  return impl_->ready_.Groups(study);
}
int JobQueue::HeldBy(const std::string& worker) const { return impl_->book_.HeldBy(worker); }
absl::StatusOr<v1::Scene> JobQueue::GetScene(const v1::GetSceneRequest& request) {
  return impl_->readers_->GetScene(request);
}

// ---- The farm's figures over time
void JobQueue::KeepSample(const HistorySample& sample) {
  Impl* impl = impl_.get();
  impl_->writer_->Enqueue(
      {"history", [impl, sample] { return KeepSampleIn(*impl->db_, sample); }, nullptr});
}
absl::StatusOr<std::vector<HistorySample>> JobQueue::ListSamples(double since_unix_s) {
  return impl_->readers_->ListSamples(since_unix_s);
}

// ---- Notices
absl::StatusOr<std::vector<Notice>> JobQueue::ListNotices(int limit) {
  const double now = impl_->options_.clock->UnixSeconds();
  return impl_->readers_->Get(
      0, [&](SqliteConnection& db) { return parallax::ListNotices(db, now, limit); });
}
absl::Status JobQueue::RaiseNotice(StudyId study, const char* event) {
  return impl_->Do("notice", [&](Machine& machine) {
    const double now = machine.tables().Now();
    return machine.tables().notices.Raise(study.value, event, now, now);
  });
}
absl::Status JobQueue::EndNotice(const Notice& notice) {
  return impl_->Do("notice", [&](Machine& machine) {
    Tables& tables = machine.tables();
    return tables.notices.End(notice, tables.Now() + tables.options.notice_gather_s);
  });
}
absl::Status JobQueue::DelayNotice(const Notice& notice, double delay_s) {
  return impl_->Do("notice", [&](Machine& machine) {
    return machine.tables().notices.Delay(notice,
                                          machine.tables().Now() + std::min(delay_s, 3600.0));
  });
}

// ---- Litter
absl::StatusOr<std::vector<std::string>> JobQueue::ListLitter(double older_than_s, int limit) {
  return impl_->readers_->ListLitter(impl_->options_.clock->UnixSeconds() - older_than_s, limit);
}
absl::Status JobQueue::ForgetLitter(const std::vector<std::string>& paths) {
  return impl_->Do("forget_litter",
                   [&](Machine& machine) { return machine.tables().folders.DeleteLitter(paths); });
}

absl::StatusOr<std::vector<std::string>> JobQueue::ListContentFolders() {
  return impl_->readers_->ListContentFolders();
}

absl::StatusOr<std::set<std::string>> JobQueue::ListAttemptFolders() {
  return impl_->readers_->Get(
      0, [&](SqliteConnection& db) { return AttemptFoldersIn(db, *impl_->options_.kinds); });
}

// ---- Damage in the store
absl::StatusOr<std::vector<StoredOutput>> JobQueue::ListStoredOutputs(const std::string& after,
                                                                      int limit) {
  return impl_->readers_->Get(0, [&](SqliteConnection& db) {
    return StoredOutputsIn(db, *impl_->options_.kinds, after, limit);
  });
}

absl::StatusOr<std::vector<std::string>> JobQueue::ListUsesOf(const Sha256Digest& key) {
  return impl_->readers_->Get(0, [&](SqliteConnection& db) { return UsesOfIn(db, key); });
}

absl::StatusOr<TakenBack> JobQueue::TakeBack(const std::vector<DamagedResult>& damaged,
                                             std::string_view actor) {
  return impl_->Do("repair",
                   [&](Machine& machine) { return machine.repair().TakeBack(damaged, actor); });
}

absl::Status JobQueue::KeepStream(const v1::StreamRecord& record) {
  return impl_->Do("stream", [&](Machine& machine) {
    return KeepRecordIn(machine.tables().db, kStreamTable, record.study().name(), record);
  });
}

absl::Status JobQueue::RemoveStream(const std::string& name) {
  return impl_->Do("stream", [&](Machine& machine) {
    return RemoveRecordIn(machine.tables().db, kStreamTable, name);
  });
}

absl::StatusOr<std::vector<v1::StreamRecord>> JobQueue::ListStreams() {
  return impl_->readers_->Get(
      0, [](SqliteConnection& db) { return RecordsIn<v1::StreamRecord>(db, kStreamTable); });
}

absl::Status JobQueue::KeepSearch(const v1::SearchRecord& record) {
  return impl_->Do("search", [&](Machine& machine) {
    return KeepRecordIn(machine.tables().db, kSearchTable, record.study().name(), record);
  });
}

absl::Status JobQueue::RemoveSearch(const std::string& name) {
  return impl_->Do("search", [&](Machine& machine) {
    return RemoveRecordIn(machine.tables().db, kSearchTable, name);
  });
}

absl::StatusOr<std::vector<v1::SearchRecord>> JobQueue::ListSearches() {
  return impl_->readers_->Get(
      0, [](SqliteConnection& db) { return RecordsIn<v1::SearchRecord>(db, kSearchTable); });
}

absl::StatusOr<StudyCosts> JobQueue::CostsOf(StudyId study) {
  return impl_->readers_->Get(0, [&](SqliteConnection& db) {
    return StudyCostsIn(db, *impl_->options_.kinds, study.value);
  });
}

absl::StatusOr<std::optional<ScrubState>> JobQueue::GetScrub() {
  return impl_->readers_->Get(0, ScrubIn);
}

absl::Status JobQueue::KeepScrub(const ScrubState& scrub) {
  return impl_->Do("scrub", [&](Machine& machine) { return machine.repair().KeepScrub(scrub); });
}

absl::StatusOr<std::vector<RunningJob>> JobQueue::ListRunning() {
  constexpr size_t kMostRunning = 1000;
  return impl_->readers_->ListRunning(impl_->book_.Figures(kMostRunning));
}

JobQueueStats JobQueue::Stats() const {
  JobQueueStats stats = impl_->news_.counted();
  impl_->writer_->AddStats(stats);
  stats.leases_held = impl_->book_.size();
  return stats;
}

// ---- Operations
absl::StatusOr<std::vector<std::string>> JobQueue::Check() {
  return impl_->readers_->Get(
      0, [&](SqliteConnection& db) { return AuditDatabase(db, *impl_->options_.kinds); });
}

absl::Status JobQueue::Backup(const std::string& path) {
  return impl_->readers_->Read(0, [&](SqliteConnection& db) { return BackUp(db, path); });
}

}  // namespace parallax
