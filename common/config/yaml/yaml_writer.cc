#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>

#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "common/config/search/search_space.h"

namespace parallax {
namespace {

using config_internal::EnumText;
using config_internal::NumberText;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

bool LooksLikeOtherThanText(const std::string& text) {
  for (const char* word : {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}) {
    if (text.size() == std::string_view(word).size() &&
        std::equal(text.begin(), text.end(), word, [](char a, char b) {
          return std::tolower(static_cast<unsigned char>(a)) == b;
        })) {
      return true;
    }
  }
  return !text.empty() && !std::isalpha(static_cast<unsigned char>(text[0])) && text[0] != '_';
}

std::string QuotedIfNeeded(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' ||
           c == '/';
  });
  if (plain && !text.empty() && !LooksLikeOtherThanText(text)) return text;
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += "\\x";
      quoted += kDigits[c >> 4];
      quoted += kDigits[c & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string DistributionText(const v1::Distribution& d) {
  const auto list = [](std::initializer_list<double> values) {
    std::string text;
    for (const double value : values) text += (text.empty() ? "[" : ", ") + NumberText(value);
    return text + "]";
  };
  switch (d.kind_case()) {
    case v1::Distribution::kConstant:
      return NumberText(d.constant());
    case v1::Distribution::kUniform:
      return "{uniform: " + list({d.uniform().low(), d.uniform().high()}) + "}";
    case v1::Distribution::kUniformInt:
      return fmt::format("{{uniform_int: [{}, {}]}}", d.uniform_int().low(),
                         d.uniform_int().high());
    case v1::Distribution::kChoice: {
      std::string text;
      for (const double value : d.choice().values()) {
        text += (text.empty() ? "" : ", ") + NumberText(value);
      }
      return "{choice: [" + text + "]}";
    }
    case v1::Distribution::kClipGaussian: {
      const auto& g = d.clip_gaussian();
      return "{clip_gaussian: " + list({g.mean(), g.std(), g.low(), g.high()}) + "}";
    }
    case v1::Distribution::kBernoulli:
      return "{bernoulli: " + NumberText(d.bernoulli().p()) + "}";
    case v1::Distribution::KIND_NOT_SET:
      break;
  }
  return "0";
}

// Writes an enum's number if it has no name; the reader then reports it.
std::string EnumNumberText(const google::protobuf::EnumDescriptor& type, int number) {
  const auto* value = type.FindValueByNumber(number);
  return value == nullptr ? std::to_string(number) : EnumText(*value);
}

// Text of a scalar; `index` < 0 for fields that are no list.
std::string ScalarText(const Message& message, const FieldDescriptor& field, int index) {
  const Reflection& r = *message.GetReflection();
  const auto pick = [&](auto single, auto repeated) { return index < 0 ? single() : repeated(); };
  const FieldDescriptor* f = &field;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return std::to_string(pick([&] { return r.GetInt32(message, f); },
                                 [&] { return r.GetRepeatedInt32(message, f, index); }));
    case FieldDescriptor::CPPTYPE_INT64:
      return std::to_string(pick([&] { return r.GetInt64(message, f); },
                                 [&] { return r.GetRepeatedInt64(message, f, index); }));
    case FieldDescriptor::CPPTYPE_UINT32:
      return std::to_string(pick([&] { return r.GetUInt32(message, f); },
                                 [&] { return r.GetRepeatedUInt32(message, f, index); }));
    case FieldDescriptor::CPPTYPE_UINT64:
      return std::to_string(pick([&] { return r.GetUInt64(message, f); },
                                 [&] { return r.GetRepeatedUInt64(message, f, index); }));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return NumberText(pick([&] { return r.GetDouble(message, f); },
                             [&] { return r.GetRepeatedDouble(message, f, index); }));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return NumberText(pick([&] { return r.GetFloat(message, f); },
                             [&] { return r.GetRepeatedFloat(message, f, index); }));
    case FieldDescriptor::CPPTYPE_BOOL:
      return pick([&] { return r.GetBool(message, f); },
                  [&] { return r.GetRepeatedBool(message, f, index); })
                 ? "true"
                 : "false";
    case FieldDescriptor::CPPTYPE_ENUM:
      return EnumNumberText(*field.enum_type(),
                            pick([&] { return r.GetEnumValue(message, f); },
                                 [&] { return r.GetRepeatedEnumValue(message, f, index); }));
    case FieldDescriptor::CPPTYPE_STRING:
      return QuotedIfNeeded(pick([&] { return r.GetString(message, f); },
                                 [&] { return r.GetRepeatedString(message, f, index); }));
    case FieldDescriptor::CPPTYPE_MESSAGE:
      break;
  }
  return "";
}

// Points, poses and the like: numbers without presence only. They read best on one line.
bool IsTuple(const google::protobuf::Descriptor& type) {
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (field.is_repeated() || field.has_presence() ||
        field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ||
        field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      return false;
    }
  }
  return type.field_count() > 0;
}

