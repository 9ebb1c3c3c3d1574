#include "coordinator/client/exit_code.h"

namespace parallax::client {

const char kExitCodeHelp[] =
    "Exit codes:\n"
    "  0    all went well\n"
    "  1    the work failed (a failed or cancelled study, crashing workers)\n"
    "  2    wrong usage or input (options, YAML, unknown study or variant)\n"
    "  3    no coordinator could be reached\n"
    "  4    disk full, read-only, or permission denied\n"
    "  130  interrupted (Ctrl-C)\n";

ExitCode ExitCodeOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kExitOk;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnauthenticated:
      return kExitUsage;
    case absl::StatusCode::kUnavailable:
      return kExitUnreachable;
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kResourceExhausted:
      return kExitDisk;
    case absl::StatusCode::kCancelled:
      return kExitInterrupted;
    default:
      return kExitFailed;
  }
}

}  // namespace parallax::client
