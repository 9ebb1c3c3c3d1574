#include "common/config/yaml/yaml_document.h"

#include <fmt/core.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <sstream>

namespace parallax::config_internal {
namespace {

// Counts documents; knows the line of the last one's first node, and of aliases.
class DocumentCounter final : public YAML::EventHandler {
 public:
  int documents = 0;
  int last_line = 0;
  bool has_alias = false;

  void OnDocumentStart(const YAML::Mark& mark) override {
    ++documents;
    last_line = mark.line;
    empty_ = true;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { Content(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    has_alias = true;
    Content(mark);
  }
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

// Returns the first line, from 1, that is indented with a tab; 0 if none exists.
int LineWithTab(std::string_view text) {
  for (int line = 1; !text.empty(); ++line) {
    const std::string_view row = text.substr(0, text.find('\n'));
    const size_t begin = row.find_first_not_of(" \t\r");
    if (begin != std::string_view::npos && row.substr(0, begin).find('\t') != row.npos) return line;
    text.remove_prefix(std::min(row.size() + 1, text.size()));
  }
  return 0;
}

// yaml-cpp's own words speak of map values, block entries and flows.
void AddSyntaxError(const YAML::Exception& error, std::string_view text, const std::string& file,
                    ConfigErrors& errors) {
  const int line = error.mark.is_null() ? 0 : error.mark.line + 1;
  const int tab = LineWithTab(text);
  if (tab > 0 && (line == 0 || tab <= line)) {
    errors.Add({file, tab, ""},
               fmt::format("not YAML: line {} begins with a tab; indent with spaces", tab));
  } else if (error.msg == YAML::ErrorMsg::END_OF_MAP_FLOW ||
             error.msg == YAML::ErrorMsg::END_OF_SEQ_FLOW) {
    const bool map = error.msg == YAML::ErrorMsg::END_OF_MAP_FLOW;
    errors.Add({file, line, ""}, std::string("not YAML: a comma or the closing ") +
                                     (map ? "} of {name: value, ...}" : "] of [a, b, ...]") +
                                     " is missing in this line or before it");
  } else {
    errors.Add({file, line, ""}, "not YAML: " + error.msg);
  }
}

}  // namespace

std::optional<YAML::Node> ParseYaml(std::string_view text, const std::string& file,
                                    ConfigErrors& errors, size_t most_bytes) {
  if (text.size() > most_bytes) {
    errors.Add({file, 0, ""},
               fmt::format("larger than {} KiB: not a configuration", most_bytes >> 10));
    return std::nullopt;
  }
  if (text.find('\0') != std::string_view::npos) {
    errors.Add({file, 0, ""}, "holds a NUL byte: not a text file");
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
      errors.Add({file, counter.last_line + 1, ""}, "a second YAML document, allowed is one");
    }
    return YAML::Load(std::string(text));
  } catch (const YAML::Exception& error) {
    AddSyntaxError(error, text, file, errors);
    return std::nullopt;
  }
}

bool HasAlias(std::string_view text) {
  DocumentCounter counter;
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    parser.HandleNextDocument(counter);
  } catch (const YAML::Exception&) {
    return false;
  }
  return counter.has_alias;
}

}  // namespace parallax::config_internal
