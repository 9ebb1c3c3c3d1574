#include "coordinator/client/views/table_options.h"

#include "common/config/training_plan.h"

namespace parallax::client {

TableOptions TableOptionsOf(const v1::StudySpec& study) {
  TableOptions options;
  options.baseline = study.evaluate().reference();
  options.weigh_groups = study.evaluate().weigh_groups();
  options.decide_by_log = study.evaluate().decides() == "log";
  for (const v1::Mixture& set : TrainingSetsOf(study)) options.variant_order.push_back(set.name());
  if (options.baseline.empty() && !options.variant_order.empty()) {
    options.baseline = options.variant_order.front();
  }
  return options;
}

absl::StatusOr<ResultTable> MakeStudyTable(const v1::StudySpec& study,
                                           const std::vector<Evaluation>& scores) {
  TableOptions options = TableOptionsOf(study);
  absl::StatusOr<ResultTable> table = MakeTable(scores, options);
  if (!absl::IsInvalidArgument(table.status())) return table;
  options.baseline.clear();  // The reference has no scores yet.
  return MakeTable(scores, options);
}

}  // namespace parallax::client
