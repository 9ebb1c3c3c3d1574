#include "common/config/search/search_space.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/base/edit_distance.h"
#include "common/config/check/field_rules.h"
#include "common/config/config.h"

namespace parallax::config_internal {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

namespace {

// Reads `search.space` of one file.
class SpaceReader {
 public:
  SpaceReader(YamlReader& reader, v1::SearchSpec* search, Origins* origins)
      : reader_(reader), search_(*search), origins_(*origins) {}

  void Read(const YAML::Node& node) {
    for (const auto& [path, value] : reader_.Entries(node, "search.space")) {
      ReadField(path, value, "search.space." + path);
    }
  }

 private:
  void ReadField(const std::string& path, const YAML::Node& node, const std::string& place) {
    const auto known =
        std::find_if(search_.mutable_space()->begin(), search_.mutable_space()->end(),
                     [&](const auto& field) { return field.path() == path; });
    const bool is_new = known == search_.mutable_space()->end();
    if (node.IsNull() && !search_.space().empty()) return Remove(path, node, place);
    item_ = fmt::format("space[{}]", known - search_.mutable_space()->begin());
    v1::SearchField& field = is_new ? *search_.add_space() : *known;
    field.Clear();
    field.set_path(path);
    std::string ignored;
    const FieldDescriptor* const named = FindSearchField(path, &ignored);
    field.set_integer(named != nullptr && IsWhole(*named));
    Note("", node, place);
    Note(".path", node, place);
    const size_t errors_before = reader_.errors().size();
    for (const auto& [name, value] : reader_.Entries(node, place)) {
      const std::string at = Dotted(place, name);
      if (name == "range") {
        ReadRange(value, at, field);
      } else if (name == "choice") {
        ReadList(value, at, ".choices", *field.mutable_choices());
      } else if (name == "log") {
        Note(".log", value, at);
        field.set_log(reader_.ReadBool(value, at).value_or(false));
      } else if (name == "when") {
        ReadConditions(value, at, field);
      } else if (named != nullptr && IsGroup(*named) && FindKey(*named->message_type(), name)) {
        reader_.Error(value, at, "below its group, allowed is " + Dotted(path, name) + ": {...}");
      } else {
        reader_.UnknownField(value, place, name, {"range", "choice", "log", "when"});
      }
    }
    if (reader_.errors().size() > errors_before) {
      reader_.errors().SetTold(reader_.OriginOf(node, place));
    }
  }

  // Removes the field of an earlier file at `path`, which `node`, a null, says.
  void Remove(const std::string& path, const YAML::Node& node, const std::string& place) {
    std::vector<std::string> known;
    for (const v1::SearchField& field : search_.space()) known.push_back(field.path());
    const auto found = std::find(known.begin(), known.end(), path);
    if (found == known.end()) {
      return reader_.Error(node, place,
                           "nothing, which removes a field that the search has before" +
                               NearestHint(path, known) + " (allowed: " + JoinNames(known) + ")");
    }
    const int index = static_cast<int>(found - known.begin());
    search_.mutable_space()->DeleteSubrange(index, 1);
    origins_.EraseItem("space", index);
  }

  void ReadRange(const YAML::Node& node, const std::string& at, v1::SearchField& field) {
    Note(".low", node, at);
    Note(".high", node, at);
    if (!node.IsSequence() || node.size() != 2) {
      reader_.Error(node, at,
                    (node.IsSequence() ? fmt::format("a list of {}", node.size()) : Seen(node)) +
                        ", allowed is [low, high]");
      return;
    }
    const auto low = reader_.ReadNumber(node[0], at + "[0]", {});
    const auto high = reader_.ReadNumber(node[1], at + "[1]", {});
    if (!low || !high) reader_.errors().SetTold(reader_.OriginOf(node, at));
    field.set_low(low.value_or(0));
    field.set_high(high.value_or(0));
  }

  // Reads a list of any values as their texts. `member` is the field that they go into.
  void ReadList(const YAML::Node& node, const std::string& at, const std::string& member,
                google::protobuf::RepeatedPtrField<std::string>& texts) {
    Note(member, node, at);
    if (!node.IsSequence()) {
      return reader_.Error(node, at, Seen(node) + ", allowed is a list of values");
    }
    for (size_t i = 0; i < node.size(); ++i) {
      Note(fmt::format("{}[{}]", member, i), node[i], fmt::format("{}[{}]", at, i));
      *texts.Add() = FlowText(node[i]);
    }
  }

