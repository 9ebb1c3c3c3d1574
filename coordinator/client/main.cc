#include <unistd.h>

#include <iostream>

#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "coordinator/client/app.h"

int main(int argc, char** argv) {
  using parallax::client::Terminal;
  parallax::HoldStandardStreams();
  // grpc reports each failed connection by itself; ours is the one line that people get.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  // Errors come as a command's outcome; log lines would only say them twice.
  parallax::InitLogging({.level = parallax::LogLevel::kError, .program = "parallax"});
  parallax::client::Environment environment;
  environment.out = Terminal::Standard(STDOUT_FILENO);
  environment.err = Terminal::Standard(STDERR_FILENO);
  if (isatty(STDIN_FILENO) != 0) environment.answers = &std::cin;
  return parallax::client::RunClient({argv + 1, argv + argc}, environment);
}
