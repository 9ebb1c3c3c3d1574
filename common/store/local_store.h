// The store as a folder of this machine. Paths are followed part by part from the root's descriptor
// without ever following a symbolic link, so that no path leads out of it.
#pragma once

#include <memory>
#include <string>

#include "common/store/store.h"

namespace parallax {

// Makes `root` (and its parents) and proves that it can be written to. Errors name the folder and
// the cause.
absl::StatusOr<std::unique_ptr<Store>> OpenLocalStore(const std::string& root);

}  // namespace parallax
