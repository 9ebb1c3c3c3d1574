#include "common/config/stages.h"

#include "common/config/check/field_rules.h"

namespace parallax {
namespace {

using config_internal::Dotted;
using config_internal::IsDistribution;
using config_internal::RuleOf;
using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using StageTest = std::function<bool(v1::FieldRule::Stage)>;

bool IsGroup(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field.is_repeated() &&
         !IsDistribution(field);
}

void KeepOnly(const StageTest& wanted, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(*message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (IsGroup(*field)) {
      Message* group = reflection.MutableMessage(message, field);
      KeepOnly(wanted, group);
      if (group->ByteSizeLong() == 0) reflection.ClearField(message, field);
      continue;
    }
    const v1::FieldRule::Stage stage = RuleOf(*field).stage();
    if (stage != v1::FieldRule::STAGE_UNSPECIFIED && !wanted(stage)) {
      reflection.ClearField(message, field);
    }
  }
}

void ListFields(const Descriptor& type, const std::string& path, std::vector<ConfigField>& fields) {
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const std::string name = Dotted(path, field.name());
    if (IsGroup(field)) {
      ListFields(*field.message_type(), name, fields);
    } else {
      fields.push_back({name, RuleOf(field).stage()});
    }
  }
}

}  // namespace

v1::SceneConfig FieldsOf(const v1::SceneConfig& config, const StageTest& wanted) {
  v1::SceneConfig part = config;
  KeepOnly(wanted, &part);
  return part;
}

v1::SceneConfig FieldsOf(const v1::SceneConfig& config, v1::FieldRule::Stage stage) {
  return FieldsOf(config, [stage](v1::FieldRule::Stage of_field) { return of_field == stage; });
}

std::vector<ConfigField> ConfigFields() {
  std::vector<ConfigField> fields;
  ListFields(*v1::SceneConfig::descriptor(), "", fields);
  return fields;
}

}  // namespace parallax
