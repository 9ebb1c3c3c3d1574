// Looks at a running study repeatedly and shows it, for `watch` and `run`. Not thread-safe.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/views/progress_view.h"
#include "coordinator/client/views/terminal.h"

namespace parallax::client {

// Returns the clock's steady time in seconds.
double SteadySeconds(Clock& clock);

// A coordinator that restarts is back within this; workers go on meanwhile, so watching does too.
inline constexpr double kPatience_s = 60;

// Says that a coordinator which has been silent for `silent_s` is waited for.
std::string AwayNote(double silent_s);

// Fetches the study's status and its leased jobs, and adds them to `view` as one observation at
// time `now_s`. Errors: the connection's.
absl::Status LookAt(Connection& connection, int64_t study_id, double now_s, ProgressView& view);

// Shows progress: bars that are redrawn in place on an interactive terminal, elsewhere a line now
// and then.
class ProgressDisplay {
 public:
  struct Options {
    bool json = false;         // An object a line instead of text.
    double plain_line_s = 30;  // Between two lines; a tenth of it after a change.
  };
  ProgressDisplay(const Terminal& terminal, const Options& options)
      : terminal_(terminal), options_(options), block_(terminal) {}

  // Shows the view if it is time to, or in any case with `last`. A `note` that is not empty is a
  // line below the bars.
  void Show(const ProgressView& view, double now_s, bool last, const std::string& note = "");
  // Prints a line that stays, above the bars.
  void Print(const std::string& line);
  // Leave the bars on the screen, or remove them.
  void Keep() { block_.Keep(); }
  void Clear() { block_.Clear(); }
  // Whether there are bars, and so notes below them.
  bool redraws() const { return terminal_.interactive && !options_.json; }

 private:
  const Terminal terminal_;
  const Options options_;
  LiveBlock block_;
  double printed_s_ = -1e9;
  int64_t printed_pairs_ = -1;
};

}  // namespace parallax::client
