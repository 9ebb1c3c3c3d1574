// The sum of a room's wishes over an arrangement, updated incrementally: after a move only the
// wishes that it affects are evaluated again. Private to worker/layout.
#pragma once

#include <cstdint>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/layout/arrangement.h"
#include "worker/layout/wish.h"

namespace parallax {

// The part of a room that a move changed: rows with changed items, and the floor under them.
struct Touched {
  uint64_t rows = 0;
  FloorRegion floor;
  void Add(const Item& item) {
    if (item.row >= 0) rows |= uint64_t{1} << item.row;
    floor.Add(item.footprint);
  }
};

// Current and tried loss.
class Score {
 public:
  // Sums `wishes` and, for each row, the missing items. The problem has at most 64 rows.
  Score(const RoomProblem& problem, const std::vector<Wish>& wishes);

  // Evaluates everything.
  void Reset(const Arrangement& arrangement);
  // Returns the total for a changed arrangement; only Accept keeps it.
  double Try(const Arrangement& changed, const Touched& touched);
  void Accept();

  double total() const { return total_; }
  // Number of terms that Try evaluated so far, and that it would have without increments.
  int64_t evaluated() const { return evaluated_; }
  int64_t possible() const { return possible_; }
  // Writes one soft constraint for each wish.
  void Report(v1::SolveReport& report) const;

 private:
  struct Term {
    Wish wish;
    uint64_t rows = 0;  // Bits of the rows of its groups.
    bool all = false;   // Depends on everything.
    double value = 0;
    FloorRegion seen;
    double tried = 0;
    FloorRegion tried_seen;
    bool changed = false;
  };
  std::vector<Term> terms_;
  double total_ = 0, tried_total_ = 0;
  int64_t evaluated_ = 0, possible_ = 0;
};

}  // namespace parallax
