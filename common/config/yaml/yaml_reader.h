// Inner part of common/config: fills a message from a YAML tree by reflection and collects the
// errors of values that don't fit their field's type. Whether a field may have a value is checked
// later by checks.h; the origins that the reader notes give its findings their file and line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/yaml/yaml_values.h"
#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// Returns whether a map of weights gives any a number above 0. Then it names all that are wanted.
bool NamesAny(const YAML::Node& weights);

// A group of a config that may name files of the user's own, whose content takes their place.
struct OwnFiles {
  std::string files, content;  // Fields: the list of files, and that of messages they become.
  std::string folder;          // Built-in files of the kind.
  std::string part;            // Field of such a message that a file fills; empty: the whole.

  // Returns null for a group that names none.
  static const OwnFiles* Of(const google::protobuf::Descriptor& type);
};

// Fills messages from the tree of one file, and notes where their values stand. Not thread-safe.
class YamlReader : public YamlValues {
 public:
  using YamlValues::YamlValues;

  // Sets the fields of `message` that `node`, a map at `path` of the file, names. Nested messages
  // merge field by field; all other values replace. Notes the places of values in `origins`, unless
  // it is null.
  void Merge(const YAML::Node& node, google::protobuf::Message* message, const std::string& path,
             Origins* origins = nullptr);

  // Notes the place of `node` in the origins of the Merge that goes on.
  void Note(const YAML::Node& node, const std::string& path);

 private:
  void MergeFields(const YAML::Node& node, google::protobuf::Message* message,
                   const std::string& path);
  // Checks the value of an unknown field by the rule of the known field that its name was probably
  // meant to be.
  void CheckMeant(const YAML::Node& node, const std::string& path, const std::string& meant,
                  const google::protobuf::Message& message);
  void Set(const YAML::Node& node, const std::string& path,
           const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  void SetField(const YAML::Node& node, const std::string& path,
                const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  // Returns null for a name that the enum has not, which is then an error.
  const google::protobuf::EnumValueDescriptor* ReadEnum(
      const YAML::Node& node, const std::string& path,
      const google::protobuf::FieldDescriptor& field);
  template <typename Whole>
  std::optional<int64_t> ReadWhole(const YAML::Node& node, const std::string& path,
                                   const v1::FieldRule& rule);
  void SetMessages(const YAML::Node& node, const std::string& path,
                   const google::protobuf::FieldDescriptor& field,
                   google::protobuf::Message* message);
  void SetList(const YAML::Node& node, const std::string& path,
               const google::protobuf::FieldDescriptor& field, google::protobuf::Message* message);
  // Sets a list of texts, and the field that takes its items which are maps.
  void SetTextsAndMaps(const YAML::Node& node, const std::string& path,
                       const google::protobuf::FieldDescriptor& texts,
                       google::protobuf::Message* message);
  // Reads the files that `node` lists into `group`. Returns whether there were such files, whose
  // content is not overwritten by an empty list of it.
  bool ReadOwnFiles(const YAML::Node& node, const std::string& path, const OwnFiles& own,
                    google::protobuf::Message& group);
  void ReadFiles(const YAML::Node& files, const std::string& path, const OwnFiles& own,
                 google::protobuf::Message& group);
  // Reads the weights that the `biomes` of `node`, a config's `nature`, give to the user's lands.
  void ReadOwnWeights(const YAML::Node& node, const std::string& path, v1::NatureConfig& nature);
  void SetQuantity(const YAML::Node& node, const std::string& path, const v1::FieldRule& rule,
                   v1::Quantity& quantity);
  // Sets the fields of a message that has a list form, in their order.
  void SetInOrder(const YAML::Node& node, const std::string& path,
                  google::protobuf::Message* message);
  // Returns the value of a text with this rule: a path of own content as OwnPathOf gives it.
  std::string TextOf(std::string text, const v1::FieldRule& rule) const;

  Origins* origins_ = nullptr;           // During Merge.
  size_t prefix_ = 0;                    // Length of the path of the message that Merge fills.
  std::vector<std::string> own_biomes_;  // Names of the user's lands in the config at hand.
};

}  // namespace parallax::config_internal
