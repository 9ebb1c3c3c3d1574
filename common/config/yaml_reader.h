// Inner part of common/config: fills a message from a YAML tree by reflection and collects the
// errors of values that don't fit their field's type. Whether a field may have a value is checked
// later by checks.h; the origins that the reader notes give its findings their file and line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/config/config_errors.h"
#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// Reads the tree of one file. Errors go to `errors`, which must outlive the reader. Not
// thread-safe.
class YamlReader {
 public:
  YamlReader(std::string file, ConfigErrors* errors) : file_(std::move(file)), errors_(errors) {}

  // Returns the document's root; nothing if the text is not YAML, which is then in `errors`. An
  // empty text gives a null node.
  std::optional<YAML::Node> Parse(std::string_view text);

  // Returns key and value of each entry of a map. Duplicate keys, keys that are not texts, and
  // nodes that are not maps go to `errors`.
  std::vector<std::pair<std::string, YAML::Node>> Entries(const YAML::Node& node,
                                                          const std::string& path);

  // Sets the fields of `message` that `node`, a map at `path` of the file, names. Nested messages
  // merge field by field; all other values replace. Notes the places of values in `origins`, unless
  // it is null.
  void Merge(const YAML::Node& node, google::protobuf::Message* message, const std::string& path,
             Origins* origins = nullptr);

  // Read a scalar. Return nothing for a wrong one, which is then in `errors`. Ranges are inclusive.
  std::optional<int64_t> ReadInt(const YAML::Node& node, const std::string& path, int64_t min,
                                 int64_t max, std::string_view unit = "");
  std::optional<uint64_t> ReadUint64(const YAML::Node& node, const std::string& path);
  std::optional<std::string> ReadText(const YAML::Node& node, const std::string& path);
  std::optional<bool> ReadBool(const YAML::Node& node, const std::string& path);
  // Returns the place of `node`, which is at `path` of this file.
  Origin OriginOf(const YAML::Node& node, std::string_view path) const;
  // Adds an error at `node`. UnknownField also suggests the most similar of the `known` names.
  void Error(const YAML::Node& node, std::string_view path, std::string_view what);
  void UnknownField(const YAML::Node& node, const std::string& path, const std::string& name,
                    const std::vector<std::string>& known);
  const std::string& file() const { return file_; }

 private:
  std::optional<double> ReadNumber(const YAML::Node& node, const std::string& path,
                                   const v1::FieldRule& rule);
  void MergeFields(const YAML::Node& node, google::protobuf::Message* message,
                   const std::string& path);
  // Checks the value of an unknown field by the rule of the known field that its name was probably
  // meant to be.
  void CheckMeant(const YAML::Node& node, const std::string& path, const std::string& meant,
                  const google::protobuf::Message& message);
  void Set(const YAML::Node& node, const std::string& path,
           const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  void Note(const YAML::Node& node, const std::string& path);
  bool ReadDistribution(const YAML::Node& node, const std::string& path, const v1::FieldRule& rule,
                        v1::Distribution* out);
  bool ReadNumbers(const YAML::Node& node, const std::string& path, const std::string& kind,
                   v1::Distribution* out);
  void SetField(const YAML::Node& node, const std::string& path,
                const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  void SetMessages(const YAML::Node& node, const std::string& path,
                   const google::protobuf::FieldDescriptor& field,
                   google::protobuf::Message* message);
  void SetList(const YAML::Node& node, const std::string& path,
               const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);

  std::string file_;
  ConfigErrors* errors_;
  Origins* origins_ = nullptr;  // During Merge.
  size_t prefix_ = 0;           // Length of the path of the message that Merge fills.
};

}  // namespace parallax::config_internal
