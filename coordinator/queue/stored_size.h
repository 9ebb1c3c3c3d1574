// How large a message the database takes.
#pragma once

#include <cstddef>

namespace parallax {

// A larger one could not be read back (see compress.h), so whoever stores one refuses it before.
inline constexpr size_t kMaxStoredBytes = 64 << 20;

}  // namespace parallax
