// Copies files from the store into folders of this machine, for jobs.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

// Reads a whole file of the store, piece by piece. Errors: those of Store::Get; kDataLoss when its
// size is not `size` bytes.
absl::StatusOr<std::string> GetWhole(const Store& store, const std::string& path, int64_t size);

}  // namespace parallax