  void ReadConditions(const YAML::Node& node, const std::string& at, v1::SearchField& field) {
    for (const auto& [path, value] : reader_.Entries(node, at)) {
      const std::string member = fmt::format(".when[{}]", field.when_size());
      v1::SearchCondition& condition = *field.add_when();
      condition.set_path(path);
      const std::string place = Dotted(at, path);
      Note(member, value, place);
      Note(member + ".path", value, place);
      if (value.IsSequence()) {
        ReadList(value, place, member + ".values", *condition.mutable_values());
      } else {
        Note(member + ".values[0]", value, place);
        condition.add_values(FlowText(value));
      }
    }
  }

  void Note(const std::string& member, const YAML::Node& node, const std::string& place) {
    origins_.Set(item_ + member, reader_.OriginOf(node, place));
  }

  YamlReader& reader_;
  v1::SearchSpec& search_;
  Origins& origins_;
  std::string item_;  // The path of the field at hand, below the message.
};

std::string FieldText(const v1::SearchField& field) {
  std::string text =
      field.has_low() || field.has_high()
          ? fmt::format("{{range: [{}, {}]", NumberText(field.low()), NumberText(field.high()))
          : fmt::format("{{choice: [{}]", fmt::join(field.choices(), ", "));
  if (field.log()) text += ", log: true";
  std::string when;
  for (const v1::SearchCondition& condition : field.when()) {
    when += fmt::format("{}{}: [{}]", when.empty() ? "" : ", ", condition.path(),
                        fmt::join(condition.values(), ", "));
  }
  if (!when.empty()) text += ", when: {" + when + "}";
  return text + "}";
}

}  // namespace

void ReadSearch(YamlReader& reader, const YAML::Node& node, v1::SearchSpec* search,
                Origins* origins) {
  YAML::Node rest(YAML::NodeType::Map);
  const std::vector<std::string> known = FieldNames(*v1::SearchSpec::descriptor());
  for (const auto& [name, value] : reader.Entries(node, "search")) {
    const bool is_meant = name != "space" && NearestName(name, known) == "space";
    if (is_meant) reader.UnknownField(value, "search", name, known);
    if (name == "space" || is_meant) {
      origins->Set("space", reader.OriginOf(value, "search.space"));
      SpaceReader(reader, search, origins).Read(value);
    } else {
      rest[name] = value;
    }
  }
  reader.Merge(rest, search, "search", origins);
}

std::string SearchText(const v1::SearchSpec& search) {
  std::string text = "  space:" + std::string(search.space().empty() ? " {}\n" : "\n");
  for (const v1::SearchField& field : search.space()) {
    text += "    " + field.path() + ": " + FieldText(field) + "\n";
  }
  v1::SearchSpec wrapped = search;
  wrapped.clear_space();
  const std::string rest = MessageToYaml(wrapped);  // Its first line is the empty space.
  for (size_t begin = rest.find('\n') + 1; begin < rest.size();) {
    const size_t end = rest.find('\n', begin) + 1;
    text += "  " + rest.substr(begin, end - begin);
    begin = end;
  }
  return text;
}

const FieldDescriptor* FindSearchField(const std::string& path, std::string* why) {
  const Descriptor* type = v1::SceneConfig::descriptor();
  const FieldDescriptor* field = nullptr;
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    if (type == nullptr) {
      *why = path.substr(0, begin - 1) + " has no fields below it, allowed is its name alone";
      return nullptr;
    }
    field = FindKey(*type, name);
    if (field == nullptr) {
      const std::vector<std::string> known = FieldNames(*type);
      *why = "no such field" + NearestHint(name, known) + " (allowed: " + JoinNames(known) + ")";
      return nullptr;
    }
    type = IsGroup(*field) ? field->message_type() : nullptr;
    begin = end + 1;
  }
  return field;
}

bool IsGroup(const FieldDescriptor& field) {
  return field.message_type() != nullptr && !field.is_repeated() && !IsDistribution(field) &&
         !IsQuantity(field);
}

bool IsNumber(const FieldDescriptor& field) {
  if (field.is_repeated()) return false;
  return IsDistribution(field) || field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE ||
         field.cpp_type() == FieldDescriptor::CPPTYPE_INT32 ||
         field.cpp_type() == FieldDescriptor::CPPTYPE_INT64;
}

bool IsWhole(const FieldDescriptor& field) {
  return IsNumber(field) && field.cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE &&
         (!IsDistribution(field) || RuleOf(field).integer());
}

std::string FlowText(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << YAML::Flow << YAML::BeginSeq << node << YAML::EndSeq;
  const std::string list = emitter.c_str();
  return list.substr(1, list.size() - 2);
}

}  // namespace parallax::config_internal
