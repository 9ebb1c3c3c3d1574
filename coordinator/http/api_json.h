// The JSON of /api/v1, from what the queue tells. Names are those of the glossary, times are Unix
// seconds, states lower-case words of studies ("running") and the words of the queue for jobs
// ("READY"). Numbers that JavaScript can't hold are strings.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "coordinator/http/status_snapshot.h"
#include "coordinator/queue/farm_history.h"
#include "coordinator/queue/page_reader.h"

namespace parallax {

using Json = nlohmann::ordered_json;

// One line; bytes that are no UTF-8 are replaced.
std::string JsonText(const Json& json);

Json FarmJson(const StatusSnapshot& snapshot);
Json HistoryJson(const std::vector<HistorySample>& samples);
Json WorkersJson(const std::vector<v1::WorkerStatus>& workers);

// `eta_s` < 0: unknown.
Json StudyLineJson(const v1::StudyStatus& study, double eta_s);
Json StudyJson(const v1::StudyStatus& study, double eta_s, const std::vector<ProblemCause>& causes);
Json UsersJson(const std::vector<v1::UserStatus>& users);
Json JobLineJson(const v1::JobStatus& job);
Json JobJson(const JobDetail& job);
Json PairLineJson(const PublishedPair& pair);
Json PairJson(const PublishedPair& pair, const PageReader::Neighbours& neighbours);

// Rows of the last checkpoints by benchmark, best mean first, and curves over all checkpoints.
Json ScoresJson(const std::vector<StudyScore>& scores);

}  // namespace parallax
