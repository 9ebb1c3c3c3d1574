// The store as a folder of this machine. Paths are followed part by part from the root's descriptor
// without ever following a symbolic link, so that no path leads out of it.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/store/store.h"

namespace parallax {

// The marker in the root of every store: `{"store": "<32 hex digits>"}`. A worker that does not
// find it stands before a disk that is not mounted, or the wrong one.
inline constexpr std::string_view kStoreMarker = ".parallax-store";
// Files being written: never listed, never read as results.
inline constexpr std::string_view kTemporaryPrefix = ".tmp-";

// With options.create: makes `root` (and its parents) and its marker. Proves that it can be written
// to. Errors name the folder and the cause; see OpenStore.
absl::StatusOr<std::unique_ptr<Store>> OpenLocalStore(const std::string& root,
                                                      const StoreOptions& options);

}  // namespace parallax
