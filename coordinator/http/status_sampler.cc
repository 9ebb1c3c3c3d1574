#include "coordinator/http/status_sampler.h"

#include <algorithm>

#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/base/version.h"
#include "coordinator/rpc/workers/wait_reasons.h"
#include "coordinator/view/status_view.h"

namespace parallax {
namespace {

constexpr int kStudiesShown = 50;
constexpr int kStudiesAtOnce = 1000;
constexpr double kRateWindow_s = 600;
constexpr double kSampleEvery_s = 10;
// Many watchers cost as much as a few.
constexpr double kSnapshotAge_s = 0.5;

}  // namespace

StatusSampler::StatusSampler(std::string store_uri, Clock& clock, JobQueue& queue,
                             const CoordinatorServer& server, std::function<FarmSpace()> space)
    : store_uri_(std::move(store_uri)),
      clock_(clock),
      queue_(queue),
      server_(server),
      space_(std::move(space)),
      started_(clock.Steady()),
      rate_(kRateWindow_s) {}

StatusSampler::~StatusSampler() { Stop(); }

void StatusSampler::Start() {
  RecallHistory();
  sampling_ = std::thread([this] { Loop(); });
}

void StatusSampler::Stop() {
  {
    std::lock_guard lock(stop_mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (sampling_.joinable()) sampling_.join();
}

double StatusSampler::Uptime() const { return SecondsBetween(started_, clock_.Steady()); }

std::vector<HistorySample> StatusSampler::History() const {
  std::lock_guard lock(mu_);
  return {history_.samples().begin(), history_.samples().end()};
}

absl::StatusOr<std::shared_ptr<const StatusSnapshot>> StatusSampler::Take() {
  std::lock_guard lock(mu_);
  const SteadyTime now = clock_.Steady();
  if (snapshot_ != nullptr && SecondsBetween(snapshot_at_, now) < kSnapshotAge_s) return snapshot_;
  ASSIGN_OR_RETURN(StatusSnapshot fresh, Read());
  snapshot_ = std::make_shared<const StatusSnapshot>(std::move(fresh));
  snapshot_at_ = now;
  return snapshot_;
}

absl::StatusOr<std::vector<v1::StudyStatus>> StatusSampler::UnfinishedBefore(int64_t study) {
  std::vector<v1::StudyStatus> all;
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<v1::StudyStatus> page,
                     queue_.ListStudies(kStudiesAtOnce, study, /*only_unfinished=*/true));
    all.insert(all.end(), page.begin(), page.end());
    if (page.size() < kStudiesAtOnce) return all;
    study = page.back().study_id();
  }
}

absl::StatusOr<StatusSnapshot> StatusSampler::Read() {
  StatusSnapshot fresh;
  ASSIGN_OR_RETURN(fresh.studies, queue_.ListStudies(kStudiesShown));
  if (fresh.studies.size() == kStudiesShown) {
    ASSIGN_OR_RETURN(fresh.older_unfinished, UnfinishedBefore(fresh.studies.back().study_id()));
  }
  for (auto* studies : {&fresh.studies, &fresh.older_unfinished}) {
    for (v1::StudyStatus& study : *studies) server_.waits().AddTo(study);
  }
  fresh.version = kProgramVersion;
  fresh.epoch = queue_.epoch();
  fresh.schema_version = queue_.schema_version();
  fresh.store_uri = store_uri_;
  fresh.uptime_s = Uptime();
  fresh.now_unix_s = clock_.UnixSeconds();
  fresh.workers = server_.Workers();
  fresh.server = server_.Metrics();
  fresh.queue = queue_.Stats();
  if (space_) fresh.space = space_();
  ASSIGN_OR_RETURN(fresh.running, queue_.ListRunning());
  ASSIGN_OR_RETURN(fresh.streams, server_.Streams());
  ASSIGN_OR_RETURN(fresh.searches, server_.Searches());
  CountPublished(fresh);
  rate_.Add(fresh.uptime_s, static_cast<double>(published_));
  fresh.pairs_per_hour = 3600 * rate_.PerSecond().value_or(0);
  NoteEtas(fresh);
  NoteHistory(fresh);
  return fresh;
}

// A sum over the studies of the snapshot would fall when one is forgotten or leaves the list.
void StatusSampler::CountPublished(const StatusSnapshot& fresh) {
  std::map<int64_t, int64_t> pairs_of;
  int64_t newest = newest_study_;
  for (const auto* studies : {&fresh.studies, &fresh.older_unfinished}) {
    for (const v1::StudyStatus& study : *studies) {
      const int64_t id = study.study_id(), done = CountsOf(study).done;
      const auto known = pairs_of_.find(id);
      // An ended study that comes back into the list has published nothing meanwhile.
      const int64_t had = known != pairs_of_.end() ? known->second : id > newest_study_ ? 0 : done;
      published_ += std::max<int64_t>(0, done - had);
      pairs_of[id] = done;
      newest = std::max(newest, id);
    }
  }
  pairs_of_ = std::move(pairs_of);
  newest_study_ = newest;
}

void StatusSampler::NoteEtas(StatusSnapshot& fresh) {
  std::map<int64_t, RateEstimator> rates;
  const auto note = [&](const v1::StudyStatus& study) {
    if (study.state() != v1::STUDY_STATE_RUNNING) return;
    RateEstimator& rate = rates.emplace(study.study_id(), kRateWindow_s).first->second;
    if (const auto known = study_rates_.find(study.study_id()); known != study_rates_.end()) {
      rate = std::move(known->second);
    }
    const PairCounts pairs = CountsOf(study);
    rate.Add(fresh.uptime_s, static_cast<double>(pairs.done));
    // The time that trainings take is unknown.
    if (pairs.done >= pairs.wanted) return;
    const auto eta_s = rate.SecondsFor(static_cast<double>(pairs.wanted - pairs.done));
    if (eta_s) fresh.eta_s[study.study_id()] = *eta_s;
  };
  for (const v1::StudyStatus& study : fresh.studies) note(study);
  for (const v1::StudyStatus& study : fresh.older_unfinished) note(study);
  study_rates_ = std::move(rates);
}

void StatusSampler::NoteHistory(const StatusSnapshot& fresh) {
  HistorySample sample{.unix_s = fresh.now_unix_s, .pairs_per_hour = fresh.pairs_per_hour};
  for (const auto& [key, jobs] : fresh.queue.jobs) {
    if (key.second == "READY") sample.ready += jobs;
    if (key.second == "LEASED") sample.running += jobs;
    if (key.second == "BLOCKED" || key.second == "RETRY_WAIT") sample.waiting += jobs;
  }
  sample.workers = fresh.server.workers_connected;
  sample.slots = fresh.server.slots;
  sample.busy = fresh.server.running;
  // The rate begins anew with each start; until it is known, the chart has a gap.
  if (fresh.uptime_s < parallax::History::kEvery_s && !history_.samples().empty()) return;
  if (history_.Add(sample)) queue_.KeepSample(sample);
}

void StatusSampler::RecallHistory() {
  const absl::StatusOr<std::vector<HistorySample>> kept = queue_.ListSamples(
      clock_.UnixSeconds() - parallax::History::kEvery_s * parallax::History::kMost);
  if (!kept.ok()) LogWarning("http: no history", {{"error", kept.status()}});
  if (!kept.ok()) return;
  std::lock_guard lock(mu_);
  for (const HistorySample& sample : *kept) history_.Add(sample);
}

void StatusSampler::Loop() {
  std::unique_lock lock(stop_mu_);
  while (!stopping_) {
    lock.unlock();
    const absl::Status status = Take().status();
    if (!status.ok()) LogWarning("http: no snapshot", {{"error", status}});
    lock.lock();
    stop_.wait_for(lock, std::chrono::duration<double>(kSampleEvery_s),
                   [this] { return stopping_; });
  }
}

}  // namespace parallax
