// How long the results of a study took to make, from the seconds that their workers report: layouts
// and scenes the time of their thread, pairs their share of the render job's CPU time, trainings
// and evaluations their time by their threads.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace parallax {

// Core-seconds of a study's results, whoever made them.
struct StudyCosts {
  struct Pairs {
    int64_t pairs = 0;
    double core_s = 0;  // With the solves of its scenes, also rejected ones.
  };
  std::map<std::string, Pairs> variants;  // By name; those without results are absent.
  double train_core_s = 0, evaluate_core_s = 0;
  double fresh_core_s = 0;  // Results that the study made itself, and did not reuse.
};

}  // namespace parallax
