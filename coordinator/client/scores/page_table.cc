#include "coordinator/client/scores/page_table.h"

#include <nlohmann/json.hpp>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/client/scores/result_label.h"
#include "coordinator/client/views/table_options.h"
#include "coordinator/queue/job_queue.h"
#include "worker/evaluate/score_table.h"

namespace parallax {
namespace {

constexpr int kResultsAtOnce = 1000;

}  // namespace

absl::StatusOr<std::vector<Evaluation>> StudyScores(JobQueue& queue, const Store& store,
                                                    const v1::StudyStatus& study) {
  std::vector<Evaluation> scores;
  v1::ListResultsRequest asked;
  asked.set_study_id(study.study_id());
  asked.set_limit(kResultsAtOnce);
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<v1::JobResult> results, queue.ListResults(asked));
    if (results.empty()) return scores;
    for (const v1::JobResult& result : results) {
      asked.set_cursor(result.cursor());
      const auto name = client::ParseResultLabel(result.label());
      if (!name || name->benchmark.empty() || name->checkpoint < name->checkpoints) continue;
      ASSIGN_OR_RETURN(const std::string text, store.Get(result.path() + "/scores.jsonl"));
      ASSIGN_OR_RETURN(Evaluation one, DecodeEvaluation(text));
      client::NameRun(*name, study.spec().train().trainer(), one.run);
      scores.push_back(std::move(one));
    }
  }
}

absl::StatusOr<std::string> PageTable(JobQueue& queue, const Store& store, int64_t id) {
  ASSIGN_OR_RETURN(const v1::StudyStatus study, queue.GetStudy(StudyId{id}));
  ASSIGN_OR_RETURN(const std::vector<Evaluation> scores, StudyScores(queue, store, study));
  nlohmann::ordered_json json = {{"text", nullptr}, {"table", nullptr}};
  if (!scores.empty()) {
    ASSIGN_OR_RETURN(const ResultTable table, client::MakeStudyTable(study.spec(), scores));
    ASSIGN_OR_RETURN(json["text"], FormatTable(table, "text"));
    ASSIGN_OR_RETURN(const std::string text, FormatTable(table, "json"));
    json["table"] = nlohmann::ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace parallax
