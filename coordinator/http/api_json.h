// Makes the JSON of /api/v1 from the queue's replies. Names are those of the glossary. Times are
// Unix seconds. States of studies are in lower case ("running"); states of jobs are spelled as in
// the queue ("READY"). Numbers that JavaScript can't hold are strings.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "coordinator/http/status_snapshot.h"
#include "coordinator/queue/reads/farm_history.h"
#include "coordinator/queue/reads/page_reader.h"

namespace parallax {

using Json = nlohmann::ordered_json;

// Returns the JSON as one line; bytes that are not UTF-8 are replaced.
std::string JsonText(const Json& json);

// Return the farm's status, its history of the last day, and its workers.
Json FarmJson(const StatusSnapshot& snapshot);
Json HistoryJson(const std::vector<HistorySample>& samples);
Json WorkersJson(const std::vector<v1::WorkerStatus>& workers);

// Return the JSON of a study as coordinator/view has it, as a line of the list and with its
// variants and causes of problems. `eta_s` is the time until it ends in seconds; below 0 it is
// unknown.
Json StudyRowJson(const v1::StudyStatus& study, double eta_s);
Json StudyPageJson(const v1::StudyStatus& study, double eta_s,
                   const std::vector<ProblemCause>& causes);
Json UsersJson(const std::vector<v1::UserStatus>& users);
Json JobLineJson(const v1::JobStatus& job);
Json JobJson(const JobDetail& job);
Json PairLineJson(const PublishedPair& pair);
Json PairJson(const PublishedPair& pair, const PageReader::Neighbours& neighbours);

// Returns for each benchmark a table of the last checkpoints, the best mean first, and curves over
// all checkpoints.
Json ScoresJson(const std::vector<StudyScore>& scores);

}  // namespace parallax
