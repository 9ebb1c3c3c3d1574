// YAML, JSON and XML as fields.
#include <expat.h>
#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <memory>

#include "common/base/status.h"
#include "common/calibration/fields.h"

namespace parallax::calibration_internal {
namespace {

// Bound of a document's size, counted as its aliases repeat it: aliases that name each other make
// few lines stand for any number of values.
constexpr size_t kMostBytes = 24 << 20;
constexpr size_t kNodeBytes = 64;  // Counted for each value beside its text.
constexpr int kDeepest = 16;

// One document's tree, flattened.
class YamlFlattener {
 public:
  explicit YamlFlattener(Fields* fields) : fields_(fields) {}

  // Errors: kInvalidArgument for a document of more than kMostBytes.
  absl::Status Flatten(const YAML::Node& root, const std::string& file) {
    Add(root, "", 0);
    if (bytes_ <= kMostBytes) return absl::OkStatus();
    return InvalidArgument("{}: with its aliases written out it has more than {} bytes", file,
                           kMostBytes);
  }

 private:
  // Counts a value and its text. Returns whether the document is small enough so far.
  bool Count(const YAML::Node& node) {
    if (bytes_ <= kMostBytes) {
      bytes_ += kNodeBytes * (1 + (node.IsMap() ? node.size() : 0));
      bytes_ += node.IsScalar() ? node.Scalar().size() : 0;
    }
    return bytes_ <= kMostBytes;
  }

  void Add(const YAML::Node& node, const std::string& name, int depth) {
    if (depth > kDeepest || !Count(node)) return;
    bytes_ += name.size();
    if (node.IsMap()) {
      const YAML::Node rows = node["rows"], data = node["data"];
      if (rows && data && data.IsSequence()) return Add(data, name, depth + 1);
      for (const auto& entry : node) {
        if (!entry.first.IsScalar()) continue;
        Add(entry.second, (name.empty() ? "" : name + ".") + entry.first.Scalar(), depth + 1);
      }
    } else if (node.IsSequence() && IsNumbers(node, depth)) {
      fields_->Add(name, Numbers(node), LineOf(node));
    } else if (node.IsSequence()) {
      for (size_t i = 0; i < node.size(); ++i) {
        Add(node[i], fmt::format("{}[{}]", name, i), depth + 1);
      }
    } else if (node.IsScalar()) {
      fields_->Add(name, node.Scalar(), LineOf(node));
    }
  }

  static int LineOf(const YAML::Node& node) {
    return node.Mark().is_null() ? 0 : node.Mark().line + 1;
  }

  // Returns whether the node has only scalars, or lists of them. Counts what it visits.
  bool IsNumbers(const YAML::Node& node, int depth) {
    if (depth > kDeepest) return false;
    for (const YAML::Node& item : node) {
      if (!Count(item)) return false;
      if (!item.IsScalar() && !(item.IsSequence() && IsNumbers(item, depth + 1))) return false;
    }
    return true;
  }

  static std::string Numbers(const YAML::Node& node) {
    std::string text;
    for (const YAML::Node& item : node) {
      text += (item.IsScalar() ? item.Scalar() : Numbers(item)) + " ";
    }
    return text;
  }

  Fields* fields_;
  size_t bytes_ = 0;  // Counted so far.
};

// Elements right below the root are fields; what is in an element <data> of theirs is their
// value, where they have one.
class XmlReader {
 public:
  explicit XmlReader(Fields* fields) : fields_(fields), parser_(XML_ParserCreate(nullptr)) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &XmlReader::Open, &XmlReader::Close);
    XML_SetCharacterDataHandler(parser_.get(), &XmlReader::Characters);
    // No calibration declares entities; those of a hostile file could grow without bound.
    XML_SetEntityDeclHandler(
        parser_.get(), [](void* self, const XML_Char*, int, const XML_Char*, int, const XML_Char*,
                          const XML_Char*, const XML_Char*, const XML_Char*) {
          XML_StopParser(static_cast<XmlReader*>(self)->parser_.get(), XML_FALSE);
        });
  }

  absl::Status Read(std::string_view text, const std::string& file) {
    if (XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK) {
      return absl::OkStatus();
    }
    return InvalidArgument("{}:{}: not XML: {}", file, XML_GetCurrentLineNumber(parser_.get()),
                           XML_ErrorString(XML_GetErrorCode(parser_.get())));
  }

 private:
  static void Open(void* self, const XML_Char* name, const XML_Char**) {
    XmlReader& reader = *static_cast<XmlReader*>(self);
    ++reader.depth_;
    if (reader.depth_ == 2) {
      reader.name_ = name;
      reader.text_.clear();
      reader.data_.clear();
      reader.line_ = static_cast<int>(XML_GetCurrentLineNumber(reader.parser_.get()));
    }
    reader.in_data_ = reader.depth_ == 3 && std::string_view(name) == "data";
  }
  static void Close(void* self, const XML_Char*) {
    XmlReader& reader = *static_cast<XmlReader*>(self);
    if (reader.depth_ == 2) {
      reader.fields_->Add(reader.name_, reader.data_.empty() ? reader.text_ : reader.data_,
                          reader.line_);
    }
    reader.in_data_ = false;
    --reader.depth_;
  }
  static void Characters(void* self, const XML_Char* text, int length) {
    XmlReader& reader = *static_cast<XmlReader*>(self);
    if (reader.depth_ == 2) reader.text_.append(text, static_cast<size_t>(length));
    if (reader.in_data_) reader.data_.append(text, static_cast<size_t>(length));
  }

  struct Free {
    void operator()(XML_Parser parser) const { XML_ParserFree(parser); }
  };
  Fields* fields_;
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  int depth_ = 0, line_ = 0;
  bool in_data_ = false;
  std::string name_, text_, data_;
};

// cv::FileStorage also reads "data:[1, 2]"; YAML wants a blank after the colon of a key.
std::string WithBlanksAfterKeys(std::string_view text) {
  std::string spaced;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    const size_t key = line.find_first_not_of(' ');
    const size_t colon = line.find(':');
    const bool is_key = colon != line.npos && key < colon && line[key] != '%' && line[key] != '#' &&
                        line.find_first_of(" \t\"'[{,", key) > colon && colon + 1 < line.size() &&
                        line[colon + 1] != ' ' && line[colon + 1] != '\r';
    spaced += is_key ? std::string(line.substr(0, colon + 1)) + " " : "";
    spaced += is_key ? line.substr(colon + 1) : line;
    if (end < text.size()) spaced += '\n';
    begin = end + 1;
  }
  return spaced;
}

}  // namespace

absl::StatusOr<Fields> ReadYaml(std::string_view text, const std::string& file) {
  try {
    const bool of_opencv = text.find("opencv-matrix") != text.npos;
    const YAML::Node root = YAML::Load(of_opencv ? WithBlanksAfterKeys(text) : std::string(text));
    Fields fields(file);
    RETURN_IF_ERROR(YamlFlattener(&fields).Flatten(root, file));
    return fields;
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : fmt::format("{}:", error.mark.line + 1);
    return InvalidArgument("{}:{} neither YAML nor JSON: {}", file, line, error.msg);
  }
}

absl::StatusOr<Fields> ReadXml(std::string_view text, const std::string& file) {
  Fields fields(file);
  RETURN_IF_ERROR(XmlReader(&fields).Read(text, file));
  return fields;
}

}  // namespace parallax::calibration_internal
