// Runs commands of `parallax` in this process against a FakeCoordinator, with a folder for files.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/client/exit_code.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"

namespace parallax::client {

// A running study of two variants: one has a failed job, the other reused work.
inline v1::StudyStatus Baseline(int64_t id = 3) {
  v1::StudyStatus study;
  study.set_study_id(id);
  study.set_name("baseline");
  study.set_state(v1::STUDY_STATE_RUNNING);
  study.set_submitted_unix_s(1000000);
  v1::VariantStatus* narrow = study.add_variants();
  narrow->set_name("narrow");
  narrow->set_pairs_wanted(40);
  narrow->set_pairs_done(20);
  AddJobCount(*narrow, "solve", "SUCCEEDED", 2);
  AddJobCount(*narrow, "render", "SUCCEEDED", 1);
  AddJobCount(*narrow, "render", "FAILED", 1);
  narrow->set_scenes_rejected(1);
  v1::JobProblem* problem = narrow->add_problems();
  problem->set_job_id(17);
  problem->set_state("FAILED");
  problem->set_scene(1);
  problem->set_error("it burns\nand more");
  v1::VariantStatus* wide = study.add_variants();
  wide->set_name("wide");
  wide->set_pairs_wanted(40);
  wide->set_pairs_done(40);
  wide->set_layouts_reused(2);
  wide->set_frames_reused(5);
  return study;
}

class CommandTest : public FolderTest {
 protected:
  Outcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--coordinator", coordinator_.address()});
    return RunCommand(arguments);
  }
  nlohmann::json RunJson(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
  std::string WriteText(const std::string& name, const std::string& text) {
    std::ofstream(dir_ + "/" + name) << text;
    return dir_ + "/" + name;
  }

  FakeCoordinator coordinator_;
};

inline int Lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace parallax::client
