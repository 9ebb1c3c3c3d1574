// Inner part of common/config: puts a YAML tree into a message by reflection and collects what is
// wrong with it.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// The lines of one load, in order of discovery, at most 20.
class ConfigErrors {
 public:
  // `line` counts from 1; 0 = the file as a whole.
  void Add(std::string_view file, int line, std::string_view path, std::string_view what);
  bool empty() const { return lines_.empty(); }
  // So many that looking for more is a waste.
  bool enough() const { return lines_.size() + static_cast<size_t>(dropped_) >= 100; }
  // Errors: kInvalidArgument with all lines; OK without any.
  absl::Status ToStatus() const;

 private:
  std::vector<std::string> lines_;
  int dropped_ = 0;
};

// One file's tree. Errors go to `errors`, which outlives the reader.
class YamlReader {
 public:
  YamlReader(std::string file, ConfigErrors* errors) : file_(std::move(file)), errors_(errors) {}

  // The document's root; null when the text is no YAML (told to errors). An empty text gives a null
  // node.
  std::optional<YAML::Node> Parse(std::string_view text);

  // Key and value of each entry; tells of duplicates, odd keys and anything but a map.
  std::vector<std::pair<std::string, YAML::Node>> Entries(const YAML::Node& node,
                                                          const std::string& path);

  // Sets the fields that `node` (a map) names: messages merge field by field, all else replaces.
  // Goes on after what is wrong with the structure, so that one round tells all errors.
  void Merge(const YAML::Node& node, google::protobuf::Message* message, const std::string& path);

  // Scalars. Empty when wrong, which has been told then. Ranges are inclusive.
  std::optional<int64_t> ReadInt(const YAML::Node& node, const std::string& path, int64_t min,
                                 int64_t max, std::string_view unit = "");
  std::optional<uint64_t> ReadUint64(const YAML::Node& node, const std::string& path);
  std::optional<std::string> ReadText(const YAML::Node& node, const std::string& path);
  // [a-z0-9][a-z0-9_-]*, at most 64 characters: what may be a folder.
  std::optional<std::string> ReadName(const YAML::Node& node, const std::string& path);

  void Error(const YAML::Node& node, std::string_view path, std::string_view what);
  void UnknownField(const YAML::Node& node, const std::string& path, const std::string& name,
                    const std::vector<std::string>& known);
  const std::string& file() const { return file_; }

 private:
  std::optional<double> ReadNumber(const YAML::Node& node, const std::string& path,
                                   const v1::FieldRule& rule);
  bool ReadDistribution(const YAML::Node& node, const std::string& path, const v1::FieldRule& rule,
                        v1::Distribution* out);
  bool CheckSupport(const YAML::Node& node, const std::string& path, const v1::FieldRule& rule,
                    const v1::Distribution& distribution);
  void Set(const YAML::Node& node, const std::string& path,
           const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  void SetField(const YAML::Node& node, const std::string& path,
                const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  void SetList(const YAML::Node& node, const std::string& path,
               const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  std::optional<std::string> ReadAllowedText(const YAML::Node& node, const std::string& path,
                                             const v1::FieldRule& rule);
  std::optional<bool> ReadBool(const YAML::Node& node, const std::string& path);

  std::string file_;
  ConfigErrors* errors_;
};

}  // namespace parallax::config_internal
