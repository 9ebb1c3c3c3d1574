// How much of a farm one user may take: a file of the operator's, `coordinator serve --limits
// FILE`.
//
//   default: {max_running: 200, max_studies: 20, max_waiting_pairs: 1000000}
//   users:
//     submitter ada: {max_running: 64, priority: 10}   # this user
//     submitter *: {max_studies: 4}         # each submitter without a row of its own
//     "*": {max_running: 8}                 # everybody else
//
// A user is role and name of a certificate, or `local` for callers without one. Each user's limits
// are for itself: two users of one row have it twice. A field that a row does not name is that of
// `default`; 0, and a field that neither names, is no limit. `priority` is added to the priority of
// each of the user's studies.
//
// Values; pure and thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

inline constexpr char kLocalUser[] = "local";
inline constexpr int kMostRunning = 1'000'000;  // The highest limit that a study may have.

// 0: no limit.
struct UserLimits {
  int64_t max_running = 0;        // Jobs at a time.
  int64_t max_studies = 0;        // Unfinished ones.
  int64_t max_waiting_pairs = 0;  // Pairs of unfinished studies that are not made yet.
  std::string rule;               // The row's key in the file: "submitter *"; empty: no row's.
  int64_t priority = 0;           // Added to those of its studies; [-1000, 1000].
};

// Returns how much a limit of `most` leaves beside `has`: 0 if the limit is reached, the largest
// number if there is no limit.
inline int64_t RoomUnder(int64_t most, int64_t has) {
  if (most == 0) return std::numeric_limits<int64_t>::max();
  return std::max<int64_t>(0, most - has);
}

class LimitRules {
 public:
  // Errors: kInvalidArgument with lines "file:line: field: what".
  static absl::StatusOr<LimitRules> Parse(std::string_view yaml, const std::string& file);
  // Errors: those of Parse; kNotFound; those of the file system.
  static absl::StatusOr<LimitRules> Load(const std::string& path);

  // Limits of a user such as "submitter ada": its own row, else that of its role, else that of "*",
  // else the default.
  UserLimits Of(const std::string& user) const;
  // Users that have a row of their own.
  std::vector<std::string> NamedUsers() const;
  // Returns one line that tells all limits, equal for equal ones: "none", or "default: max_running
  // 200; submitter ada: max_running 64, max_studies 4".
  std::string Describe() const;

 private:
  UserLimits default_;
  std::map<std::string, UserLimits> rows_;  // Complete: with the default's fields.
};

// Returns the user who acts as `actor` in the audit table: "submitter ada" of "submitter ada
// ipv4:10.0.0.7", else kLocalUser.
std::string UserOfActor(std::string_view actor);

}  // namespace parallax
