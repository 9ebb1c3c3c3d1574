// The end of a measuring or drawing program: its status becomes a line on stderr and an exit
// status.
#pragma once

#include <cstdio>
#include <string>

#include "common/base/status.h"

namespace parallax {

// Runs `run`, which may choose the exit status by its last argument. An error is told in one line
// that begins with `name`, and gives the chosen status or 1.
inline int ProgramMain(const char* name, absl::Status (*run)(int, char**, int*), int argc,
                       char** argv) {
  int exit_code = 0;
  const absl::Status status = run(argc, argv, &exit_code);
  if (status.ok()) return exit_code;
  std::fprintf(stderr, "%s: %s\n", name, std::string(status.message()).c_str());
  return exit_code != 0 ? exit_code : 1;
}

}  // namespace parallax
