#include "common/base/status.h"

#include <fmt/core.h>

#include <cerrno>
#include <cstring>

#include "common/base/system/memory_end.h"

namespace parallax {
namespace {

absl::StatusCode CodeOfErrno(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
    case EMFILE:
    case ENFILE:
    case ENOMEM:
      return absl::StatusCode::kResourceExhausted;
    case ENOENT:
    case ENOTDIR:
      return absl::StatusCode::kNotFound;
    case EEXIST:
      return absl::StatusCode::kAlreadyExists;
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::StatusCode::kPermissionDenied;
    case EIO:
    case EAGAIN:
      return absl::StatusCode::kUnavailable;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::Status MakeFormattedError(absl::StatusCode code, fmt::string_view format,
                                fmt::format_args args) {
  return MakeError(code, fmt::vformat(format, args));
}

absl::Status WithContext(const absl::Status& status, std::string_view context) {
  if (status.ok()) return status;
  return MakeError(status.code(), fmt::format("{}: {}", context, status.message()));
}

absl::Status ErrnoError(int error_number, std::string_view what) {
  if (error_number == ENOMEM) EndIfMemoryIsNeeded();
  return MakeError(CodeOfErrno(error_number),
                   fmt::format("{}: {}", what, std::strerror(error_number)));
}

}  // namespace parallax
