#include "common/rpc/message_texts.h"

#include <google/protobuf/message.h>

#include <vector>

namespace parallax {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Change = std::function<void(const std::string& field, std::string* text)>;

void ChangeMessages(Message* message, const FieldDescriptor& field, const Change& change) {
  const Reflection& reflection = *message->GetReflection();
  if (!field.is_repeated()) {
    return ChangeTexts(reflection.MutableMessage(message, &field), change);
  }
  for (int i = 0; i < reflection.FieldSize(*message, &field); ++i) {
    ChangeTexts(reflection.MutableRepeatedMessage(message, &field, i), change);
  }
}

void ChangeStrings(Message* message, const FieldDescriptor& field, const Change& change) {
  const Reflection& reflection = *message->GetReflection();
  const int size = field.is_repeated() ? reflection.FieldSize(*message, &field) : 1;
  for (int i = 0; i < size; ++i) {
    const std::string before = field.is_repeated()
                                   ? reflection.GetRepeatedString(*message, &field, i)
                                   : reflection.GetString(*message, &field);
    std::string after = before;
    change(field.name(), &after);
    if (after == before) continue;
    if (field.is_repeated()) {
      reflection.SetRepeatedString(message, &field, i, after);
    } else {
      reflection.SetString(message, &field, after);
    }
  }
}

}  // namespace

void ChangeTexts(Message* message, const Change& change) {
  std::vector<const FieldDescriptor*> set;
  message->GetReflection()->ListFields(*message, &set);
  for (const FieldDescriptor* field : set) {
    if (field->is_map() || field->name() == "source_yaml") continue;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      ChangeMessages(message, *field, change);
    } else if (field->type() == FieldDescriptor::TYPE_STRING) {
      ChangeStrings(message, *field, change);
    }
  }
}

}  // namespace parallax
