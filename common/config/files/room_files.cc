#include "common/config/files/room_files.h"

#include "common/config/check/room_kind_check.h"
#include "common/config/config_text.h"
#include "common/config/yaml/named_files.h"

namespace parallax {

absl::StatusOr<v1::RoomKind> ParseRoomKind(std::string_view yaml, const std::string& file_name) {
  return config_internal::ParseNamed<v1::RoomKind>(yaml, file_name,
                                                   &config_internal::CheckRoomKind);
}

absl::StatusOr<v1::RoomKind> LoadRoomKind(const std::string& path) {
  ASSIGN_OR_RETURN(const config_internal::ConfigText text,
                   config_internal::ReadConfigText(path, "rooms"));
  return ParseRoomKind(text.text, text.file);
}

const std::vector<v1::RoomKind>& BuiltinRoomKinds() {
  static const auto& kinds = *new std::vector<v1::RoomKind>(
      config_internal::ParseBuiltins<v1::RoomKind>("rooms/", &ParseRoomKind));
  return kinds;
}

}  // namespace parallax
