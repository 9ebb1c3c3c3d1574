// Inner part of common/config: `search` of a study file. Its space is a map from fields to what
// they may be, {floating.count: {range: [0, 40]}}; all else is a message with rules.
#pragma once

#include <string>

#include "common/config/yaml/yaml_reader.h"
#include "parallax/v1/study.pb.h"

namespace parallax::config_internal {

// Name of the only variant of a study with a search, which trials are compared with.
inline constexpr char kDefaultVariant[] = "default";

// Merges the map `node`, a file's `search`, into `search`: fields of the space by their paths, of
// which null removes one that is there, others as YamlReader::Merge. Notes the places of values, as
// paths below the message, in `origins`, which has those of what is there.
void ReadSearch(YamlReader& reader, const YAML::Node& node, v1::SearchSpec* search,
                Origins* origins);

// Returns the text of `search` as a file has it, indented by two spaces. Reads back to an equal
// message.
std::string SearchText(const v1::SearchSpec& search);

// Returns the field or group of a scene config at a path with dots. Null for a path that names
// none: `why` then says so, and what was probably meant.
const google::protobuf::FieldDescriptor* FindSearchField(const std::string& path, std::string* why);
// Returns whether the field is a group of other fields.
bool IsGroup(const google::protobuf::FieldDescriptor& field);
// Return whether a field holds a number, and whether it must be whole.
bool IsNumber(const google::protobuf::FieldDescriptor& field);
bool IsWhole(const google::protobuf::FieldDescriptor& field);

// Returns YAML on one line as it may stand in a list, in a form that reading and writing keep.
std::string FlowText(const YAML::Node& node);

}  // namespace parallax::config_internal
