// Looking at a running study again and again, and showing it: what `watch` and `run` share. Not
// thread-safe.
#pragma once

#include <string>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/progress_view.h"
#include "coordinator/client/terminal.h"

namespace parallax::client {

double SteadySeconds(Clock& clock);

// One observation for the view: the study's status and its leased jobs.
// Errors: the connection's.
absl::Status LookAt(Connection& connection, int64_t study_id, double now_s, ProgressView& view);

// Bars redrawn in place on an interactive terminal, lines now and then elsewhere.
class ProgressDisplay {
 public:
  struct Options {
    bool json = false;         // An object a line instead of text.
    double plain_line_s = 30;  // At least so often a line; after a change ten times as soon.
  };
  ProgressDisplay(const Terminal& terminal, const Options& options)
      : terminal_(terminal), options_(options), block_(terminal) {}

  // `last`: in any case. `note`: a line below the bars while it isn't empty.
  void Show(const ProgressView& view, double now_s, bool last, const std::string& note = "");
  // A line that stays, above the bars.
  void Print(const std::string& line);
  // Bars stay on the screen, or go.
  void Keep() { block_.Keep(); }
  void Clear() { block_.Clear(); }

 private:
  bool redraws() const { return terminal_.interactive && !options_.json; }

  const Terminal terminal_;
  const Options options_;
  LiveBlock block_;
  double printed_s_ = -1e9;
  int64_t printed_pairs_ = -1;
};

}  // namespace parallax::client
