#include "common/config/files/room_files.h"

#include <stdexcept>

#include "common/config/check/room_kind_check.h"
#include "common/config/config_text.h"
#include "common/config/yaml/named_files.h"

namespace parallax {
namespace {

std::vector<v1::RoomKind> ReadBuiltins() {
  std::vector<v1::RoomKind> kinds;
  for (const std::string& name : config_internal::BuiltinNames("rooms/")) {
    const auto& file = *config_internal::FindBuiltin("rooms/" + name + ".yaml");
    absl::StatusOr<v1::RoomKind> kind = ParseRoomKind(file.text, std::string(file.name));
    // They are part of the program; a test reads them first.
    if (!kind.ok()) throw std::logic_error(kind.status().ToString());
    kinds.push_back(*std::move(kind));
  }
  return kinds;
}

}  // namespace

absl::StatusOr<v1::RoomKind> ParseRoomKind(std::string_view yaml, const std::string& file_name) {
  config_internal::ConfigErrors errors;
  config_internal::Origins origins;
  v1::RoomKind kind;
  config_internal::ReadNamed({file_name, std::string(yaml)}, errors, origins, &kind);
  config_internal::Findings findings;
  config_internal::CheckFields(kind, "", &findings);
  if (findings.empty()) config_internal::CheckRoomKind(kind, "", &findings);
  errors.AddFindings(findings, origins, file_name);
  if (!errors.empty()) return errors.ToStatus();
  return kind;
}

absl::StatusOr<v1::RoomKind> LoadRoomKind(const std::string& path) {
  ASSIGN_OR_RETURN(const config_internal::ConfigText text,
                   config_internal::ReadConfigText(path, "rooms"));
  return ParseRoomKind(text.text, text.file);
}

const std::vector<v1::RoomKind>& BuiltinRoomKinds() {
  static const auto& kinds = *new std::vector<v1::RoomKind>(ReadBuiltins());
  return kinds;
}

}  // namespace parallax