std::string TupleText(const Message& message) {
  std::string text;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    text += (text.empty() ? "" : ", ") + field.name() + ": " + ScalarText(message, field, -1);
  }
  return "{" + text + "}";
}

void WriteMessage(const Message& message, const std::string& indent, std::string& out);

// Text of a number of a land, or of a message that has a list form; "" for others.
std::string ShortText(const Message& message) {
  if (const auto* quantity = dynamic_cast<const v1::Quantity*>(&message)) {
    return quantity->has_formula() ? QuotedIfNeeded(quantity->formula())
                                   : DistributionText(quantity->drawn());
  }
  if (!config_internal::HasListForm(*message.GetDescriptor())) return "";
  std::string text;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    const bool number = field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE;
    text += (i > 0 ? ", " : "[") +
            (number ? ScalarText(message, field, -1)
                    : ShortText(message.GetReflection()->GetMessage(message, &field)));
  }
  return text + "]";
}

// Writes a message after "key:", on the same line if it is short, else as an indented block.
void WriteNested(const Message& message, const std::string& indent, std::string& out) {
  if (message.GetDescriptor() == v1::Distribution::descriptor()) {
    out += " " + DistributionText(dynamic_cast<const v1::Distribution&>(message)) + "\n";
  } else if (const std::string text = ShortText(message); !text.empty()) {
    out += " " + text + "\n";
  } else if (IsTuple(*message.GetDescriptor())) {
    out += " " + TupleText(message) + "\n";
  } else {
    std::string block;
    WriteMessage(message, indent + "  ", block);
    out += block.empty() ? " {}\n" : "\n" + block;
  }
}

// A message on one line, with the fields that are set.
std::string FlowText(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  std::string text;
  for (const FieldDescriptor* field : fields) {
    text += (text.empty() ? "" : ", ") + field->name() + ": " + ScalarText(message, *field, -1);
  }
  return "{" + text + "}";
}

void WriteMap(const Message& message, const FieldDescriptor& field, const std::string& indent,
              std::string& out) {
  const Reflection& r = *message.GetReflection();
  const FieldDescriptor& key_field = *field.message_type()->map_key();
  const FieldDescriptor& value_field = *field.message_type()->map_value();
  std::map<std::string, std::string> sorted;
  for (int i = 0; i < r.FieldSize(message, &field); ++i) {
    const Message& entry = r.GetRepeatedMessage(message, &field, i);
    std::string value;
    if (value_field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      WriteNested(entry.GetReflection()->GetMessage(entry, &value_field), indent + "  ", value);
    } else {
      value = " " + ScalarText(entry, value_field, -1) + "\n";
    }
    sorted.emplace(ScalarText(entry, key_field, -1), value);
  }
  out += indent + field.name() + ":" + (sorted.empty() ? " {}\n" : "\n");
  for (const auto& [key, value] : sorted) out += indent + "  " + key + ":" + value;
}

