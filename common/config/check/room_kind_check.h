// Inner part of common/config: checks the parts of a kind of room against each other. Pure and
// thread-safe.
#pragma once

#include <string>

#include "common/config/check/checks.h"

namespace parallax::config_internal {

// Checks what CheckFields does not see: that what is needed is given and nothing else, that groups
// are known where they are named, and that ranges are not reversed. Appends its findings; `path`
// is that of the kind.
void CheckRoomKind(const v1::RoomKind& kind, const std::string& path, Findings* findings);

// Checks that the kinds that a config draws from are known.
void CheckRoomNames(const v1::RoomConfig& room, const std::string& path, Findings* findings);
// Checks the user's own kinds, and that they have names of their own.
void CheckOwnKinds(const v1::RoomConfig& room, const std::string& path, Findings* findings);

}  // namespace parallax::config_internal
