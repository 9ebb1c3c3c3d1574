#include "worker/dataset/export/export_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <string>

#include "worker/dataset/export/sequence_runs.h"

namespace parallax {
namespace {

// Makes a name safe for readers that find eyes and maps by replacing words in whole paths.
std::string SafeName(std::string name) {
  for (char& c : name) {
    if (std::isspace(static_cast<unsigned char>(c))) c = '-';
  }
  const std::pair<const char*, const char*> words[] = {
      {"left", "lft"},   {"right", "rgt"},     {"rgb", "col"},
      {"image_2", "i2"}, {"disparity", "dsp"}, {"frames_", "frames-"}};
  for (const auto& [word, other] : words) {
    for (size_t at; (at = name.find(word)) != std::string::npos;) {
      name.replace(at, std::string(word).size(), other);
    }
  }
  return name;
}

std::string SixDigits(uint32_t number) { return fmt::format("{:06}", number); }

// The numbers of scenes that have frames to export.
std::set<uint32_t> SceneNumbers(const std::vector<DatasetVariant>& variants, bool unfiltered) {
  std::set<uint32_t> numbers;
  for (const DatasetVariant& variant : variants) {
    for (const DatasetFrame& frame : variant.frames) {
      if (frame.passed || unfiltered) numbers.insert(frame.scene);
    }
  }
  return numbers;
}

// The scenes of the test split: every `test_every`-th, at least one and never all; none of a single
// one.
std::set<uint32_t> TestScenes(const std::set<uint32_t>& numbers, int test_every) {
  if (numbers.size() < 2) return {};
  const auto every = static_cast<uint32_t>(std::max(test_every, 1));
  std::set<uint32_t> test;
  for (const uint32_t number : numbers) {
    if (number % every == every - 1) test.insert(number);
  }
  if (test.empty()) test.insert(*numbers.rbegin());
  if (test.size() == numbers.size()) test.erase(*numbers.begin());
  return test;
}

// Adds the frames of one variant to a plan.
class PlanWriter {
 public:
  PlanWriter(ExportPlan& plan, const DatasetVariant& variant, const std::set<uint32_t>& test,
             const ExportOptions& options, std::string prefix)
      : plan_(plan),
        variant_(variant),
        test_(test),
        options_(options),
        prefix_(std::move(prefix)) {}

  // The frame is number `at` of `run`; without one it stands alone.
  void Add(const DatasetFrame& source, const SequenceRun* run, size_t at) {
    ExportFrame frame;
    frame.source = &source;
    frame.scene = prefix_ + SixDigits(source.scene) + (run ? run->suffix : "");
    frame.at = static_cast<int>(at);
    frame.length = run ? static_cast<int>(run->frames.size()) : 0;
    frame.type = SafeName(variant_.type.empty() ? variant_.name : variant_.type);
    frame.number = static_cast<int>(plan_.frames.size());
    frame.test = test_.contains(source.scene);
    frame.infrared = options_.infrared;
    const bool begins = plan_.frames.empty() || plan_.frames.back().scene != frame.scene;
    if (begins) plan_.scenes.emplace_back(plan_.frames.size(), plan_.frames.size());
    frame.scene_number = static_cast<int>(plan_.scenes.size()) - 1;
    plan_.frames.push_back(frame);
    plan_.scenes.back().second = plan_.frames.size();
  }

  void AddSingles() {
    for (const DatasetFrame& source : variant_.frames) {
      if (source.passed || options_.unfiltered) Add(source, nullptr, 0);
    }
  }

  void AddRuns(const std::vector<SequenceRun>& runs) {
    for (const SequenceRun& run : runs) {
      for (size_t i = 0; i < run.frames.size(); ++i) Add(*run.frames[i], &run, i);
    }
  }

 private:
  ExportPlan& plan_;
  const DatasetVariant& variant_;
  const std::set<uint32_t>& test_;
  const ExportOptions& options_;
  const std::string prefix_;  // Tells variants apart.
};

// One scene can't be in both splits: its last sequence or pair is the test.
void SplitSingleScene(ExportPlan& plan, bool sequences, ExportResult& result) {
  if (plan.frames.size() < 2) return;
  if (sequences && plan.scenes.size() < 2) {
    result.notes.push_back("there is one sequence only, so there is no TEST");
  } else if (sequences) {
    for (size_t i = plan.scenes.back().first; i < plan.frames.size(); ++i) {
      plan.frames[i].test = true;
    }
    result.notes.push_back(
        "all sequences are of one scene, so TEST is its last one rather than a scene of its own");
  } else {
    plan.frames.back().test = true;
    result.notes.push_back(
        "all pairs are of one scene, so TEST is its last pair rather than a scene of its own");
  }
}

void CountPlan(ExportPlan& plan, ExportResult& result) {
  for (ExportFrame& frame : plan.frames) {
    frame.scenes = static_cast<int>(plan.scenes.size());
    result.pairs_test += frame.test;
  }
  result.pairs = static_cast<int64_t>(plan.frames.size());
  result.scenes = static_cast<int64_t>(plan.scenes.size());
  for (const auto& [first, end] : plan.scenes) result.scenes_test += plan.frames[end - 1].test;
}

}  // namespace

absl::StatusOr<ExportPlan> MakeExportPlan(const std::vector<DatasetVariant>& variants,
                                          const ExportOptions& options, bool sequences,
                                          ExportResult& result) {
  std::vector<std::vector<SequenceRun>> runs(variants.size());
  std::set<uint32_t> numbers;
  if (!sequences) numbers = SceneNumbers(variants, options.unfiltered);
  for (size_t i = 0; sequences && i < variants.size(); ++i) {
    int64_t single = 0;
    ASSIGN_OR_RETURN(runs[i], FindRuns(variants[i], options.unfiltered, single));
    for (const SequenceRun& run : runs[i]) numbers.insert(run.frames.front()->scene);
    if (single == 0) continue;
    result.notes.push_back(
        fmt::format("{} pairs of {} have no neighbour in their sequence and are left out", single,
                    variants[i].name));
  }
  const std::set<uint32_t> test = TestScenes(numbers, options.test_every);
  ExportPlan plan;
  for (size_t i = 0; i < variants.size(); ++i) {
    const DatasetVariant& variant = variants[i];
    PlanWriter writer(plan, variant, test, options,
                      variants.size() > 1 ? SafeName(variant.name) + "-" : "");
    for (const DatasetFrame& frame : variant.frames) {
      result.pairs_filtered_out += !frame.passed && !options.unfiltered;
    }
    if (sequences) {
      writer.AddRuns(runs[i]);
    } else {
      writer.AddSingles();
    }
  }
  if (numbers.size() == 1) SplitSingleScene(plan, sequences, result);
  CountPlan(plan, result);
  return plan;
}

}  // namespace parallax