void WriteList(const Message& message, const FieldDescriptor& field, const std::string& indent,
               std::string& out) {
  const Reflection& r = *message.GetReflection();
  const int size = r.FieldSize(message, &field);
  out += indent + field.name() + ":";
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
    out += " [";
    for (int i = 0; i < size; ++i) out += (i > 0 ? ", " : "") + ScalarText(message, field, i);
    const FieldDescriptor* const maps = config_internal::MapsFieldOf(field);
    for (int i = 0; maps != nullptr && i < r.FieldSize(message, maps); ++i) {
      out += (size + i > 0 ? ", " : "") + FlowText(r.GetRepeatedMessage(message, maps, i));
    }
    out += "]\n";
    return;
  }
  out += size == 0 ? " []\n" : "\n";
  for (int i = 0; i < size; ++i) {
    const Message& item = r.GetRepeatedMessage(message, &field, i);
    std::string block;
    if (item.GetDescriptor() == v1::Distribution::descriptor() || IsTuple(*item.GetDescriptor())) {
      WriteNested(item, "", block);
      out += indent + "  -" + block;
      continue;
    }
    WriteMessage(item, indent + "    ", block);
    if (block.empty()) {
      out += indent + "  - {}\n";
    } else {
      block.replace(indent.size() + 2, 1, "-");
      out += block;
    }
  }
}

void WriteMessage(const Message& message, const std::string& indent, std::string& out) {
  const Reflection& r = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    if (config_internal::FindKey(*message.GetDescriptor(), field.name()) == nullptr) {
      continue;  // Written with the field whose items these are.
    } else if (field.is_map()) {
      WriteMap(message, field, indent, out);
    } else if (field.is_repeated()) {
      WriteList(message, field, indent, out);
    } else if (field.has_presence() && !r.HasField(message, &field)) {
      continue;
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      out += indent + field.name() + ":";
      WriteNested(r.GetMessage(message, &field), indent, out);
    } else if (field.cpp_type() != FieldDescriptor::CPPTYPE_ENUM ||
               r.GetEnumValue(message, &field) != 0) {
      out += indent + field.name() + ": " + ScalarText(message, field, -1) + "\n";
    }
  }
}

}  // namespace

std::string MessageToYaml(const Message& message) {
  std::string out;
  WriteMessage(message, "", out);
  return out;
}

std::string StudyToYaml(const v1::StudySpec& study) {
  std::string out;
  out += "study: " + QuotedIfNeeded(study.name()) + "\n";
  out += fmt::format("seed: {}\n", study.seed());
  out += study.has_stream() ? "pairs: endless\n" : fmt::format("pairs: {}\n", study.pairs());
  out += fmt::format("rigs_per_scene: {}\n", study.rigs_per_scene());
  out += fmt::format("priority: {}\n", study.priority());
  // Only where asked for: the text of other studies stays what it was.
  if (!study.tags().empty()) {
    out += "tags: [";
    for (int i = 0; i < study.tags_size(); ++i) {
      out += (i > 0 ? ", " : "") + QuotedIfNeeded(study.tags(i));
    }
    out += "]\n";
  }
  if (study.memory_mb() != 0) out += fmt::format("memory_mb: {}\n", study.memory_mb());
  if (study.has_stream()) {
    out += "stream:";
    WriteNested(study.stream(), "", out);
  }
  if (study.has_notify()) {
    out += "notify:";
    WriteNested(study.notify(), "", out);
  }
  if (study.has_search()) out += "search:\n" + config_internal::SearchText(study.search());
  if (study.has_train()) {
    out += "train:";
    WriteNested(study.train(), "", out);
  }
  if (study.has_evaluate()) {
    out += "evaluate:";
    WriteNested(study.evaluate(), "", out);
  }
  out += study.variants().empty() ? "variants: []\n" : "variants:\n";
  for (const v1::VariantSpec& variant : study.variants()) {
    out += "  - name: " + QuotedIfNeeded(variant.name()) + "\n";
    if (variant.pairs() != 0) out += fmt::format("    pairs: {}\n", variant.pairs());
    if (variant.rigs_per_scene() != 0) {
      out += fmt::format("    rigs_per_scene: {}\n", variant.rigs_per_scene());
    }
    if (variant.seed() != 0) out += fmt::format("    seed: {}\n", variant.seed());
    if (variant.heldout()) out += "    heldout: true\n";
    out += "    config:\n";
    WriteMessage(variant.config(), "      ", out);
  }
  return out;
}

}  // namespace parallax
