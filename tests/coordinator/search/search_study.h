// A small search for tests: two ranges, choices and a field that depends on them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/config/training_plan.h"
#include "parallax/v1/search.pb.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {

inline void AddRange(v1::SearchSpec& search, const std::string& path, double low, double high,
                     bool integer = false, bool log = false) {
  v1::SearchField& field = *search.add_space();
  field.set_path(path);
  field.set_low(low);
  field.set_high(high);
  field.set_integer(integer);
  field.set_log(log);
}
inline void AddChoices(v1::SearchSpec& search, const std::string& path,
                       const std::vector<std::string>& choices) {
  v1::SearchField& field = *search.add_space();
  field.set_path(path);
  for (const std::string& choice : choices) field.add_choices(choice);
}

inline v1::StudySpec SmallSearch(int trials = 8) {
  v1::StudySpec study = MakeStudy({.name = "recipe", .pairs = 8, .variants = {"default"}}).study();
  v1::RenderConfig& render = *study.mutable_variants(0)->mutable_config()->mutable_render();
  render.add_maps("disparity");
  render.add_maps("masks");
  study.mutable_train()->set_seeds(2);
  study.mutable_train()->set_steps(100);
  study.mutable_evaluate()->add_benchmarks("shipped");
  study.mutable_evaluate()->add_benchmarks("eth3d");
  v1::SearchSpec& search = *study.mutable_search();
  AddRange(search, "floating.count", 0, 40, /*integer=*/true);
  AddRange(search, "rigs.baseline_m", 0.05, 0.5);
  AddChoices(search, "materials.mode", {"none", "all"});
  search.set_trials(trials);
  search.mutable_confirm()->add_benchmarks("eth3d");
  ResolveTraining(&study);
  return study;
}

}  // namespace parallax
