#include "common/config/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <sstream>

#include "common/config/config.h"
#include "common/config/field_rules.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr size_t kMostErrors = 20;

// Only plain scalars are numbers and booleans: "5" in quotes is text.
bool IsPlain(const YAML::Node& node) { return node.IsScalar() && node.Tag() == "?"; }

std::string Shown(std::string_view text) {
  constexpr size_t kMost = 60;
  std::string shown = "\"";
  for (const char c : text.substr(0, kMost)) {
    shown += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return shown + (text.size() > kMost ? "...\"" : "\"");
}

// What stands there, in words.
std::string Seen(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list";
  if (node.IsScalar()) return IsPlain(node) ? node.Scalar() : Shown(node.Scalar());
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

constexpr char kDistributionForms[] =
    "a number, {uniform: [low, high]}, {uniform_int: [low, high]}, {choice: [a, b, ...]}, "
    "{clip_gaussian: [mean, std, low, high]} or {bernoulli: p}";

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

void ConfigErrors::Add(std::string_view file, int line, std::string_view path,
                       std::string_view what) {
  if (lines_.size() == kMostErrors) {
    ++dropped_;
    return;
  }
  std::string text(file);
  if (line > 0) text += ":" + std::to_string(line);
  text += ": ";
  if (!path.empty()) text += std::string(path) + ": ";
  lines_.push_back(text += what);
}

absl::Status ConfigErrors::ToStatus() const {
  if (lines_.empty()) return absl::OkStatus();
  std::string message;
  for (const std::string& line : lines_) message += (message.empty() ? "" : "\n") + line;
  if (dropped_ > 0) message += "\nand " + std::to_string(dropped_) + " more";
  return absl::InvalidArgumentError(message);
}

void YamlReader::Error(const YAML::Node& node, std::string_view path, std::string_view what) {
  const YAML::Mark mark = node.Mark();
  errors_->Add(file_, mark.is_null() ? 0 : mark.line + 1, path, what);
}

std::optional<YAML::Node> YamlReader::Parse(std::string_view text) {
  constexpr size_t kMostBytes = 4 << 20;
  if (text.size() > kMostBytes) {
    errors_->Add(file_, 0, "", "larger than 4 MiB: not a configuration");
    return std::nullopt;
  }
  if (text.find('\0') != std::string_view::npos) {
    errors_->Add(file_, 0, "", "holds a NUL byte: not a text file");
    return std::nullopt;
  }
  try {
    // Not LoadAll: at a stray "," yaml-cpp finds one empty document after the other, for ever.
    DocumentCounter counter;
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (counter.documents < 2 && parser.HandleNextDocument(counter)) {
    }
    if (counter.documents > 1) {
      errors_->Add(file_, counter.last_line + 1, "", "a second YAML document, allowed is one");
    }
    return YAML::Load(std::string(text));
  } catch (const YAML::Exception& error) {
    errors_->Add(file_, error.mark.is_null() ? 0 : error.mark.line + 1, "",
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

void YamlReader::Merge(const YAML::Node& node, Message* message, const std::string& path) {
  const auto& type = *message->GetDescriptor();
  for (const auto& [name, value] : Entries(node, path)) {
    if (errors_->enough()) return;
    if (const FieldDescriptor* field = type.FindFieldByName(name)) {
      Set(value, Dotted(path, name), *field, message);
      continue;
    }
    const std::vector<std::string> known = FieldNames(type);
    UnknownField(value, path, name, known);
    // The value is checked as that of the field that was meant.
    if (const std::string meant = NearestName(name, known); !meant.empty()) {
      const std::unique_ptr<Message> scratch(message->New());
      Set(value, Dotted(path, meant), *type.FindFieldByName(meant), scratch.get());
    }
  }
  // A list of maps is told by Entries; the fields in it are checked nevertheless.
  for (size_t i = 0; node.IsSequence() && i < node.size() && !errors_->enough(); ++i) {
    if (node[i].IsMap()) Merge(node[i], message, path);
  }
}

void YamlReader::Set(const YAML::Node& node, const std::string& path, const FieldDescriptor& field,
                     Message* message) {
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

std::optional<std::string> YamlReader::ReadName(const YAML::Node& node, const std::string& path) {
  const std::optional<std::string> text = ReadText(node, path);
  if (!text) return std::nullopt;
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  const auto is_inner = [&](char c) { return is_plain(c) || c == '_' || c == '-'; };
  if (text->empty() || text->size() > 64 || !is_plain(text->front()) ||
      !std::all_of(text->begin(), text->end(), is_inner)) {
    Error(node, path,
          Shown(*text) +
              " can't be a folder's name, allowed are a-z, 0-9, _ and -, first a letter or digit, "
              "at most 64");
    return std::nullopt;
  }
  return text;
}

std::optional<double> YamlReader::ReadNumber(const YAML::Node& node, const std::string& path,
                                             const v1::FieldRule& rule) {
  const std::optional<double> value =
      IsPlain(node) ? ParseWhole<double>(node.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) {
    Error(node, path, Seen(node) + " is not a number, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  if (rule.integer() && *value != std::floor(*value)) {
    Error(node, path, Seen(node) + " is not a whole number, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  if (!InRange(*value, rule)) {
    Error(node, path, Seen(node) + " is out of range, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  return value;
}

bool YamlReader::CheckSupport(const YAML::Node& node, const std::string& path,
                              const v1::FieldRule& rule, const v1::Distribution& distribution) {
  const bool continuous = distribution.has_uniform() || distribution.has_clip_gaussian();
  if (rule.integer() && continuous) {
    Error(node, path,
          "gives fractions, allowed are whole numbers: a number, {uniform_int: [low, high]}, "
          "{choice: [a, b, ...]} or {bernoulli: p}");
    return false;
  }
  const Support support = SupportOf(distribution);
  if (InRange(support.low, rule) && InRange(support.high, rule)) return true;
  Error(node, path,
        "reaches from " + NumberText(support.low) + " to " + NumberText(support.high) +
            ", allowed " + AllowedRange(rule));
  return false;
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
          (node.IsMap() ? "a map with " + std::to_string(node.size()) + " keys" : Seen(node)) +
              ", allowed is " + kDistributionForms);
    return false;
  }
  const auto entries = Entries(node, path);
  if (entries.empty()) return false;
  const auto& [kind, value] = entries.front();
  const std::string kind_path = path + "." + kind;

  if (kind == "bernoulli") {
    v1::FieldRule probability;
    probability.set_min(0);
    probability.set_max(1);
    const std::optional<double> p = ReadNumber(value, kind_path, probability);
    if (!p) return false;
    out->mutable_bernoulli()->set_p(*p);
    return CheckSupport(value, path, rule, *out);
  }

  // The others are lists of numbers.
  const struct {
    const char* kind;
    size_t size;  // 0: any but none.
    const char* form;
  } kForms[] = {{"uniform", 2, "[low, high]"},
                {"uniform_int", 2, "[low, high]"},
                {"choice", 0, "[a, b, ...] with at least one number"},
                {"clip_gaussian", 4, "[mean, std, low, high]"}};
  const auto* form = std::find_if(std::begin(kForms), std::end(kForms),
                                  [&kind = kind](const auto& f) { return kind == f.kind; });
  if (form == std::end(kForms)) {
    Error(
        value, kind_path,
        "no such distribution" +
            NearestHint(kind, {"uniform", "uniform_int", "choice", "clip_gaussian", "bernoulli"}) +
            ", allowed is " + kDistributionForms);
    return false;
  }
  if (!value.IsSequence() || (form->size != 0 ? value.size() != form->size : value.size() == 0)) {
    Error(value, kind_path,
          (value.IsSequence() ? "a list of " + std::to_string(value.size()) : Seen(value)) +
              ", allowed is " + form->form);
    return false;
  }
  v1::FieldRule any;
  any.set_integer(kind == "uniform_int" || (kind == "choice" && rule.integer()));
  std::vector<double> numbers;
  for (size_t i = 0; i < value.size(); ++i) {
    const std::optional<double> number =
        ReadNumber(value[i], kind_path + "[" + std::to_string(i) + "]", any);
    if (number) numbers.push_back(*number);
  }
  if (numbers.size() < value.size()) return false;

  if (kind == "choice") {
    for (const double number : numbers) out->mutable_choice()->add_values(number);
    return CheckSupport(value, path, rule, *out);
  }
  const double low = numbers[numbers.size() - 2], high = numbers.back();
  if (low > high || (kind == "clip_gaussian" && low == high)) {
    Error(value, kind_path,
          "low " + NumberText(low) + " is not below high " + NumberText(high) + ", allowed is " +
              form->form + " with low < high");
    return false;
  }
  if (kind == "uniform") {
    out->mutable_uniform()->set_low(low);
    out->mutable_uniform()->set_high(high);
  } else if (kind == "uniform_int") {
    if (std::abs(low) > 1e15 || std::abs(high) > 1e15) {
      Error(value, kind_path, "too large, allowed is -1e15 to 1e15");
      return false;
    }
    out->mutable_uniform_int()->set_low(static_cast<int64_t>(low));
    out->mutable_uniform_int()->set_high(static_cast<int64_t>(high));
  } else {
    if (numbers[1] <= 0) {
      Error(value, kind_path, "std " + NumberText(numbers[1]) + ", allowed is above 0");
      return false;
    }
    auto* gaussian = out->mutable_clip_gaussian();
    gaussian->set_mean(numbers[0]);
    gaussian->set_std(numbers[1]);
    gaussian->set_low(low);
    gaussian->set_high(high);
  }
  return CheckSupport(value, path, rule, *out);
}

std::optional<std::string> YamlReader::ReadAllowedText(const YAML::Node& node,
                                                       const std::string& path,
                                                       const v1::FieldRule& rule) {
  std::optional<std::string> text = ReadText(node, path);
  if (!text || rule.allowed_size() == 0) return text;
  const std::vector<std::string> allowed(rule.allowed().begin(), rule.allowed().end());
  if (std::find(allowed.begin(), allowed.end(), *text) != allowed.end()) return text;
  Error(node, path,
        Shown(*text) + " is not known" + NearestHint(*text, allowed) +
            " (allowed: " + JoinNames(allowed) + ")");
  return std::nullopt;
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
    case FieldDescriptor::CPPTYPE_MESSAGE:
      Merge(node, reflection.MutableMessage(message, &field), path);
      break;
    case FieldDescriptor::CPPTYPE_ENUM: {
      const std::vector<std::string> names = EnumTexts(*field.enum_type());
      for (int i = 0; node.IsScalar() && i < field.enum_type()->value_count(); ++i) {
        const auto* value = field.enum_type()->value(i);
        if (value->number() == 0 || EnumText(*value) != node.Scalar()) continue;
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
      if (const auto value = ReadAllowedText(node, path, rule)) {
        reflection.SetString(message, &field, *value);
      }
      break;
    default:
      Error(node, path, "this field can't be given in a file");
  }
}

void YamlReader::SetList(const YAML::Node& node, const std::string& path,
                         const FieldDescriptor& field, Message* message) {
  const v1::FieldRule& rule = RuleOf(field);
  if (!node.IsSequence() || field.cpp_type() != FieldDescriptor::CPPTYPE_STRING) {
    Error(node, path, Seen(node) + ", allowed is a list of texts");
    return;
  }
  if (static_cast<int>(node.size()) < rule.min_items()) {
    Error(node, path,
          "an empty list, allowed is at least " + std::to_string(rule.min_items()) +
              (rule.allowed_size() > 0
                   ? " of " + JoinNames({rule.allowed().begin(), rule.allowed().end()})
                   : ""));
    return;
  }
  std::vector<std::string> values;
  for (size_t i = 0; i < node.size(); ++i) {
    const auto value = ReadAllowedText(node[i], path + "[" + std::to_string(i) + "]", rule);
    if (value) values.push_back(*value);
  }
  const Reflection& reflection = *message->GetReflection();
  reflection.ClearField(message, &field);
  for (std::string& value : values) reflection.AddString(message, &field, std::move(value));
}

}  // namespace parallax::config_internal
