// Random names that cannot be guessed, and how to compare them. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Returns 128 random bits of the operating system as 32 lower-case hex digits. Errors: those of
// getrandom(2).
absl::StatusOr<std::string> NewSecret();

// Returns whether both are equal. The time that it takes does not depend on where they differ.
bool SameSecret(std::string_view a, std::string_view b);

}  // namespace parallax
