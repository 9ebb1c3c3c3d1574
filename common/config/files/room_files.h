// Kinds of rooms as files (proto/parallax/v1/room.proto): the built-in ones of configs/rooms, and
// the user's own. Errors of the loaders are those of config.h. Thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/room.pb.h"

namespace parallax {

// Loads a kind of room. `path` is a file or, if there is no such file, the name of a built-in kind.
absl::StatusOr<v1::RoomKind> LoadRoomKind(const std::string& path);
// Parses the text of such a file. `file_name` is for messages, and names a kind that has no name.
absl::StatusOr<v1::RoomKind> ParseRoomKind(std::string_view yaml, const std::string& file_name);

// Returns the built-in kinds in order of name. They live as long as the program.
const std::vector<v1::RoomKind>& BuiltinRoomKinds();

}  // namespace parallax
