// Makes errors: one function for each code of absl::Status, which takes a format string of {fmt}:
//   return InvalidArgument("{}: line {}: expected {}", path, line, wanted);
// The compiler checks the format string against its arguments. A text that is no literal is an
// argument: NotFound("{}", text). MakeError takes a code that is known at run time only.
// Include this header by common/base/status.h.
#pragma once

#include <fmt/core.h>

#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

// Debian's absl::string_view is not std::string_view: {fmt} has to be told how to write it.
template <>
struct fmt::formatter<absl::string_view> {
  static constexpr auto parse(fmt::format_parse_context& context) { return context.begin(); }
  static auto format(absl::string_view text, fmt::format_context& context) {
    return fmt::format_to(context.out(), "{}", std::string_view(text.data(), text.size()));
  }
};

namespace parallax {

// They convert between the two kinds of string_view.
inline absl::string_view ToAbsl(std::string_view text) { return {text.data(), text.size()}; }
inline std::string_view ToStd(absl::string_view text) { return {text.data(), text.size()}; }

// Makes an error of a code that is known at run time only. Errors: `code`, always.
inline absl::Status MakeError(absl::StatusCode code, std::string_view message) {
  return absl::Status(code, ToAbsl(message));
}

// Makes an error of formatted text; the functions below call it. Errors: `code`, always.
absl::Status MakeFormattedError(absl::StatusCode code, fmt::string_view format,
                                fmt::format_args args);

#define PARALLAX_DEFINE_ERROR(Name)                                                               \
  template <typename... Args>                                                                     \
  absl::Status Name(fmt::format_string<Args...> format, Args&&... args) {                         \
    return MakeFormattedError(absl::StatusCode::k##Name, format, fmt::make_format_args(args...)); \
  }
PARALLAX_DEFINE_ERROR(Aborted)
PARALLAX_DEFINE_ERROR(AlreadyExists)
PARALLAX_DEFINE_ERROR(Cancelled)
PARALLAX_DEFINE_ERROR(DataLoss)
PARALLAX_DEFINE_ERROR(DeadlineExceeded)
PARALLAX_DEFINE_ERROR(FailedPrecondition)
PARALLAX_DEFINE_ERROR(Internal)
PARALLAX_DEFINE_ERROR(InvalidArgument)
PARALLAX_DEFINE_ERROR(NotFound)
PARALLAX_DEFINE_ERROR(OutOfRange)
PARALLAX_DEFINE_ERROR(PermissionDenied)
PARALLAX_DEFINE_ERROR(ResourceExhausted)
PARALLAX_DEFINE_ERROR(Unauthenticated)
PARALLAX_DEFINE_ERROR(Unavailable)
PARALLAX_DEFINE_ERROR(Unimplemented)
PARALLAX_DEFINE_ERROR(Unknown)
#undef PARALLAX_DEFINE_ERROR

}  // namespace parallax
