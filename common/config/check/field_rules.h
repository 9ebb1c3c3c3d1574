// Inner part of common/config: reads a field's rule (FieldRule in config.proto), and words rules,
// fields and values for messages to the user. Pure functions; thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// Returns the field's rule; an empty rule if it has none.
const v1::FieldRule& RuleOf(const google::protobuf::FieldDescriptor& field);
// Returns whether the field is a v1::Distribution.
bool IsDistribution(const google::protobuf::FieldDescriptor& field);
// Returns whether the field is a v1::Quantity.
bool IsQuantity(const google::protobuf::FieldDescriptor& field);
// Returns whether a file may write the message as a list of its fields: [low, high, soft].
bool HasListForm(const google::protobuf::Descriptor& type);
// Returns whether the value is within the rule's bounds, both included.
bool InRange(double value, const v1::FieldRule& rule);
// Describes the allowed values: "0 to 12 m", "at least 0 m", "a number".
std::string AllowedRange(const v1::FieldRule& rule);

// Returns nothing if the field may have this value, else why not: "7 is out of range, allowed 0 to
// 5 m".
std::string WhyNotNumber(double value, const v1::FieldRule& rule);

// Returns an enum value as YAML spells it: "SCENE_TYPE_INDOOR" -> "indoor".
std::string EnumText(const google::protobuf::EnumValueDescriptor& value);
// Returns the values that an enum field may have: those of its rule, or all but 0.
std::vector<std::string> EnumTexts(const google::protobuf::FieldDescriptor& field);
// Returns the field of the same message that takes the items of a list of texts which are maps:
// own_benchmarks of benchmarks. Null for all other fields.
const google::protobuf::FieldDescriptor* MapsFieldOf(
    const google::protobuf::FieldDescriptor& field);
// Returns the field that a key of a file names; null if none exists. A field that takes the maps
// of another one has no key.
const google::protobuf::FieldDescriptor* FindKey(const google::protobuf::Descriptor& type,
                                                 const std::string& key);
// Returns the names of a message's fields that are keys of files, in the order of their
// declaration.
std::vector<std::string> FieldNames(const google::protobuf::Descriptor& type);
// Returns whether two messages of one type have different values in a field.
bool Differs(const google::protobuf::Message& a, const google::protobuf::Message& b,
             const google::protobuf::FieldDescriptor& field);
// Joins a path and a field's name: "render.profile"; `name` alone if `path` is empty.
std::string Dotted(const std::string& path, const std::string& name);

// Returns the shortest text that reads back to the same number; "5" rather than "5.0".
std::string NumberText(double value);
// Joins names for a message: "a, b, c".
std::string JoinNames(const std::vector<std::string>& names);

}  // namespace parallax::config_internal
