#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/config/camera_settings.h"
#include "common/config/catalogue_names.h"
#include "common/config/check/biome_check.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/check/room_kind_check.h"
#include "common/config/config.h"
#include "common/config/config_text.h"
#include "common/config/frame_maps.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> Joined(std::vector<std::string> names,
                                const std::vector<std::string>& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

std::string WhyNotMaterial(const std::string& text) {
  const std::vector<std::string>& known = ObjectMaterialNames();
  const std::string wanted = Lower(text);
  if (std::any_of(known.begin(), known.end(),
                  [&](const std::string& name) { return Lower(name) == wanted; })) {
    return "";
  }
  return WhyNotKnown(text, known,
                     "a material or family that `parallax catalogue` lists for any object");
}

// A path that stays below the root it is joined to, without "..", "." or empty parts; behind
// "store:<64 hex digits>/" one whose content is in the store (common/store/content.h).
std::string WhyNotBelowRoot(const std::string& whole) {
  const bool stored = whole.starts_with("store:") && whole.size() > 71 && whole[70] == '/' &&
                      whole.find_first_not_of("0123456789abcdef", 6) == 70;
  const std::string text = stored ? whole.substr(71) : whole;
  constexpr char kAllowed[] =
      ", allowed is a folder below the worker's --picture-root, such as posters/large";
  if (text.empty()) return "";  // None wanted.
  if (text.front() == '/') {
    const std::string bare = text.substr(std::min(text.find_first_not_of('/'), text.size()));
    return Quoted(text) + " is an absolute path" + kAllowed +
           "; for `parallax run` that root is /" + (bare.empty() ? "" : ": write " + Quoted(bare)) +
           ", or give any folder of pictures by its --picture-dir";
  }
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find('/', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") {
      return Quoted(text) + " is not a plain path" + kAllowed;
    }
    begin = end + 1;
  }
  return "";
}

std::string WhyNotText(const std::string& text, const v1::FieldRule& rule) {
  if (text.size() > kMaxTextBytes) {
    return fmt::format("a text of {} bytes, allowed are at most {}", text.size(), kMaxTextBytes);
  }
  if (!IsPlainText(text)) {
    return Quoted(text) +
           " is not plain text, allowed is one line of UTF-8 without control "
           "characters and direction marks";
  }
  if (rule.allowed_size() > 0) {
    const std::vector<std::string> allowed(rule.allowed().begin(), rule.allowed().end());
    return WhyNotKnown(text, allowed, JoinNames(allowed));
  }
  switch (rule.names()) {
    case v1::FieldRule::NAMES_ASSET_CLASS:
      return WhyNotKnown(text, AssetClassNames(), "a class that `parallax catalogue` lists");
    case v1::FieldRule::NAMES_ASSET_CLASS_OR_GROUP:
      if (text == "own") return "";
      if (text.starts_with("own:")) {
        const std::string name = text.substr(4);
        return IsName(name) ? "" : WhyNotName(name);
      }
      return WhyNotKnown(text, Joined(AssetClassNames(), AssetGroupNames()),
                         JoinNames(AssetGroupNames()) +
                             ", own, own:FOLDER, or a class that `parallax catalogue` lists");
    case v1::FieldRule::NAMES_OBJECT_MATERIAL:
      return WhyNotMaterial(text);
    case v1::FieldRule::NAMES_FOLDER_BELOW_ROOT:
      return WhyNotBelowRoot(text);
    case v1::FieldRule::NAMES_BENCHMARK:
      return WhyNotKnown(text, BenchmarkNames(), JoinNames(BenchmarkNames()));
    case v1::FieldRule::NAMES_BASELINE:
      return WhyNotKnown(text, BaselineNames(), JoinNames(BaselineNames()));
    case v1::FieldRule::NAMES_GROUND_MATERIAL:
      return WhyNotKnown(text, GroundMaterialNames(), JoinNames(GroundMaterialNames()));
    case v1::FieldRule::NAMES_TRAINER:
      return IsName(text) ? "" : WhyNotName(text);
    default:
      return "";
  }
}

std::string WhyNotWhole(int64_t value, const v1::FieldRule& rule) {
  if (InRange(static_cast<double>(value), rule)) return "";
  return fmt::format("{} is out of range, allowed {}", value, AllowedRange(rule));
}

std::string WhyNotEnum(int number, const FieldDescriptor& field) {
  if (number == 0) return "";  // It stands for the default.
  const std::vector<std::string> names = EnumTexts(field);
  const auto* value = field.enum_type()->FindValueByNumber(number);
  const std::string seen = value == nullptr ? std::to_string(number) : EnumText(*value);
  if (std::find(names.begin(), names.end(), seen) != names.end()) return "";
  return seen + " is not known (allowed: " + JoinNames(names) + ")";
}

