// How far an arrangement is from what a person would like: soft constraints over a room's
// furniture. Private to worker/layout. Pure.
#pragma once

#include <array>
#include <string_view>

#include "worker/layout/arrangement.h"

namespace parallax {

enum LossTerm {
  kLossMissing,     // Furniture that the room should have.
  kLossFrontSpace,  // Free floor before what is used from the front.
  kLossLooksAt,     // Seats see what they are there for, from a good distance.
  kLossSeats,       // Seats evenly around tables.
  kLossTableSpace,  // Room to pull out chairs.
  kLossBesides,     // Free sides of beds; pairs on both sides rather than one.
  kLossReach,       // Free floor that cannot be reached from the doors.
  kLossWalls,       // Pictures spread over the walls; tall things not in heaps.
  kLossTerms
};

std::string_view NameOf(LossTerm term);

struct Loss {
  std::array<double, kLossTerms> terms{};
  double Total() const {
    double sum = 0;
    for (const double t : terms) sum += t;
    return sum;
  }
};

Loss Evaluate(const Arrangement& arrangement);

}  // namespace parallax
