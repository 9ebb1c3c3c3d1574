// Exit codes, by which a script learns the outcome of a command. The numbers are part of the
// interface: never change them.
#pragma once

#include "common/base/status.h"

namespace parallax::client {

enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,       // The work itself failed, or a watched study failed or was cancelled.
  kExitUsage = 2,        // Bad arguments, files, names or ids.
  kExitUnreachable = 3,  // No coordinator answers.
  kExitDisk = 4,         // Disk full, read-only, no permission.
  kExitInterrupted = 130,
};

// Returns the exit code of a command that ended with `status`.
ExitCode ExitCodeOf(const absl::Status& status);

// The section on exit codes of `parallax --help`.
extern const char kExitCodeHelp[];

}  // namespace parallax::client
