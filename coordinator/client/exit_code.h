// How a command tells a script what became of it. The numbers are part of the interface: never
// renumber.
#pragma once

#include "common/base/status.h"

namespace parallax::client {

enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,       // The work itself failed, or a watched study failed or was cancelled.
  kExitUsage = 2,        // Bad arguments, files, names or ids.
  kExitUnreachable = 3,  // No coordinator there.
  kExitDisk = 4,         // Disk full, read-only, no permission.
  kExitInterrupted = 130,
};

ExitCode ExitCodeOf(const absl::Status& status);

// The text of `parallax --help` on exit codes.
extern const char kExitCodeHelp[];

}  // namespace parallax::client
