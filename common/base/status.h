// Errors below `main` are absl::Status / StatusOr. This header adds what Debian's Abseil (20220623)
// lacks: early-return macros, formatted messages (errors.h), context for an error on its way up.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/errors.h"

namespace parallax {

// Returns the same code with "context: " in front of the message. OK stays OK.
absl::Status WithContext(const absl::Status& status, std::string_view context);

// Makes a status of errno: "open /a/b: No space left on device". The code is kResourceExhausted for
// ENOSPC and EDQUOT, kNotFound for ENOENT, kPermissionDenied for EACCES, EPERM and EROFS,
// kUnavailable for EIO, and kInternal for all others. `what` says what was tried: "open /a/b".
absl::Status ErrnoError(int error_number, std::string_view what);

}  // namespace parallax

#define PARALLAX_CONCAT_INNER(a, b) a##b
#define PARALLAX_CONCAT(a, b) PARALLAX_CONCAT_INNER(a, b)

// Returns from the calling function if the status is an error:
//   RETURN_IF_ERROR(WriteFile(path, bytes));
#define RETURN_IF_ERROR(expression)                    \
  do {                                                 \
    ::absl::Status parallax_status = (expression);     \
    if (!parallax_status.ok()) return parallax_status; \
  } while (false)

// Declares a variable with the value of a StatusOr, or returns its error from the calling function:
//   ASSIGN_OR_RETURN(auto image, ReadImage(path));
#define ASSIGN_OR_RETURN(declaration, expression) \
  PARALLAX_ASSIGN_OR_RETURN(PARALLAX_CONCAT(parallax_or_, __LINE__), declaration, expression)
#define PARALLAX_ASSIGN_OR_RETURN(temporary, declaration, expression) \
  auto temporary = (expression);                                      \
  if (!temporary.ok()) return std::move(temporary).status();          \
  declaration = *std::move(temporary)
