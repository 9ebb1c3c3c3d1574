#include "coordinator/view/status_view.h"

#include <absl/strings/ascii.h>
#include <absl/strings/strip.h>
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "coordinator/queue/job_kind.h"
#include "coordinator/view/json_list.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

Json CountsJson(const PairCounts& counts) {
  return {{"pairs_wanted", counts.wanted},         {"pairs_done", counts.done},
          {"frames_reused", counts.reused},        {"solves_done", counts.solves_done},
          {"solves_reused", counts.solves_reused}, {"layouts_reused", counts.layouts_reused},
          {"scenes_rejected", counts.rejected},    {"jobs_failed", counts.failed}};
}

// "solve_jobs": {"ready": 2}, for each kind of this release and each that the coordinator has.
void AddJobs(const v1::VariantStatus& variant, Json& json) {
  for (const std::string& kind : KindRegistry::Builtin().Names()) {
    json[kind + "_jobs"] = Json::object();
  }
  for (const v1::JobCount& count : variant.jobs()) {
    json[count.kind() + "_jobs"][absl::AsciiStrToLower(count.state())] = count.jobs();
  }
}

Json ProblemJson(const v1::JobProblem& problem) {
  const bool has_scene = problem.job_id() != 0 && problem.scene() != kNoScene;
  return {{"job_id", problem.job_id()},
          {"state", absl::AsciiStrToLower(problem.state())},
          {"scene", has_scene ? Json(problem.scene()) : Json(nullptr)},
          {"error", problem.error()}};
}

std::string WaitsFor(const v1::StreamStatus& stream) {
  if (stream.closed()) return "the removal of its pairs";
  if (!stream.needs().empty()) return stream.needs();
  if (stream.chunks_made() < stream.chunks_begun()) {
    return fmt::format("pairs of chunk {}", stream.chunks_made());
  }
  return stream.consumers().empty() ? "a consumer" : "its consumers";
}

}  // namespace

PairCounts CountsOf(const v1::VariantStatus& variant) {
  const KindRegistry& kinds = KindRegistry::Builtin();
  return {.wanted = variant.pairs_wanted(),
          .done = variant.pairs_done(),
          .reused = variant.frames_reused(),
          .rejected = variant.scenes_rejected(),
          .failed = JobsInState(variant, "FAILED") + JobsInState(variant, "QUARANTINED"),
          .solves_done = JobsInState(variant, "SUCCEEDED", kinds[kinds.begins_scenes()].name()),
          .solves_reused = variant.solves_reused(),
          .layouts_reused = variant.layouts_reused()};
}

PairCounts CountsOf(const v1::StudyStatus& study) {
  PairCounts sum;
  for (const v1::VariantStatus& variant : study.variants()) {
    const PairCounts counts = CountsOf(variant);
    for (const auto field : {&PairCounts::wanted, &PairCounts::done, &PairCounts::reused,
                             &PairCounts::rejected, &PairCounts::failed, &PairCounts::solves_done,
                             &PairCounts::solves_reused, &PairCounts::layouts_reused}) {
      sum.*field += counts.*field;
    }
  }
  return sum;
}

bool IsFinished(v1::StudyState state) {
  return state == v1::STUDY_STATE_SUCCEEDED || state == v1::STUDY_STATE_CANCELLED ||
         state == v1::STUDY_STATE_FAILED;
}

std::string StateName(v1::StudyState state) {
  return absl::AsciiStrToLower(absl::StripPrefix(v1::StudyState_Name(state), "STUDY_STATE_"));
}

Json WaitingJson(const google::protobuf::RepeatedPtrField<v1::WaitingJobs>& waiting) {
  Json list = Json::array();
  for (const v1::WaitingJobs& jobs : waiting) {
    list.push_back({{"kind", jobs.kind()},
                    {"jobs", jobs.jobs()},
                    {"reason", jobs.reason()},
                    {"text", jobs.text()}});
  }
  return list;
}

Json StudyLineJson(const v1::StudyStatus& study) {
  Json json = {{"study_id", study.study_id()},
               {"name", study.name()},
               {"state", StateName(study.state())},
               {"user", study.user()},
               {"priority", study.priority()},
               {"running", JobsInState(study, "LEASED")},
               {"max_running", study.max_running()},
               {"at_limit", study.at_limit()},
               {"held_jobs", study.held_jobs()},
               {"waiting", WaitingJson(study.waiting())},
               {"submitted_unix_s", study.submitted_unix_s()},
               {"finished_unix_s", study.finished_unix_s()},
               {"variant_count", study.variants_size()}};
  json.update(CountsJson(CountsOf(study)));
  return json;
}

Json StudyJson(const v1::StudyStatus& study) {
  Json json = StudyLineJson(study);
  Json& variants = json["variants"] = Json::array();
  for (const v1::VariantStatus& variant : study.variants()) {
    Json entry = {{"name", variant.name()}};
    entry.update(CountsJson(CountsOf(variant)));
    AddJobs(variant, entry);
    entry["problems"] = JsonList(variant.problems(), ProblemJson);
    variants.push_back(std::move(entry));
  }
  Json& comments = json["comments"] = Json::array();
  for (const v1::StudyComment& comment : study.comments()) {
    comments.push_back(
        {{"unix_s", comment.unix_s()}, {"actor", comment.actor()}, {"text", comment.text()}});
  }
  return json;
}

Json UserJson(const v1::UserStatus& user) {
  return {{"user", user.user()},
          {"running", user.running()},
          {"max_running", user.max_running()},
          {"studies", user.studies()},
          {"max_studies", user.max_studies()},
          {"waiting_pairs", user.waiting_pairs()},
          {"max_waiting_pairs", user.max_waiting_pairs()},
          {"priority", user.priority()},
          {"rule", user.rule()}};
}

Json WorkerJson(const v1::WorkerStatus& worker) {
  return {{"name", worker.name()},
          {"state", absl::AsciiStrToLower(worker.state())},
          {"kinds", std::vector<std::string>(worker.kinds().begin(), worker.kinds().end())},
          {"slots", worker.slots()},
          {"running", worker.running()},
          {"last_heard_s", worker.last_heard_s()},
          {"version", worker.version()},
          {"drained_by", worker.drained_by()}};
}

Json StreamJson(const v1::StreamStatus& stream) {
  Json consumers = Json::array();
  for (const v1::StreamConsumer& consumer : stream.consumers()) {
    consumers.push_back({{"name", consumer.name()},
                         {"rank", consumer.rank()},
                         {"ranks", consumer.ranks()},
                         {"acknowledged", consumer.acknowledged()},
                         {"heard_unix_s", consumer.heard_unix_s()}});
  }
  return {{"name", stream.name()},
          {"user", stream.user()},
          {"closed", stream.closed()},
          {"opened_unix_s", stream.opened_unix_s()},
          {"chunks_begun", stream.chunks_begun()},
          {"chunks_made", stream.chunks_made()},
          {"chunks_forgotten", stream.chunks_forgotten()},
          {"pairs_kept", stream.pairs_kept()},
          {"pairs_filtered_out", stream.pairs_filtered_out()},
          {"needs", stream.needs()},
          {"waits_for", WaitsFor(stream)},
          {"consumers", std::move(consumers)}};
}

Json AuditEntryJson(const v1::AuditEntry& entry) {
  return {{"id", entry.id()},
          {"unix_s", entry.unix_s()},
          {"actor", entry.actor()},
          {"action", entry.action()},
          {"study_id", entry.study_id() == 0 ? Json(nullptr) : Json(entry.study_id())},
          {"detail", entry.detail()}};
}

}  // namespace parallax
