// Whole files in and out, with errno as status. For durable writes see common/store/store.h.
// Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Errors: as open(2) and read(2), naming the path; kResourceExhausted when larger than `max_bytes`.
absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes = size_t{1} << 32);

// Creates or replaces the file's content; `sync` also brings the data (not the folder's entry) to
// disk. A short write leaves no file behind. Errors: as open(2), write(2) and fsync(2), naming the
// path.
absl::Status WriteFile(const std::string& path, std::string_view bytes, bool sync = false);

}  // namespace parallax
