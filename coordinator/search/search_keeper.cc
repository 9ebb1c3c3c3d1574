#include "coordinator/search/search_keeper.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "common/base/names.h"
#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/config/check/limit_rules.h"
#include "common/config/check/notify_check.h"
#include "common/config/training_plan.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/search/halving.h"
#include "coordinator/search/importance.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/sampler_talk.h"
#include "coordinator/search/trial_space.h"
#include "coordinator/study/keys.h"
#include "coordinator/study/study_needs.h"

namespace parallax {
namespace {

constexpr double kAskAgain_s = 60;  // After a sampler has failed.

// Returns all studies of a search.
std::vector<int64_t> StudiesOf(const v1::SearchRecord& record) {
  std::vector<int64_t> studies(record.former_studies().begin(), record.former_studies().end());
  studies.insert(studies.end(), record.rung_studies().begin(), record.rung_studies().end());
  if (record.confirm_study() != 0) studies.push_back(record.confirm_study());
  return studies;
}

// Returns what the keys of all studies of a search begin with. The time tells them from those of an
// earlier search of the name.
std::string KeysOf(const v1::SearchRecord& record) {
  return fmt::format("search/{}/{:.6f}/", record.study().name(), record.opened_unix_s());
}
// Returns the key of its next study. Its number tells it from all earlier ones.
std::string NextKeyOf(const v1::SearchRecord& record) {
  return fmt::format("{}{}", KeysOf(record), StudiesOf(record).size());
}

// Returns the study without what may change while a search goes on.
std::string LastingPart(v1::StudySpec study) {
  study.clear_source_yaml();
  study.clear_notify();
  study.mutable_search()->clear_trials();
  study.mutable_search()->clear_core_hours();
  return DeterministicBytes(study);
}

// Returns how many trials a sampler is asked for.
int MissingTrials(const v1::SearchRecord& record) {
  const v1::StudySpec& search = record.study();
  return std::min(search.search().trials() + 1 - record.trials_size(), TrialsAtOnce(search));
}

bool IsOver(const v1::SearchRecord& record) {
  return !record.outcome().empty() ||
         (!record.over().empty() && !SearchOf(record.study()).confirm().enabled());
}

// Moves the studies that are not continued, and what came of them, out of the way.
void DropConfirmation(v1::SearchRecord& record) {
  if (record.confirm_study() != 0) record.add_former_studies(record.confirm_study());
  record.clear_confirm_study();
  record.clear_confirmation();
  record.clear_outcome();
  record.clear_over();
}
void DropRunningRung(v1::SearchRecord& record) {
  if (record.rung_studies_size() == EndedRungs(record)) return;
  record.add_former_studies(*record.rung_studies().rbegin());
  record.mutable_rung_studies()->RemoveLast();
}

// Returns the record with the study's trials and budget. `trials` are those at Sobol's points;
// those that a sampler has proposed stay.
v1::SearchRecord Continued(const v1::SearchRecord& before, const v1::StudySpec& study,
                           const std::vector<v1::SearchTrial>& trials) {
  v1::SearchRecord record = before;
  const bool was_stopped = !record.stopped().empty();
  const bool more_trials = study.search().trials() > record.study().search().trials();
  const bool other_budget = EndedRungs(record) < SearchOf(study).rungs_size() &&
                            record.study().search().core_hours() != study.search().core_hours();
  *record.mutable_study() = study;
  record.clear_stopped();
  if (more_trials || other_budget || was_stopped) DropConfirmation(record);
  if (was_stopped) DropRunningRung(record);
  if (!more_trials) return record;
  for (const int64_t id : record.rung_studies()) record.add_former_studies(id);
  record.clear_rung_studies();
  record.clear_next_core_hours();
  for (v1::SearchTrial& trial : *record.mutable_trials()) {
    trial.clear_scores();
    trial.clear_ended();
  }
  for (size_t i = static_cast<size_t>(record.trials_size()); i < trials.size(); ++i) {
    *record.add_trials() = trials[i];
  }
  return record;
}

}  // namespace

absl::StatusOr<v1::SearchStatus> SearchKeeper::Open(const v1::StudySpec& given,
                                                    std::string_view actor) {
  RETURN_IF_ERROR(CheckSearch(given));
  if (scorer_ == nullptr) {
    return FailedPrecondition("this coordinator reads no scores, so it can't search");
  }
  v1::StudySpec study = given;
  const v1::NotifySpec notify = TakeNotify(&study);
  if (notify.has_url()) *study.mutable_notify() = notify;
  *study.mutable_search() = SearchOf(given);
  const std::string& sampler = study.search().sampler();
  if (sampler != kSobolSampler && samplers_.count(sampler) == 0) {
    std::string known = kSobolSampler;
    for (const auto& [name, unused] : samplers_) known += ", " + name;
    return InvalidArgument("study '{}': search.sampler {} is not known here; known are: {}",
                           study.name(), Quoted(sampler), known);
  }
  ASSIGN_OR_RETURN(const std::vector<v1::SearchTrial> trials,
                   ProposeTrials(study, TrialsAtOnce(study)));
  RETURN_IF_ERROR(ConfirmStudy(study, trials.back()).status());
  std::lock_guard lock(mu_);
  RETURN_IF_ERROR(Load());
  const auto found = entries_.find(study.name());
  v1::SearchRecord record;
  if (found == entries_.end()) {
    *record.mutable_study() = study;
    record.set_actor(std::string(actor));
    record.set_opened_unix_s(clock_.UnixSeconds());
    record.mutable_trials()->Assign(trials.begin(), trials.end());
  } else {
    const v1::SearchRecord& before = found->second.record;
    // A study that was submitted before a crash, and not yet entered, is entered first.
    RETURN_IF_ERROR(Step(found->second));
    if (before.forget()) {
      return AlreadyExists("search '{}' is being removed; try again soon", study.name());
    }
    if (LastingPart(before.study()) != LastingPart(study)) {
      return AlreadyExists(
          "search '{}' is there already, with other settings than trials and core_hours: give this "
          "study another name, or `parallax search {} --forget`",
          study.name(), study.name());
    }
    if (study.search().trials() < before.study().search().trials()) {
      return AlreadyExists("search '{}' has {} trials already, wanted at least as many, got {}",
                           study.name(), before.study().search().trials(), study.search().trials());
    }
    record = Continued(before, study, trials);
  }
  const bool is_changed = found == entries_.end() ||
                          DeterministicBytes(found->second.record) != DeterministicBytes(record);
  if (is_changed) RETURN_IF_ERROR(Begin(std::move(record)).status());
  Search& search = entries_[study.name()];
  RETURN_IF_ERROR(Step(search));
  return StatusOf(search, /*whole=*/true);
}

absl::StatusOr<v1::SearchStatus> SearchKeeper::Stop(const std::string& name,
                                                    const std::string& reason, bool forget) {
  std::lock_guard lock(mu_);
  ASSIGN_OR_RETURN(Search * search, Find(name));
  RETURN_IF_ERROR(Step(*search));  // As in Open.
  v1::SearchRecord record = search->record;
  if (record.stopped().empty() && !IsOver(record)) {
    record.set_stopped(reason.empty() ? "stopped" : reason);
  }
  if (forget) record.set_forget(true);
  search->asking.reset();
  // Its studies first: nobody looks again at those of a search that is kept as stopped. One that is
  // not yet says that they were cancelled.
  RETURN_IF_ERROR(End(*search).status());
  RETURN_IF_ERROR(Keep(*search, std::move(record)));
  if (search->record.forget()) RETURN_IF_ERROR(End(*search).status());
  return StatusOf(*search, /*whole=*/true);
}

absl::StatusOr<std::vector<v1::SearchStatus>> SearchKeeper::ListWhole() {
  std::lock_guard lock(mu_);
  RETURN_IF_ERROR(Load());
  std::vector<v1::SearchStatus> all;
  for (auto& entry : entries_) all.push_back(StatusOf(entry.second, /*whole=*/true));
  return all;
}

absl::StatusOr<bool> SearchKeeper::End(Search& search) {
  bool is_gone = true;
  // By their keys: the record lacks a study if a coordinator died between its submission and Keep.
  ASSIGN_OR_RETURN(const std::vector<int64_t> studies,
                   queue_.ListSubmitted(KeysOf(search.record), search.record.actor()));
  for (const int64_t id : studies) {
    const StudyId study{id};
    if (search.record.forget()) {
      ASSIGN_OR_RETURN(
          const bool study_is_gone,
          queue_.CancelAndForget(study, "its search is removed", search.record.actor()));
      is_gone = is_gone && study_is_gone;
      continue;
    }
    const absl::Status cancelled =
        queue_.Cancel(study, "its search was stopped", search.record.actor());
    if (!cancelled.ok() && !absl::IsFailedPrecondition(cancelled) && !absl::IsNotFound(cancelled)) {
      return cancelled;
    }
  }
  return search.record.forget() && is_gone;
}

absl::StatusOr<bool> SearchKeeper::Advance(Search& search) {
  if (search.record.forget()) return End(search);
  RETURN_IF_ERROR(Step(search, /*may_ask=*/true));
  return false;
}

absl::Status SearchKeeper::Tick() {
  std::map<std::string, ScoreQuery> wanted;
  {
    std::lock_guard lock(mu_);
    RETURN_IF_ERROR(AdvanceAll());
    for (const auto& [name, search] : entries_) {
      if (search.wanted) wanted[name] = *search.wanted;
    }
  }
  for (const auto& [name, query] : wanted) {
    // Without the lock: a store may be slow, and people look meanwhile.
    absl::StatusOr<std::vector<TrialScore>> scores = scorer_(query);
    std::lock_guard lock(mu_);
    const auto entry = entries_.find(name);
    // Somebody may have stopped it, or tried failed jobs again.
    if (entry == entries_.end() || entry->second.wanted != query) continue;
    entry->second.scores = std::move(scores);
    const absl::Status status = Step(entry->second, /*may_ask=*/true);
    entry->second.scores.reset();
    RETURN_IF_ERROR(status);
  }
  return absl::OkStatus();
}

absl::Status SearchKeeper::Step(Search& search, bool may_ask) {
  search.needs.clear();
  search.waits_for.clear();
  search.has_failed = false;
  search.wanted.reset();
  const v1::SearchRecord& record = search.record;
  if (scorer_ == nullptr || !record.stopped().empty() || IsOver(record)) return absl::OkStatus();
  if (EndedRungs(record) < record.rung_studies_size()) return LookAtRung(search, may_ask);
  if (!record.over().empty()) return Confirm(search);
  const std::string over = WhyOver(record);
  if (over.empty()) return BeginRung(search);
  v1::SearchRecord ended = record;
  ended.set_over(over);
  return Keep(search, std::move(ended));
}

absl::StatusOr<std::optional<int64_t>> SearchKeeper::Submit(
    Search& search, const absl::StatusOr<v1::StudySpec>& study) {
  absl::Status refused = study.status();
  if (study.ok()) {
    v1::SubmitRequest request;
    request.set_idempotency_key(NextKeyOf(search.record));
    *request.mutable_study() = *study;
    const absl::StatusOr<v1::SubmitReply> reply = queue_.Submit(request, search.record.actor());
    if (reply.ok()) return reply->study_id();
    refused = reply.status();
  }
  search.needs = fmt::format("its next study can't be submitted: {}", ToStd(refused.message()));
  return std::nullopt;
}

absl::Status SearchKeeper::BeginRung(Search& search) {
  ASSIGN_OR_RETURN(const std::optional<int64_t> id,
                   Submit(search, RungStudy(search.study(), EndedRungs(search.record),
                                            Entrants(search.record))));
  if (!id) return absl::OkStatus();
  v1::SearchRecord record = search.record;
  record.add_rung_studies(*id);
  return Keep(search, std::move(record));
}

absl::StatusOr<std::optional<SearchKeeper::Ended>> SearchKeeper::LookAt(Search& search, int64_t id,
                                                                        const std::string& what) {
  const std::string again =
      fmt::format("`parallax search {} --stop`, and begin it again", search.name());
  const absl::StatusOr<v1::StudyStatus> study = queue_.GetStudy(StudyId{id});
  if (absl::IsNotFound(study.status())) {
    search.needs =
        fmt::format("{} (study {}) was forgotten before it was scored: {}", what, id, again);
    return std::nullopt;
  }
  RETURN_IF_ERROR(study.status());
  if (study->state() == v1::STUDY_STATE_SUCCEEDED) return Ended();
  search.needs = NeedsOf(*study, what, again);
  search.has_failed = study->state() == v1::STUDY_STATE_FAILED;
  if (search.needs.empty()) search.waits_for = fmt::format("{} (study {}) is being made", what, id);
  if (!search.has_failed) return std::nullopt;
  // Settings that no scene can have, or whose jobs fail for good, end a trial, not the search. But
  // where no trial is left, as in a confirmation, the farm is more likely to blame.
  Ended ended;
  size_t trials = 0, jobs_failed = 0;
  for (const v1::VariantStatus& variant : study->variants()) {
    const bool is_trial = variant.name() != kDefaultTrial && variant.name() != kHeldoutName;
    trials += is_trial ? 1 : 0;
    if (variant.problems().empty()) continue;
    const v1::JobProblem& problem = variant.problems(0);
    const bool gave_up = problem.state() == "GAVE_UP";
    if (!is_trial) return std::nullopt;
    jobs_failed += gave_up ? 0 : 1;
    ended.failed[variant.name()] = problem.error();
  }
  if (ended.failed.empty() || (jobs_failed > 0 && ended.failed.size() == trials)) {
    return std::nullopt;
  }
  search.needs.clear();
  search.has_failed = false;
  return ended;
}

absl::StatusOr<std::optional<std::vector<TrialScore>>> SearchKeeper::Score(
    Search& search, int64_t study, const std::vector<std::string>& benchmarks, const Ended& ended) {
  ASSIGN_OR_RETURN(const StudyCosts costs, queue_.CostsOf(StudyId{study}));
  ScoreQuery query{.study = study,
                   .benchmarks = benchmarks,
                   .weigh_groups = search.study().evaluate().weigh_groups(),
                   .decide_by_log = search.study().evaluate().decides() == "log"};
  for (const auto& [variant, why] : ended.failed) query.without.insert(variant);
  std::map<std::string, double> core_s;
  for (const auto& [variant, pairs] : costs.variants) {
    core_s[variant] = pairs.core_s / static_cast<double>(std::max<int64_t>(1, pairs.pairs));
    query.points[variant] = search.study().search().points_per_core_s() * core_s[variant];
  }
  if (!search.scores) {
    search.wanted = std::move(query);
    search.needs = search.scores_problem;  // It is tried again, and not solved yet.
    if (search.needs.empty()) {
      search.waits_for = fmt::format("the scores of study {} are read", study);
    }
    return std::nullopt;
  }
  search.scores_problem.clear();
  if (!search.scores->ok()) {
    search.scores_problem = fmt::format("the scores of study {} can't be read: {}", study,
                                        ToStd(search.scores->status().message()));
    search.needs = search.scores_problem;
    return std::nullopt;
  }
  std::vector<TrialScore> scores = **search.scores;
  for (TrialScore& score : scores) score.core_s_per_pair = core_s[score.variant];
  return scores;
}

absl::StatusOr<double> SearchKeeper::CoreHoursOf(const v1::SearchRecord& record) {
  double core_s = 0;
  for (const int64_t study : StudiesOf(record)) {
    ASSIGN_OR_RETURN(const StudyCosts costs, queue_.CostsOf(StudyId{study}));
    core_s += costs.fresh_core_s;
  }
  return core_s / kSecondsPerHour;
}

absl::Status SearchKeeper::Ask(Search& search, const std::vector<TrialScore>& scores,
                               const std::map<std::string, std::string>& failed) {
  const v1::SearchSpec& spec = search.study().search();
  const auto sampler = samplers_.find(spec.sampler());
  if (sampler == samplers_.end()) {
    search.needs = fmt::format("sampler {} is not known here any more", Quoted(spec.sampler()));
    return absl::OkStatus();
  }
  auto run = SamplerRun::Start(sampler->second,
                               AskText(search.record, scores, failed, MissingTrials(search.record)),
                               clock_);
  if (!run.ok()) return run.status();
  search.asking = *std::move(run);
  search.waits_for = fmt::format("sampler {} is asked for trials", spec.sampler());
  return absl::OkStatus();
}

absl::Status SearchKeeper::TakeAnswer(Search& search) {
  const v1::SearchSpec& spec = search.study().search();
  search.waits_for = fmt::format("sampler {} is asked for trials", spec.sampler());
  const std::optional<absl::StatusOr<std::string>> answer = search.asking->Poll();
  if (!answer) return absl::OkStatus();
  search.asking.reset();
  search.waits_for.clear();
  std::vector<v1::SearchTrial> trials;
  absl::Status problem = answer->status();
  if (answer->ok()) {
    auto answered = AnsweredTrials(search.record, **answer, MissingTrials(search.record));
    problem = WithContext(answered.status(), "sampler " + spec.sampler());
    if (answered.ok()) trials = *std::move(answered);
  }
  if (!problem.ok()) {
    search.sampler_problem =
        fmt::format("{}; it is asked again in {} s", ToStd(problem.message()), kAskAgain_s);
    search.ask_after = SecondsAfter(clock_.Steady(), kAskAgain_s);
    search.needs = search.sampler_problem;
    return absl::OkStatus();
  }
  search.sampler_problem.clear();
  v1::SearchRecord record = search.record;
  if (trials.empty()) {
    // It repeats itself, or the space has no more: the search goes on with the trials it has.
    LogWarning("sampler has no new trials",
               {{"search", search.name()}, {"sampler", spec.sampler()}});
    record.mutable_study()->mutable_search()->set_trials(record.trials_size() - 1);
    return Keep(search, std::move(record));
  }
  DropRunningRung(record);
  for (v1::SearchTrial& trial : trials) *record.add_trials() = std::move(trial);
  return Keep(search, std::move(record));
}

absl::Status SearchKeeper::LookAtRung(Search& search, bool may_ask) {
  const int rung = EndedRungs(search.record);
  const bool lacks_trials = rung == 0 && search.study().search().sampler() != kSobolSampler &&
                            search.record.trials_size() <= search.study().search().trials();
  if (lacks_trials && search.asking != nullptr) return TakeAnswer(search);
  if (lacks_trials && clock_.Steady() < search.ask_after) {
    search.needs = search.sampler_problem;
    return absl::OkStatus();
  }
  const int64_t study = search.record.rung_studies(rung);
  ASSIGN_OR_RETURN(const std::optional<Ended> ended,
                   LookAt(search, study, fmt::format("rung {}", rung + 1)));
  if (!ended) return absl::OkStatus();
  ASSIGN_OR_RETURN(const auto scores,
                   Score(search, study, SearchedBenchmarks(search.study()), *ended));
  if (!scores) return absl::OkStatus();
  ASSIGN_OR_RETURN(const double core_hours, CoreHoursOf(search.record));
  const double budget = search.study().search().core_hours();
  if (lacks_trials && (budget <= 0 || core_hours < budget)) {
    return may_ask ? Ask(search, *scores, ended->failed) : absl::OkStatus();
  }
  v1::SearchRecord record = search.record;
  if (const absl::Status status = EndRung(*scores, ended->failed, record); !status.ok()) {
    search.needs = ToStd(status.message());
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const StudyCosts costs, queue_.CostsOf(StudyId{study}));
  record.set_next_core_hours(NextCoreHours(record, costs));
  record.set_core_hours(std::max(record.core_hours(), core_hours));
  return Keep(search, std::move(record));
}

absl::Status SearchKeeper::Confirm(Search& search) {
  v1::SearchRecord record = search.record;
  const int best = BestOf(record).value_or(0);
  if (best == 0) {
    record.set_outcome("not confirmed");
    return Keep(search, std::move(record));
  }
  if (record.confirm_study() == 0) {
    ASSIGN_OR_RETURN(const std::optional<int64_t> id,
                     Submit(search, ConfirmStudy(search.study(), record.trials(best))));
    if (!id) return absl::OkStatus();
    record.set_confirm_study(*id);
    return Keep(search, std::move(record));
  }
  const int64_t study = record.confirm_study();
  ASSIGN_OR_RETURN(const std::optional<Ended> ended, LookAt(search, study, "the confirmation"));
  if (!ended) return absl::OkStatus();
  if (ended->failed.empty()) {
    ASSIGN_OR_RETURN(const auto scores,
                     Score(search, study, ConfirmedBenchmarks(search.study()), *ended));
    if (!scores) return absl::OkStatus();
    for (const TrialScore& score : *scores) {
      if (score.variant != TrialName(best)) continue;
      *record.mutable_confirmation() = ScoreOf(score, EndedRungs(record) - 1);
    }
  }
  record.set_outcome(record.confirmation().verdict() == "better" ? "confirmed" : "not confirmed");
  ASSIGN_OR_RETURN(const double core_hours, CoreHoursOf(record));
  record.set_core_hours(std::max(record.core_hours(), core_hours));
  return Keep(search, std::move(record));
}

v1::SearchStatus SearchKeeper::StatusOf(Search& search, bool whole) const {
  const v1::SearchRecord& record = search.record;
  v1::SearchStatus status;
  status.set_name(search.name());
  status.set_user(UserOfActor(record.actor()));
  status.set_state(!record.stopped().empty() || record.forget() ? "stopped"
                   : IsOver(record)                             ? "ended"
                   : search.has_failed                          ? "failed"
                   : record.over().empty()                      ? "running"
                                                                : "confirming");
  status.set_opened_unix_s(record.opened_unix_s());
  const int rungs = SearchOf(search.study()).rungs_size();
  status.set_rung(std::min(EndedRungs(record), rungs - 1));
  status.set_rungs(rungs);
  *status.mutable_studies() = record.rung_studies();
  if (record.confirm_study() != 0) status.add_studies(record.confirm_study());
  status.set_core_hours(record.core_hours());
  status.set_needs(search.needs);
  status.set_waits_for(!search.waits_for.empty() ? search.waits_for : record.over());
  if (!record.stopped().empty()) status.set_waits_for(record.stopped());
  if (const std::optional<int> best = BestOf(record)) status.set_best(*best);
  if (record.has_confirmation()) *status.mutable_confirmation() = record.confirmation();
  status.set_outcome(record.outcome());
  if (!whole) return status;
  *status.mutable_trials() = record.trials();
  if (EndedRungs(record) > 0) {
    if (!search.importances) {
      search.importances = ImportancesOf(search.study().search().space(), OutcomesOf(record));
    }
    status.mutable_importances()->Assign(search.importances->begin(), search.importances->end());
  }
  *status.mutable_study() = search.study();
  status.mutable_study()->clear_notify();
  return status;
}

}  // namespace parallax
