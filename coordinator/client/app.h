// The program `parallax`: parses the arguments, runs one command and reports its outcome. Commands
// reach the outside only through Environment, so that tests can run them in process.
#pragma once

#include <string>
#include <vector>

#include "common/base/system/clock.h"
#include "coordinator/client/views/terminal.h"

namespace parallax::client {

// The outside of commands: streams, clock and a user who answers.
struct Environment {
  Terminal out;
  Terminal err;
  Clock* clock = &Clock::System();
  // Seconds between two looks at a study; tests shorten it.
  double poll_s = 0.5;
  // Seconds between two lines of progress where lines cannot be redrawn.
  double plain_line_s = 30;
  // Answers to questions, which are asked on `err`. Null: nobody can answer.
  std::istream* answers = nullptr;
};

// Runs the command that `arguments` (without the program's name) give. Returns the exit code;
// errors are written to `err`, one line each.
int RunClient(const std::vector<std::string>& arguments, Environment& environment);

}  // namespace parallax::client
