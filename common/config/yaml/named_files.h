// Inner part of common/config: reads files of things that have a name, lands and kinds of rooms.
// Whether their values may be what they are is checked later (check/biome_check.h,
// room_kind_check.h).
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/check/checks.h"
#include "common/config/config_text.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

// Fills `message`, which has a field `name`, with what the file says; without a name of its own it
// has the file's. Notes the places of its values in `origins`.
void ReadNamed(const ConfigText& text, ConfigErrors& errors, Origins& origins,
               google::protobuf::Message* message);

// Parses and checks the text of such a file; `check` does what CheckFields does not see. Errors: as
// those of config.h.
template <typename Kind>
absl::StatusOr<Kind> ParseNamed(std::string_view yaml, const std::string& file_name,
                                void (*check)(const Kind& kind, const std::string& path,
                                              Findings* findings)) {
  ConfigErrors errors;
  Origins origins;
  Kind kind;
  ReadNamed({file_name, std::string(yaml)}, errors, origins, &kind);
  Findings findings;
  CheckFields(kind, "", &findings);
  if (findings.empty()) check(kind, "", &findings);
  errors.AddFindings(findings, origins, file_name);
  if (!errors.empty()) return errors.ToStatus();
  return kind;
}

// Parses the built-in files of a folder, "rooms/", in order of name. They are part of the program:
// throws std::logic_error for a wrong one, and a test reads them first.
template <typename Kind>
std::vector<Kind> ParseBuiltins(const std::string& folder,
                                absl::StatusOr<Kind> (*parse)(std::string_view yaml,
                                                              const std::string& file_name)) {
  std::vector<Kind> kinds;
  for (const std::string& name : BuiltinNames(folder)) {
    const BuiltinFile& file = *FindBuiltin(folder + name + ".yaml");
    absl::StatusOr<Kind> kind = parse(file.text, std::string(file.name));
    if (!kind.ok()) throw std::logic_error(kind.status().ToString());
    kinds.push_back(*std::move(kind));
  }
  return kinds;
}

}  // namespace parallax::config_internal
