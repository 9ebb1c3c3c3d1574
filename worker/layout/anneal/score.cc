#include "worker/layout/anneal/score.h"

#include <cmath>

namespace parallax {
namespace {

Wish Wanted(int row, const WantedRow& wanted) {
  return Wish(wanted.row.group + " wanted", WishKind::kFullness, {wanted.row.group},
              [row, count = wanted.wanted](const Arrangement& a, FloorRegion&) {
                return std::abs(count - a.CountOf(row));
              })
      .Weight(wanted.row.weight);
}

}  // namespace

Score::Score(const RoomProblem& problem, const std::vector<Wish>& wishes) {
  const auto add = [&](const Wish& wish) {
    Term term{wish};
    term.all = wish.groups().empty();
    for (size_t r = 0; r < problem.rows.size(); ++r) {
      for (const std::string& group : wish.groups()) {
        if (problem.rows[r].row.group == group) term.rows |= uint64_t{1} << r;
      }
    }
    if (term.all || term.rows != 0) terms_.push_back(term);
  };
  for (size_t r = 0; r < problem.rows.size(); ++r) {
    add(Wanted(static_cast<int>(r), problem.rows[r]));
  }
  for (const Wish& wish : wishes) add(wish);
}

void Score::Reset(const Arrangement& arrangement) {
  total_ = 0;
  for (Term& term : terms_) {
    term.seen = FloorRegion();
    term.value = term.wish.Of(arrangement, term.seen);
    term.changed = false;
    total_ += term.value;
  }
}

double Score::Try(const Arrangement& changed, const Touched& touched) {
  tried_total_ = 0;
  for (Term& term : terms_) {
    ++possible_;
    term.changed = term.all || (term.rows & touched.rows) != 0 || term.seen.Meets(touched.floor);
    if (term.changed) {
      ++evaluated_;
      term.tried_seen = FloorRegion();
      term.tried = term.wish.Of(changed, term.tried_seen);
    }
    tried_total_ += term.changed ? term.tried : term.value;
  }
  return tried_total_;
}

void Score::Accept() {
  for (Term& term : terms_) {
    if (!term.changed) continue;
    term.value = term.tried;
    term.seen = term.tried_seen;
    term.changed = false;
  }
  total_ = tried_total_;
}

void Score::Report(v1::SolveReport& report) const {
  for (const Term& term : terms_) {
    v1::SolveReport::Constraint& constraint = *report.add_constraints();
    constraint.set_name(std::string(NameOf(term.wish.kind())) + ": " + term.wish.name());
    constraint.set_violation(term.value);
  }
  report.set_terms_evaluated(evaluated_);
  report.set_terms_total(possible_);
}

}  // namespace parallax
