// The program `parallax`: reads arguments, runs one command, reports its outcome. Everything that a
// command sees of the outside stands in Environment, so that tests run commands in process.
#pragma once

#include <string>
#include <vector>

#include "common/base/clock.h"
#include "coordinator/client/terminal.h"

namespace parallax::client {

struct Environment {
  Terminal out;
  Terminal err;
  Clock* clock = &Clock::System();
  // Between two looks at a study; tests shorten it.
  double poll_s = 0.5;
  // Between two lines of progress where nothing can be redrawn.
  double plain_line_s = 30;
  // A question is asked on `err`; the answer comes from here. Absent: nobody can answer.
  std::istream* answers = nullptr;
};

// `arguments` without the program's name. Returns the exit code; errors are one line each on `err`.
int RunClient(const std::vector<std::string>& arguments, Environment& environment);

}  // namespace parallax::client
