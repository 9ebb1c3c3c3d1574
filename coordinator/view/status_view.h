// The view of a study and of its farm that text, `--json`, the page, metrics and the report of
// `run` share: counters, words of states, and JSON. Names and meanings are documented in
// coordinator/client/README.md. Times are Unix seconds. Pure functions.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "coordinator/study/job_counts.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// The counters that are shown of a variant, or their sums over a study.
struct PairCounts {
  int64_t wanted = 0;
  int64_t done = 0;
  int64_t reused = 0;
  int64_t rejected = 0;  // Scenes.
  int64_t failed = 0;    // Jobs that failed or were quarantined.
  int64_t solves_done = 0;
  int64_t solves_reused = 0;
  int64_t layouts_reused = 0;
};
// Return the counters of one variant, or of all variants together.
PairCounts CountsOf(const v1::VariantStatus& variant);
PairCounts CountsOf(const v1::StudyStatus& study);

// Returns whether a study in this state has ended.
bool IsFinished(v1::StudyState state);
std::string StateName(v1::StudyState state);  // "running"

// Returns the study without its variants, as a line of a list; `variant_count` has their number.
nlohmann::ordered_json StudyLineJson(const v1::StudyStatus& study);
// Returns the line, the variants, and their problems.
nlohmann::ordered_json StudyJson(const v1::StudyStatus& study);
// Returns an array with an object {kind, jobs, reason, text} each.
nlohmann::ordered_json WaitingJson(
    const google::protobuf::RepeatedPtrField<v1::WaitingJobs>& waiting);
nlohmann::ordered_json UserJson(const v1::UserStatus& user);
nlohmann::ordered_json WorkerJson(const v1::WorkerStatus& worker);
// Returns the stream with its consumers, and in `waits_for` a phrase for what it waits for.
nlohmann::ordered_json StreamJson(const v1::StreamStatus& stream);
nlohmann::ordered_json AuditEntryJson(const v1::AuditEntry& entry);

}  // namespace parallax
