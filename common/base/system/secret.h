// Random names that cannot be guessed, and how to compare them. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Returns 128 random bits as 32 lower-case hex digits. Errors: kInternal if OpenSSL has no entropy.
absl::StatusOr<std::string> NewSecret();

// Returns whether both are equal. The time that it takes does not depend on where they differ.
bool SameSecret(std::string_view a, std::string_view b);

}  // namespace parallax
