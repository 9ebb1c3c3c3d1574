// Random names that nobody can guess, and their comparison. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// 128 random bits of the operating system's as 32 lower-case hex digits. Errors: getrandom(2)'s.
absl::StatusOr<std::string> NewSecret();

// Whether both are equal; the time that it takes tells nothing of where they differ.
bool SameSecret(std::string_view a, std::string_view b);

}  // namespace parallax
