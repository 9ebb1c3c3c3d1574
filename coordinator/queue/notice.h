// Notices tell the operator of a farm, and a study's own receiver, of its studies, outside of the
// page and the command line.
// Values.
#pragma once

#include <cstdint>
#include <string>

namespace parallax {

inline constexpr char kNoticeDone[] = "done";        // The study has ended.
inline constexpr char kNoticeFailed[] = "failed";    // Jobs failed or were quarantined.
inline constexpr char kNoticeStalled[] = "stalled";  // READY jobs, and none of them runs.
inline constexpr char kNoticeWaits[] = "waits";      // Jobs wait for a person.

// The target of a study's own receiver (NotifySpec).
inline constexpr char kStudyTarget[] = "study";

// A notice that is not delivered yet.
struct Notice {
  int64_t id = 0;
  std::string target;  // One of JobQueueOptions::notice_targets.
  int64_t study = 0;
  std::string event;
  double since_unix_s = 0;  // When it first happened.
  int64_t raised = 1;       // How often it has happened since.
  int tries = 0;            // Deliveries that failed.
  std::string url;          // Address of the study's own receiver; empty: it has none.
};

}  // namespace parallax
