// Inner part of common/config: what a field's rule (FieldRule in config.proto) says, and the names
// of fields and values, in the words of a message to the user.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

const v1::FieldRule& RuleOf(const google::protobuf::FieldDescriptor& field);
bool IsDistribution(const google::protobuf::FieldDescriptor& field);
bool InRange(double value, const v1::FieldRule& rule);
// "0 to 12 m", "at least 0 m", "a number".
std::string AllowedRange(const v1::FieldRule& rule);

// Nothing if the field may have this value; else the verdict: "7 is out of range, allowed 0 to 5
// m".
std::string WhyNotNumber(double value, const v1::FieldRule& rule);

// "SCENE_TYPE_INDOOR" -> "indoor".
std::string EnumText(const google::protobuf::EnumValueDescriptor& value);
// The values that a field of an enum type may have: those of its rule, or all but 0.
std::vector<std::string> EnumTexts(const google::protobuf::FieldDescriptor& field);
std::vector<std::string> FieldNames(const google::protobuf::Descriptor& type);
// "render.profile"; `name` alone at the top.
std::string Dotted(const std::string& path, const std::string& name);

// Shortest text that reads back to the same number; "5" rather than "5.0".
std::string NumberText(double value);
std::string JoinNames(const std::vector<std::string>& names);
// The known name that `name` was probably meant to be; "" when none is near.
std::string NearestName(std::string_view name, const std::vector<std::string>& known);
// ", did you mean X?" or nothing when no name is near.
std::string NearestHint(std::string_view name, const std::vector<std::string>& known);

}  // namespace parallax::config_internal
