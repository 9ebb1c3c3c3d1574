#include "common/config/check/field_rules.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace parallax::config_internal {

using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;

namespace {

std::string EnumPrefix(const EnumDescriptor& type) {
  std::string prefix;
  for (const char c : type.name()) {
    if (!prefix.empty() && c >= 'A' && c <= 'Z') prefix += '_';
    prefix += static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  }
  return prefix + "_";
}

std::string WithUnit(const v1::FieldRule& rule) {
  return rule.unit().empty() ? "" : " " + rule.unit();
}

}  // namespace

std::string AllowedRange(const v1::FieldRule& rule) {
  if (rule.has_min() && rule.has_max()) {
    return NumberText(rule.min()) + " to " + NumberText(rule.max()) + WithUnit(rule);
  }
  if (rule.has_min()) return "at least " + NumberText(rule.min()) + WithUnit(rule);
  if (rule.has_max()) return "at most " + NumberText(rule.max()) + WithUnit(rule);
  return rule.integer() ? "a whole number" : "a number";
}

bool InRange(double value, const v1::FieldRule& rule) {
  return !(rule.has_min() && value < rule.min()) && !(rule.has_max() && value > rule.max());
}

std::string WhyNotNumber(double value, const v1::FieldRule& rule) {
  const char* why = !std::isfinite(value)                          ? " is not a number"
                    : rule.integer() && value != std::floor(value) ? " is not a whole number"
                    : !InRange(value, rule)                        ? " is out of range"
                                                                   : nullptr;
  return why == nullptr ? "" : NumberText(value) + why + ", allowed " + AllowedRange(rule);
}

const v1::FieldRule& RuleOf(const FieldDescriptor& field) {
  return field.options().GetExtension(v1::rule);
}

bool IsDistribution(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
         field.message_type() == v1::Distribution::descriptor();
}

bool IsQuantity(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
         field.message_type() == v1::Quantity::descriptor();
}

bool HasListForm(const google::protobuf::Descriptor& type) {
  return &type == v1::SoftSpan::descriptor() || &type == v1::GroundPatches::descriptor() ||
         &type == v1::GroundRows::descriptor() || &type == v1::SizeSpan::descriptor() ||
         &type == v1::CountSpan::descriptor() || &type == v1::GapSpan::descriptor();
}

std::vector<std::string> EnumTexts(const FieldDescriptor& field) {
  const v1::FieldRule& rule = RuleOf(field);
  if (rule.allowed_size() > 0) return {rule.allowed().begin(), rule.allowed().end()};
  const EnumDescriptor& type = *field.enum_type();
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() != 0) names.push_back(EnumText(*type.value(i)));
  }
  return names;
}

const FieldDescriptor* MapsFieldOf(const FieldDescriptor& field) {
  if (RuleOf(field).names() != v1::FieldRule::NAMES_BENCHMARK) return nullptr;
  return field.containing_type()->FindFieldByName("own_" + field.name());
}

const FieldDescriptor* FindKey(const google::protobuf::Descriptor& type, const std::string& key) {
  const FieldDescriptor* field = type.FindFieldByName(key);
  for (int i = 0; field != nullptr && i < type.field_count(); ++i) {
    if (MapsFieldOf(*type.field(i)) == field) return nullptr;
  }
  return field;
}

std::vector<std::string> FieldNames(const google::protobuf::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) {
    const std::string& name = type.field(i)->name();
    if (FindKey(type, name) != nullptr) names.push_back(name);
  }
  return names;
}

bool Differs(const google::protobuf::Message& a, const google::protobuf::Message& b,
             const FieldDescriptor& field) {
  const std::unique_ptr<google::protobuf::Message> changed(a.New()), other(b.New());
  changed->CopyFrom(a);
  other->CopyFrom(b);
  a.GetReflection()->SwapFields(changed.get(), other.get(), {&field});
  return changed->SerializeAsString() != a.SerializeAsString();
}

std::string Dotted(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

std::string JoinNames(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

std::string EnumText(const google::protobuf::EnumValueDescriptor& value) {
  const std::string prefix = EnumPrefix(*value.type());
  std::string text = value.name();
  if (text.compare(0, prefix.size(), prefix) == 0) text.erase(0, prefix.size());
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return text;
}

std::string NumberText(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15 &&
      !(value == 0 && std::signbit(value))) {
    return std::to_string(static_cast<int64_t>(value));
  }
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return {buffer, end.ptr};
}

}  // namespace parallax::config_internal