// The verdict on a field that is no list and no message; nothing if it is in order.
std::string WhyNotScalar(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  const v1::FieldRule& rule = RuleOf(field);
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return WhyNotNumber(reflection.GetDouble(message, &field), rule);
    case FieldDescriptor::CPPTYPE_INT32:
      return WhyNotWhole(reflection.GetInt32(message, &field), rule);
    case FieldDescriptor::CPPTYPE_INT64:
      return WhyNotWhole(reflection.GetInt64(message, &field), rule);
    case FieldDescriptor::CPPTYPE_ENUM:
      return WhyNotEnum(reflection.GetEnumValue(message, &field), field);
    case FieldDescriptor::CPPTYPE_STRING:
      return WhyNotText(reflection.GetString(message, &field), rule);
    default:
      return "";  // Every bool and every uint64 is allowed.
  }
}

// Checks a list: its length, and each of its texts, numbers or messages.
void CheckList(const Message& message, const std::string& path, const FieldDescriptor& field,
               Findings* findings) {
  const Reflection& reflection = *message.GetReflection();
  const int size = reflection.FieldSize(message, &field);
  if (size > kMaxListItems) {
    findings->push_back(
        {path, fmt::format("a list of {}, allowed are at most {}", size, kMaxListItems)});
    return;
  }
  for (int i = 0; i < size; ++i) {
    const std::string item_path = fmt::format("{}[{}]", path, i);
    std::string why;
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      why = WhyNotText(reflection.GetRepeatedString(message, &field, i), RuleOf(field));
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      why = WhyNotNumber(reflection.GetRepeatedDouble(message, &field, i), RuleOf(field));
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      CheckFields(reflection.GetRepeatedMessage(message, &field, i), item_path, findings);
    }
    if (!why.empty()) findings->push_back({item_path, std::move(why)});
  }
}

// Checks that no number is given for a sensor that is off.
void CheckSensorOff(const v1::SensorConfig& sensor, const std::string& path, Findings* findings) {
  const google::protobuf::Descriptor& type = *sensor.GetDescriptor();
  const FieldDescriptor& preset = *type.FindFieldByName("preset");
  std::vector<std::string> presets;
  for (const std::string& name : RuleOf(preset).allowed()) {
    if (name != "off") presets.push_back(name);
  }
  const v1::SceneConfig defaults = DefaultSceneConfig();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (&field == &preset || !sensor.GetReflection()->HasField(sensor, &field) ||
        !Differs(sensor, defaults.sensor(), field)) {
      continue;
    }
    findings->push_back({Dotted(path, field.name()),
                         "given, but sensor.preset is off, allowed with " + JoinNames(presets)});
  }
}

// Checks that the study keeps the maps from which a sensor makes its pictures.
void CheckSensor(const v1::SceneConfig& config, const std::string& path, Findings* findings) {
  const v1::SensorConfig& sensor = config.sensor();
  if (sensor.preset().empty() || sensor.preset() == "off") {
    return CheckSensorOff(sensor, Dotted(path, "sensor"), findings);
  }
  const auto tell = [&](const char* field, std::string what) {
    findings->push_back({Dotted(path, field), std::move(what)});
  };
  if (!config.render().keep_hdr()) {
    // At the sensor, which the user wrote: the other field is mostly a default.
    tell("sensor.preset", sensor.preset() +
                              ", which makes its pictures of what render.keep_hdr "
                              "keeps, allowed with render.keep_hdr: true");
  }
  if (HasMap(config.render(), "depth")) return;
  if (SupportOf(sensor.defocus_px()).high > 0) {
    tell("render.maps", "without depth, which sensor.defocus_px is worked out from");
  }
  if (SupportOf(sensor.exposure_ms()).high > 0) {
    tell("render.maps", "without depth, which the blur of sensor.exposure_ms is worked out from");
  }
}

// Checks that the maps are written that others need beside them.
void CheckMapsBeside(const v1::RenderConfig& render, const std::string& path, Findings* findings) {
  std::set<std::pair<std::string, std::string>> found;
  for (const FrameMap& row : FrameMaps()) {
    if (!row.IsIn(render)) continue;
    std::istringstream needs{std::string(row.needs)};
    for (std::string need; needs >> need;) {
      if (!Contains(FrameMapNames(), need) || HasMap(render, need)) continue;
      if (!found.emplace(row.map, need).second) continue;
      findings->push_back({path, fmt::format("{} without {}, allowed with both", row.map, need)});
    }
  }
}

