#include "common/config/yaml_reader.h"

#include <fmt/core.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/names.h"
#include "common/config/checks.h"
#include "common/config/field_rules.h"
#include "common/config/limits.h"
#include "common/config/sensor_presets.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr size_t kMostShown = 60;  // Bytes of a value.

// Only plain scalars are numbers and booleans: "5" in quotes is text.
bool IsPlain(const YAML::Node& node) { return node.IsScalar() && node.Tag() == "?"; }

// Describes the node for a message: its text, or its kind.
std::string Seen(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list";
  if (node.IsScalar()) {
    return IsPlain(node) && IsPlainText(node.Scalar()) && node.Scalar().size() <= kMostShown
               ? node.Scalar()
               : Quoted(node.Scalar());
  }
  return "nothing";
}

template <typename Number>
std::optional<Number> ParseWhole(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Whether a map of weights gives any a number above 0. Then it names all that are wanted.
bool NamesAny(const YAML::Node& weights) {
  if (!weights.IsMap()) return false;
  return std::any_of(weights.begin(), weights.end(), [](const auto& entry) {
    const YAML::Node& value = entry.second;
    return IsPlain(value) && ParseWhole<double>(value.Scalar()).value_or(0) > 0;
  });
}

void ForbidAll(v1::BiomeWeights* weights) {
  const google::protobuf::Descriptor& type = *weights->GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    weights->GetReflection()->SetDouble(weights, type.field(i), 0);
  }
}

// The nearest 64-bit number; NaN gives one that is too large for any field.
int64_t WholeOf(double value) {
  constexpr double kMost = 9e18;
  return static_cast<int64_t>(value >= -kMost && value <= kMost ? value
                                                                : std::copysign(kMost, value));
}

// Counts documents; knows the line of the last one's first node.
class DocumentCounter final : public YAML::EventHandler {
 public:
  int documents = 0;
  int last_line = 0;

