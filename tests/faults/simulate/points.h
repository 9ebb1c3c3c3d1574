// The fail points of the queue that lives came by, and at which they ended: bits by command and
// step.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "coordinator/queue/database/fail_point.h"
#include "tests/faults/simulate/exact_math.h"

namespace parallax::faults {

struct Points {
  static constexpr int kMostSteps = 63;  // Later steps of a command count as the last.
  struct Point {
    std::string command;
    int step = 1;
  };
  using Bits = std::array<uint64_t, kFailPointCommands.size()>;

  // Returns a point of any command, half of the times of one of `seldom`. Early steps come oftener:
  // most commands have few.
  static Point Draw(const std::vector<std::string>& seldom, Rng& dice) {
    const std::vector<std::string> all(kFailPointCommands.begin(), kFailPointCommands.end());
    return {dice.Pick(seldom.empty() || dice.Bernoulli(0.5) ? all : seldom),
            static_cast<int>(Power(kMostSteps, dice.Uniform() * dice.Uniform()))};
  }
  // Notes that a life has come to a point. Returns whether it is the one at which it ends.
  bool Pass(const Point& at, const Point& end) {
    const auto command = static_cast<size_t>(
        std::find(kFailPointCommands.begin(), kFailPointCommands.end(), at.command) -
        kFailPointCommands.begin());
    if (command == seen.size()) return false;  // A write of the start itself.
    const uint64_t bit = uint64_t{1} << std::min(at.step, kMostSteps);
    seen[command] |= bit;
    const bool ends = at.command == end.command && at.step == end.step;
    if (ends) died[command] |= bit;
    return ends;
  }
  static int CountOf(const Bits& bits) {
    int count = 0;
    for (const uint64_t word : bits) count += std::popcount(word);
    return count;
  }

  Bits seen{}, died{};
};

}  // namespace parallax::faults
