// The sum of a room's wishes over an arrangement, updated incrementally: after a move only the
// wishes that it affects are evaluated again. Private to worker/layout.
#pragma once

#include <cstdint>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/layout/anneal/arrangement.h"
#include "worker/layout/anneal/wish.h"

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

// The loss of the current arrangement and of the one that is tried.
class Score {
 public:
  // The loss is the sum of `wishes` and, for each row of the table, of the missing items. The
  // problem has at most 64 rows.
  Score(const RoomProblem& problem, const std::vector<Wish>& wishes);

  // Evaluates all terms for a new current arrangement.
  void Reset(const Arrangement& arrangement);
  // Returns the loss of a changed arrangement. Accept makes the arrangement of the last Try the
  // current one.
  double Try(const Arrangement& changed, const Touched& touched);
  void Accept();

  double total() const { return total_; }
  // Return the number of terms that Try has evaluated so far, and the number without incremental
  // evaluation.
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
