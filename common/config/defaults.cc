#include "common/config/defaults.h"

#include <stdexcept>

#include "common/config/check/field_rules.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

namespace {

// A distribution without default stays absent, and so does a group none of whose fields has one.
void ApplyToGroup(const FieldDescriptor& field, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  if (IsDistribution(field)) return;
  const bool present = reflection.HasField(*message, &field);
  Message* group = reflection.MutableMessage(message, &field);
  ApplyDefaults(group);
  if (!present && group->ByteSizeLong() == 0) reflection.ClearField(message, &field);
}

}  // namespace

void ApplyDefaults(Message* message) {
  const Reflection& reflection = *message->GetReflection();
  ConfigErrors errors;
  YamlReader reader("built-in defaults", &errors);
  for (int i = 0; i < message->GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message->GetDescriptor()->field(i);
    const v1::FieldRule& rule = RuleOf(field);
    if (rule.default_yaml().empty()) {
      if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
      if (!field.is_repeated()) ApplyToGroup(field, message);
      for (int item = 0; field.is_repeated() && item < reflection.FieldSize(*message, &field);
           ++item) {
        ApplyDefaults(reflection.MutableRepeatedMessage(message, &field, item));
      }
      continue;
    }
    const bool set = field.is_repeated() ? reflection.FieldSize(*message, &field) > 0
                                         : reflection.HasField(*message, &field);
    if (set) continue;
    YAML::Node node;
    node[field.name()] = YAML::Load(rule.default_yaml());
    reader.Merge(node, message, "");
  }
  if (!errors.empty()) {
    // A FieldRule that breaks itself can't be repaired at run time; the unit test catches it first.
    throw std::logic_error(errors.ToStatus().ToString());
  }
}

}  // namespace parallax::config_internal