  void OnDocumentStart(const YAML::Mark& mark) override {
    ++documents;
    last_line = mark.line;
    empty_ = true;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { Content(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { Content(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    Content(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    Content(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    Content(mark);
  }
  void OnMapEnd() override {}

 private:
  void Content(const YAML::Mark& mark) {
    if (empty_ && !mark.is_null()) last_line = mark.line;
    empty_ = false;
  }
  bool empty_ = true;
};

}  // namespace

Origin YamlReader::OriginOf(const YAML::Node& node, std::string_view path) const {
  const YAML::Mark mark = node.Mark();
  return {file_, mark.is_null() ? 0 : mark.line + 1, std::string(path)};
}

void YamlReader::Error(const YAML::Node& node, std::string_view path, std::string_view what) {
  errors_->Add(OriginOf(node, path), what);
}

void YamlReader::Note(const YAML::Node& node, const std::string& path) {
  if (origins_ != nullptr) origins_->Set(path.substr(prefix_), OriginOf(node, path));
}

std::optional<YAML::Node> YamlReader::Parse(std::string_view text) {
  if (text.size() > kMaxYamlBytes) {
    errors_->Add({file_, 0, ""},
                 fmt::format("larger than {} KiB: not a configuration", kMaxYamlBytes >> 10));
    return std::nullopt;
  }
  if (text.find('\0') != std::string_view::npos) {
    errors_->Add({file_, 0, ""}, "holds a NUL byte: not a text file");
    return std::nullopt;
  }
  try {
    // Not LoadAll: at a stray ",", yaml-cpp finds empty documents without end.
    DocumentCounter counter;
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (counter.documents < 2 && parser.HandleNextDocument(counter)) {
    }
    if (counter.documents > 1) {
      errors_->Add({file_, counter.last_line + 1, ""}, "a second YAML document, allowed is one");
    }
    return YAML::Load(std::string(text));
  } catch (const YAML::Exception& error) {
    errors_->Add({file_, error.mark.is_null() ? 0 : error.mark.line + 1, ""},
                 "not YAML: " + error.msg);
    return std::nullopt;
  }
}

std::vector<std::pair<std::string, YAML::Node>> YamlReader::Entries(const YAML::Node& node,
                                                                    const std::string& path) {
  std::vector<std::pair<std::string, YAML::Node>> entries;
  if (!node.IsMap()) {
    Error(node, path, Seen(node) + ", allowed is a map of fields");
    return entries;
  }
  std::set<std::string> names;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) {
      Error(entry.first, path, Seen(entry.first) + " as a key, allowed is a field name");
      continue;
    }
    const std::string name = entry.first.Scalar();
    if (!names.insert(name).second) {
      Error(entry.first, Dotted(path, name), "stands twice, allowed is once");
    }
    entries.emplace_back(name, entry.second);
  }
  return entries;
}

void YamlReader::UnknownField(const YAML::Node& node, const std::string& path,
                              const std::string& name, const std::vector<std::string>& known) {
  Error(node, Dotted(path, name),
        "no such field" + NearestHint(name, known) + " (allowed: " + JoinNames(known) + ")");
}

void YamlReader::Merge(const YAML::Node& node, Message* message, const std::string& path,
                       Origins* origins) {
  origins_ = origins;
  prefix_ = path.empty() ? 0 : path.size() + 1;
  MergeFields(node, message, path);
  origins_ = nullptr;
}

void YamlReader::MergeFields(const YAML::Node& node, Message* message, const std::string& path) {
  const auto& type = *message->GetDescriptor();
  if (auto* sensor = dynamic_cast<v1::SensorConfig*>(message); sensor != nullptr && node.IsMap()) {
    // Before the fields beside it, wherever it stands among them.
    if (const YAML::Node preset = node["preset"]; preset && preset.IsScalar()) {
      TakeSensorPreset(preset.Scalar(), sensor);
    }
  }
  for (const auto& [name, value] : Entries(node, path)) {
    if (errors_->enough()) return;
    if (const FieldDescriptor* field = type.FindFieldByName(name)) {
      Set(value, Dotted(path, name), *field, message);
      continue;
    }
    const std::vector<std::string> known = FieldNames(type);
    UnknownField(value, path, name, known);
    if (const std::string meant = NearestName(name, known); !meant.empty()) {
      CheckMeant(value, path, meant, *message);
    }
  }
  // Entries reports a list of maps; the fields in it are checked nevertheless.
  for (size_t i = 0; node.IsSequence() && i < node.size() && !errors_->enough(); ++i) {
    if (node[i].IsMap()) MergeFields(node[i], message, path);
  }
}

void YamlReader::CheckMeant(const YAML::Node& node, const std::string& path,
                            const std::string& meant, const Message& message) {
  const std::unique_ptr<Message> scratch(message.New());
  Origins own_origins;
  Origins* const outer = std::exchange(origins_, &own_origins);
  Set(node, Dotted(path, meant), *message.GetDescriptor()->FindFieldByName(meant), scratch.get());
  origins_ = outer;
  Findings findings;
  CheckFields(*scratch, path.size() < prefix_ ? "" : path.substr(prefix_), &findings);
  errors_->AddFindings(findings, own_origins, file_);
}

void YamlReader::Set(const YAML::Node& node, const std::string& path, const FieldDescriptor& field,
                     Message* message) {
  Note(node, path);
  if (field.is_repeated()) {
    SetList(node, path, field, message);
  } else {
    SetField(node, path, field, message);
  }
}

std::optional<int64_t> YamlReader::ReadInt(const YAML::Node& node, const std::string& path,
                                           int64_t min, int64_t max, std::string_view unit) {
  v1::FieldRule rule;
  rule.set_integer(true);
  if (min != std::numeric_limits<int64_t>::min()) rule.set_min(static_cast<double>(min));
  if (max != std::numeric_limits<int64_t>::max()) rule.set_max(static_cast<double>(max));
  rule.set_unit(std::string(unit));
  const std::optional<int64_t> value =
      IsPlain(node) ? ParseWhole<int64_t>(node.Scalar()) : std::nullopt;
  if (!value) {
    Error(node, path, Seen(node) + " is not a whole number, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  if (*value < min || *value > max) {
    Error(node, path, Seen(node) + " is out of range, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  return value;
}

std::optional<uint64_t> YamlReader::ReadUint64(const YAML::Node& node, const std::string& path) {
  const std::optional<uint64_t> value =
      IsPlain(node) ? ParseWhole<uint64_t>(node.Scalar()) : std::nullopt;
  if (!value) Error(node, path, Seen(node) + ", allowed is a whole number from 0 to 2^64 - 1");
  return value;
}

std::optional<std::string> YamlReader::ReadText(const YAML::Node& node, const std::string& path) {
  if (node.IsScalar()) return node.Scalar();
  Error(node, path, Seen(node) + ", allowed is a text");
  return std::nullopt;
}

std::optional<double> YamlReader::ReadNumber(const YAML::Node& node, const std::string& path,
                                             const v1::FieldRule& rule) {
  const std::optional<double> value =
      IsPlain(node) ? ParseWhole<double>(node.Scalar()) : std::nullopt;
  if (!value) Error(node, path, Seen(node) + " is not a number, allowed " + AllowedRange(rule));
  return value;
}

bool YamlReader::ReadDistribution(const YAML::Node& node, const std::string& path,
                                  const v1::FieldRule& rule, v1::Distribution* out) {
  out->Clear();
  if (node.IsScalar()) {
    const std::optional<double> value = ReadNumber(node, path, rule);
    if (value) out->set_constant(*value);
    return value.has_value();
  }
  if (!node.IsMap() || node.size() != 1) {
    Error(node, path,
          (node.IsMap() ? fmt::format("a map with {} keys", node.size()) : Seen(node)) +
              ", allowed is " + kDistributionForms);
    return false;
  }
  const auto entries = Entries(node, path);
  if (entries.empty()) return false;
  const auto& [kind, value] = entries.front();
  const std::string kind_path = path + "." + kind;
  // The line of a distribution's own errors is that of its numbers.
  Note(value, path);
  Note(value, kind_path);
  if (kind != "bernoulli") return ReadNumbers(value, kind_path, kind, out);
  v1::FieldRule probability;
  probability.set_min(0);
  probability.set_max(1);
  const std::optional<double> p = ReadNumber(value, kind_path, probability);
  if (p) out->mutable_bernoulli()->set_p(*p);
  return p.has_value();
}

// The distributions that are lists of numbers.
bool YamlReader::ReadNumbers(const YAML::Node& node, const std::string& path,
                             const std::string& kind, v1::Distribution* out) {
  const struct {
    const char* kind;
    size_t size;  // 0: any.
    const char* form;
  } kForms[] = {{"uniform", 2, "[low, high]"},
                {"uniform_int", 2, "[low, high]"},
                {"choice", 0, "[a, b, ...] with at least one number"},
                {"clip_gaussian", 4, "[mean, std, low, high]"}};
  const auto* form = std::find_if(std::begin(kForms), std::end(kForms),
                                  [&](const auto& f) { return kind == f.kind; });
  if (form == std::end(kForms)) {
    Error(
        node, path,
        "no such distribution" +
            NearestHint(kind, {"uniform", "uniform_int", "choice", "clip_gaussian", "bernoulli"}) +
            ", allowed is " + kDistributionForms);
    return false;
  }
  if (!node.IsSequence() || (form->size != 0 && node.size() != form->size)) {
    Error(node, path,
          (node.IsSequence() ? fmt::format("a list of {}", node.size()) : Seen(node)) +
              ", allowed is " + form->form);
    return false;
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string number_path = fmt::format("{}[{}]", path, i);
    Note(node[i], number_path);
    const std::optional<double> number = ReadNumber(node[i], number_path, {});
    if (!number) continue;
    if (kind == "uniform_int" && *number != std::floor(*number)) {
      Error(node[i], number_path, Seen(node[i]) + " is not a whole number, allowed a whole number");
      continue;
    }
    numbers.push_back(*number);
  }
  if (numbers.size() < node.size()) return false;
  if (kind == "uniform") {
    out->mutable_uniform()->set_low(numbers[0]);
    out->mutable_uniform()->set_high(numbers[1]);
  } else if (kind == "uniform_int") {
    out->mutable_uniform_int()->set_low(WholeOf(numbers[0]));
    out->mutable_uniform_int()->set_high(WholeOf(numbers[1]));
  } else if (kind == "choice") {
    out->mutable_choice()->mutable_values()->Add(numbers.begin(), numbers.end());
  } else {
    auto* gaussian = out->mutable_clip_gaussian();
    gaussian->set_mean(numbers[0]);
    gaussian->set_std(numbers[1]);
    gaussian->set_low(numbers[2]);
    gaussian->set_high(numbers[3]);
  }
  return true;
}

std::optional<bool> YamlReader::ReadBool(const YAML::Node& node, const std::string& path) {
  if (IsPlain(node) && node.Scalar() == "true") return true;
  if (IsPlain(node) && node.Scalar() == "false") return false;
  Error(node, path, Seen(node) + ", allowed is true or false");
  return std::nullopt;
}

void YamlReader::SetField(const YAML::Node& node, const std::string& path,
                          const FieldDescriptor& field, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  const v1::FieldRule& rule = RuleOf(field);
  if (IsDistribution(field)) {
    v1::Distribution distribution;
    if (ReadDistribution(node, path, rule, &distribution)) {
      reflection.MutableMessage(message, &field)->CopyFrom(distribution);
    }
    return;
  }
  const auto int_bound = [](bool given, double bound, int64_t otherwise) {
    return given ? static_cast<int64_t>(bound) : otherwise;
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      Message* const group = reflection.MutableMessage(message, &field);
      auto* biomes = dynamic_cast<v1::BiomeWeights*>(group);
      if (biomes != nullptr && NamesAny(node)) ForbidAll(biomes);
      MergeFields(node, group, path);
      break;
    }
    case FieldDescriptor::CPPTYPE_ENUM: {
      const std::vector<std::string> names = EnumTexts(field);
      const bool known =
          node.IsScalar() && std::find(names.begin(), names.end(), node.Scalar()) != names.end();
      for (int i = 0; known && i < field.enum_type()->value_count(); ++i) {
        const auto* value = field.enum_type()->value(i);
        if (EnumText(*value) != node.Scalar()) continue;
        reflection.SetEnum(message, &field, value);
        return;
      }
      Error(node, path,
            Seen(node) + " is not known" +
                (node.IsScalar() ? NearestHint(node.Scalar(), names) : "") +
                " (allowed: " + JoinNames(names) + ")");
      break;
    }
    case FieldDescriptor::CPPTYPE_BOOL:
      if (const auto value = ReadBool(node, path)) reflection.SetBool(message, &field, *value);
      break;
    case FieldDescriptor::CPPTYPE_DOUBLE:
      if (const auto value = ReadNumber(node, path, rule)) {
        reflection.SetDouble(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_INT32:
      if (const auto value =
              ReadInt(node, path,
                      int_bound(rule.has_min(), rule.min(), std::numeric_limits<int32_t>::min()),
                      int_bound(rule.has_max(), rule.max(), std::numeric_limits<int32_t>::max()),
                      rule.unit())) {
        reflection.SetInt32(message, &field, static_cast<int32_t>(*value));
      }
      break;
    case FieldDescriptor::CPPTYPE_INT64:
      if (const auto value =
              ReadInt(node, path,
                      int_bound(rule.has_min(), rule.min(), std::numeric_limits<int64_t>::min()),
                      int_bound(rule.has_max(), rule.max(), std::numeric_limits<int64_t>::max()),
                      rule.unit())) {
        reflection.SetInt64(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_UINT64:
      if (const auto value = ReadUint64(node, path)) {
        reflection.SetUInt64(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_STRING:
      if (const auto value = ReadText(node, path)) {
        reflection.SetString(message, &field, *value);
      }
      break;
    default:
      Error(node, path, "this field can't be given in a file");
  }
}

void YamlReader::SetMessages(const YAML::Node& node, const std::string& path,
                             const FieldDescriptor& field, Message* message) {
  if (!node.IsSequence()) {
    std::string names;
    for (const std::string& name : FieldNames(*field.message_type())) {
      names += (names.empty() ? "" : ", ") + name;
    }
    Error(node, path, Seen(node) + ", allowed is a list of {" + names + "}");
    return;
  }
  const Reflection& reflection = *message->GetReflection();
  reflection.ClearField(message, &field);
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string item_path = fmt::format("{}[{}]", path, i);
    Note(node[i], item_path);
    Message* item = reflection.AddMessage(message, &field);
    if (i > kMaxListItems) continue;  // Can only be too many.
    MergeFields(node[i], item, item_path);
  }
}

void YamlReader::SetList(const YAML::Node& node, const std::string& path,
                         const FieldDescriptor& field, Message* message) {
  const v1::FieldRule& rule = RuleOf(field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    SetMessages(node, path, field, message);
    return;
  }
  const bool numbers = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (!node.IsSequence() || (!numbers && field.cpp_type() != FieldDescriptor::CPPTYPE_STRING)) {
    Error(node, path, Seen(node) + ", allowed is a list of " + (numbers ? "numbers" : "texts"));
    return;
  }
  if (static_cast<int>(node.size()) < rule.min_items()) {
    Error(node, path,
          fmt::format("an empty list, allowed is at least {}{}", rule.min_items(),
                      rule.allowed_size() > 0
                          ? " of " + JoinNames({rule.allowed().begin(), rule.allowed().end()})
                          : ""));
    return;
  }
  const Reflection& reflection = *message->GetReflection();
  reflection.ClearField(message, &field);
  std::vector<std::string> values;
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string item_path = fmt::format("{}[{}]", path, i);
    Note(node[i], item_path);
    if (numbers) {
      const std::optional<double> value = ReadNumber(node[i], item_path, rule);
      if (value) reflection.AddDouble(message, &field, *value);
      continue;
    }
    // A wrong item keeps its place, so later items are reported with their index in the file.
    values.push_back(ReadText(node[i], item_path).value_or(""));
  }
  for (std::string& value : values) reflection.AddString(message, &field, std::move(value));
}

}  // namespace parallax::config_internal
