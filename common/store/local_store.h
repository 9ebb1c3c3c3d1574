// A store in a folder of this machine. Paths are opened part by part from the root's descriptor and
// symbolic links are never followed, so no path leads out of the folder.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/store/store.h"

namespace parallax {

// The marker file in the root of every store: `{"store": "<32 hex digits>"}`. If a worker does not
// find it, the shared disk is not mounted, or it is another one.
inline constexpr std::string_view kStoreMarker = ".parallax-store";
// A file beside the marker: the id of the database that the store belongs to.
inline constexpr std::string_view kStoreOwner = ".parallax-owner";
// Returns the text of a marker, and the id in one. `where` is for the message. Errors: kDataLoss
// for a text that is no marker.
std::string StoreMarkerText(std::string_view id);
absl::StatusOr<std::string> ParseStoreMarker(std::string_view text, std::string_view where);
// Checks the id in a marker ("": none) against the wanted one. `store` is for the message.
// Errors: kNotFound, kFailedPrecondition.
absl::Status CheckStoreId(std::string_view store, std::string_view id, std::string_view wanted);
// Prefix of files that are being written. They are never listed or read as results.
inline constexpr std::string_view kTemporaryPrefix = ".tmp-";

// Opens the store in the folder `root`. With options.create, makes the folder, its parents and its
// marker if absent. Unless options.read_only, checks that it can be written to. Errors: those of
// OpenStore, naming the folder and the cause.
absl::StatusOr<std::unique_ptr<Store>> OpenLocalStore(const std::string& root,
                                                      const StoreOptions& options);

}  // namespace parallax
