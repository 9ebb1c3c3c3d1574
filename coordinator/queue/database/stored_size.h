// The bound on messages in the database.
#pragma once

#include <cstddef>

namespace parallax {

// Largest message in bytes before compression. A larger one could not be read back (see
// compress.h), so it is refused before it is stored.
inline constexpr size_t kMaxStoredBytes = 64 << 20;

}  // namespace parallax