// Checks that some landscape can be drawn. Weights that are absent have their defaults.
void CheckBiomes(const v1::NatureConfig& nature, const std::string& path, Findings* findings) {
  for (const v1::OwnBiome& own : nature.own_biomes()) {
    if (own.weight() > 0) return;
  }
  const v1::BiomeWeights& weights = nature.biomes();
  const google::protobuf::Descriptor& type = *weights.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const Reflection& reflection = *weights.GetReflection();
    if (!reflection.HasField(weights, type.field(i))) return;
    if (reflection.GetDouble(weights, type.field(i)) > 0) return;
  }
  findings->push_back({path, "all weights are 0, allowed is one above 0 at least"});
}

// Checks the lands of the user's own, and that they have names of their own.
void CheckOwnBiomes(const v1::NatureConfig& nature, const std::string& path, Findings* findings) {
  for (int i = 0; i < nature.biome_files_size(); ++i) {
    findings->push_back({fmt::format("{}.biome_files[{}]", path, i),
                         Quoted(nature.biome_files(i)) +
                             " is a file, allowed here is what it says, as own_biomes"});
  }
  std::vector<std::string> taken = BuiltinNames("biomes/");
  for (int i = 0; i < nature.own_biomes_size(); ++i) {
    const v1::Biome& biome = nature.own_biomes(i).biome();
    const std::string place = fmt::format("{}.own_biomes[{}].biome", path, i);
    if (Contains(taken, biome.name())) {
      findings->push_back({place + ".name", Quoted(biome.name()) +
                                                " is the name of another land, allowed is one of "
                                                "its own, that of the file or `name`"});
    }
    taken.push_back(biome.name());
    CheckBiome(biome, place, findings);
  }
}

}  // namespace

std::string WhyNotKnown(const std::string& text, const std::vector<std::string>& known,
                        const std::string& allowed) {
  if (Contains(known, text)) return "";
  return Quoted(text) + " is not known" + NearestHint(text, known) + " (allowed: " + allowed + ")";
}

void CheckFields(const Message& message, const std::string& path, Findings* findings) {
  const Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    const std::string field_path = Dotted(path, field.name());
    if (field.is_repeated()) {
      CheckList(message, field_path, field, findings);
    } else if (field.has_presence() && !reflection.HasField(message, &field)) {
      continue;
    } else if (IsDistribution(field)) {
      CheckDistribution(
          static_cast<const v1::Distribution&>(reflection.GetMessage(message, &field)), field_path,
          RuleOf(field), findings);
    } else if (IsQuantity(field)) {
      const auto& quantity =
          static_cast<const v1::Quantity&>(reflection.GetMessage(message, &field));
      // Formulas are checked with the names that they know (CheckBiome).
      if (quantity.has_formula()) continue;
      CheckDistribution(quantity.drawn(), field_path, RuleOf(field), findings);
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      CheckFields(reflection.GetMessage(message, &field), field_path, findings);
    } else {
      std::string why = WhyNotScalar(message, field);
      if (!why.empty()) findings->push_back({field_path, std::move(why)});
    }
  }
}

void CheckConfig(const v1::SceneConfig& config, const std::string& path, Findings* findings) {
  const size_t before = findings->size();
  CheckFields(config, path, findings);
  CheckRoomNames(config.room(), Dotted(path, "room"), findings);
  if (findings->size() > before) return;  // Each number by itself first.
  CheckSensor(config, path, findings);
  CheckMapsBeside(config.render(), Dotted(path, "render.maps"), findings);
  CheckOwnKinds(config.room(), Dotted(path, "room"), findings);
  CheckOwnBiomes(config.nature(), Dotted(path, "nature"), findings);
  CheckBiomes(config.nature(), Dotted(path, "nature.biomes"), findings);
  CheckSequences(config, path, findings);
  if (config.floating().placement() == v1::FloatingConfig::PLACEMENT_STREET &&
      config.type() != v1::SCENE_TYPE_DENSE) {
    findings->push_back({Dotted(path, "floating.placement"),
                         "street, but that is for scenes of type dense; allowed here are box and "
                         "view"});
  }
  const v1::RigConfig& rigs = config.rigs();
  const int64_t pixels = int64_t{rigs.width_px()} * rigs.height_px();
  if (pixels > kMaxPixels) {
    findings->push_back({Dotted(path, "rigs.height_px"),
                         fmt::format("{} x {} = {} pixels an image, allowed are at most {}",
                                     rigs.width_px(), rigs.height_px(), pixels, kMaxPixels)});
  }
  CheckCamera(config, path, findings);
}

}  // namespace parallax::config_internal
