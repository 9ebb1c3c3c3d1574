// The report of `run` at its end. Pure functions, except that PrintRunReport writes to the
// terminal.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"
#include "parallax/v1/service.pb.h"

namespace parallax::client {

struct RunReport {
  v1::StudyStatus study;
  std::string out_dir;
  int64_t pairs_rendered = 0;  // By this run; earlier runs made the others.
  int64_t frames_in_dataset = 0;
  double elapsed_s = 0;
  double core_seconds = 0;  // CPU time of all processes of this run.
  int worker_crashes = 0;
  std::string contact_sheet;  // Empty: none was drawn.
  std::string histograms;
  double warp_median_difference = -1;
  int trainings = 0, evaluations = 0;  // Numbers in the folder.
  std::set<std::string> score_files;   // See StudyResults.
  std::vector<std::string> set_aside;  // Folders that the changed study no longer asks for.
  std::string table;                   // Text of table.txt; empty: there are no scores.
};

void PrintRunReport(const Terminal& terminal, const RunReport& report);
nlohmann::ordered_json RunReportJson(const RunReport& report);

}  // namespace parallax::client
