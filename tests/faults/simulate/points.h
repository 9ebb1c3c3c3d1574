// The fail points of the queue that lives came by, and at which they ended: bits by command and
// step.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "common/base/rng.h"
#include "coordinator/queue/database/fail_point.h"

namespace parallax::faults {

struct Points {
  static constexpr int kMostSteps = 63;  // Later steps of a command count as the last.
  // Commands that most runs have not, or a few times, and the chance that a life ends at a step of
  // theirs. At steps of others it is another one in each life, a tenth of it around a COMMIT.
  static constexpr std::array kSeldom = {"cancel", "pause", "resume", "retry",    "hand_back",
                                         "limit",  "drain", "forget", "priority", "comment",
                                         "repair", "scrub", "search", "stream",   "notice"};
  static constexpr double kSeldomChance = 0.1;
  using Bits = std::array<uint64_t, kFailPointCommands.size()>;

  // Notes that a life has come to a step. Returns whether it ends there; `chance`: see above.
  bool Pass(std::string_view command, int step, double chance, Rng& dice) {
    const auto place = static_cast<size_t>(
        std::find(kFailPointCommands.begin(), kFailPointCommands.end(), command) -
        kFailPointCommands.begin());
    if (place == seen.size()) return false;  // A write of the start itself.
    const uint64_t bit = uint64_t{1} << std::min(step, kMostSteps);
    seen[place] |= bit;
    const bool seldom = std::find(kSeldom.begin(), kSeldom.end(), command) != kSeldom.end();
    const bool ends = dice.Bernoulli(seldom                ? kSeldomChance
                                     : command == "commit" ? chance / 10
                                                           : chance);
    if (ends) died[place] |= bit;
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
