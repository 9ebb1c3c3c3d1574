// Inner part of common/config: reads files of things that have a name, lands and kinds of rooms.
// Whether their values may be what they are is checked later (check/biome_check.h,
// room_kind_check.h).
#pragma once

#include "common/config/config_text.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

// Fills `message`, which has a field `name`, with what the file says; without a name of its own it
// has the file's. Notes the places of its values in `origins`.
void ReadNamed(const ConfigText& text, ConfigErrors& errors, Origins& origins,
               google::protobuf::Message* message);

}  // namespace parallax::config_internal
