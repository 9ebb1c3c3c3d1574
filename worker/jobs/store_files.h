// How jobs bring files from the store into folders of this machine.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

// A whole file of the store, read piece by piece. Errors: those of Store::Get; kDataLoss when it
// has not `size` bytes.
absl::StatusOr<std::string> GetWhole(const Store& store, const std::string& path, int64_t size);

// Makes the folder `dir` of this machine, and those above it. Errors: those of mkdir(2).
absl::Status MakeFolders(const std::string& dir);

}  // namespace parallax
