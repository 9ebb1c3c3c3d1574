// How many jobs a worker asks for.
#include "worker/agent/session/credit.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(CreditFor, AsksForSlotsThatAreFreeOrSoonFreeWhileReportsAreAnswered) {
  const struct {
    const char* what;
    // The worker has four slots and keeps at most eight reports.
    int taken, ending_soon, pending_reports;
    int jobs, ahead;  // The message; jobs 0: none.
  } kCases[] = {
      {"all slots are free", 0, 0, 0, 4, 0},
      {"two are taken", 2, 0, 0, 2, 0},
      {"all are taken", 4, 0, 0, 0, 0},
      {"all are taken, one ends soon", 4, 1, 0, 1, 1},
      {"one is free, one ends soon", 3, 1, 0, 2, 1},
      {"one ends soon, its next job is here", 5, 1, 0, 0, 0},
      {"reports leave room for one", 1, 0, 10, 1, 0},
      {"reports leave no room", 0, 0, 12, 0, 0},
  };
  for (const auto& c : kCases) {
    const std::optional<v1::Credit> credit = CreditFor({.slots = 4,
                                                        .taken = c.taken,
                                                        .ending_soon = c.ending_soon,
                                                        .pending_reports = c.pending_reports,
                                                        .max_pending_reports = 8});
    EXPECT_EQ(credit.has_value(), c.jobs > 0) << c.what;
    EXPECT_EQ(credit ? credit->jobs() : 0, c.jobs) << c.what;
    EXPECT_EQ(credit ? credit->ahead() : 0, c.ahead) << c.what;
  }
}

}  // namespace
}  // namespace parallax
