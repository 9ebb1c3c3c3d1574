#include "coordinator/study/keys.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <bit>
#include <cctype>

#include "common/config/stages.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"

namespace parallax {
namespace {

// Parts are length-prefixed, so that no two lists of parts give the same bytes.
class KeyBuilder {
 public:
  explicit KeyBuilder(std::string_view stage) { Add(stage); }
  KeyBuilder& Add(std::string_view part) {
    Add(static_cast<uint64_t>(part.size()));
    bytes_.append(part);
    return *this;
  }
  KeyBuilder& Add(uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8)
      bytes_.push_back(static_cast<char>(number >> shift));
    return *this;
  }
  KeyBuilder& Add(const Sha256Digest& digest) {
    bytes_.append(reinterpret_cast<const char*>(digest.data()), digest.size());
    return *this;
  }
  Sha256Digest Finish() const { return Sha256Of(bytes_); }

 private:
  std::string bytes_;
};

void AddParts(const StageVersions& versions, std::span<const DataPart> parts, KeyBuilder& key) {
  key.Add(versions.layout).Add(versions.scene).Add(versions.frame);
  key.Add(static_cast<uint64_t>(parts.size()));
  for (const DataPart& part : parts) {
    key.Add(part.config.layout).Add(part.config.scene).Add(part.config.frame);
    key.Add(part.seed).Add(static_cast<uint64_t>(part.pairs));
    key.Add(static_cast<uint64_t>(part.rigs_per_scene));
    key.Add(std::bit_cast<uint64_t>(part.weight)).Add(part.filters);
  }
}

// A scene type's own fields stand in the message that has its name; other types do not read them,
// so that they and their defaults can change without touching those.
void ClearOtherTypes(v1::SceneConfig& config) {
  constexpr std::string_view kPrefix = "SCENE_TYPE_";
  const google::protobuf::EnumDescriptor& types = *v1::SceneType_descriptor();
  for (int i = 0; i < types.value_count(); ++i) {
    if (types.value(i)->number() == config.type()) continue;
    std::string name = types.value(i)->name().substr(kPrefix.size());
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto* field = v1::SceneConfig::descriptor()->FindFieldByName(name);
    if (field != nullptr) config.GetReflection()->ClearField(&config, field);
  }
}

}  // namespace

std::string DeterministicBytes(const google::protobuf::MessageLite& message) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    message.SerializeToCodedStream(&coded);
  }
  return bytes;
}

SceneSeed SceneSeedOf(uint64_t study_seed, uint32_t ordinal) {
  const Sha256Digest digest = KeyBuilder("scene-seed").Add(study_seed).Add(ordinal).Finish();
  uint64_t seed = 0;
  for (int i = 0; i < 8; ++i)
    seed |= static_cast<uint64_t>(digest[static_cast<size_t>(i)]) << (8 * i);
  return SceneSeed{seed};
}

ConfigDigests DigestsOf(const v1::SceneConfig& config) {
  v1::SceneConfig read = config;
  ClearOtherTypes(read);
  const auto digest = [&read](v1::FieldRule::Stage stage) {
    return Sha256Of(DeterministicBytes(FieldsOf(read, stage)));
  };
  return {digest(v1::FieldRule::LAYOUT), digest(v1::FieldRule::SCENE),
          digest(v1::FieldRule::FRAME)};
}

Sha256Digest LayoutKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed) {
  return KeyBuilder("layout").Add(versions.layout).Add(config.layout).Add(seed.value).Finish();
}

Sha256Digest SceneKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed) {
  return KeyBuilder("scene")
      .Add(versions.scene)
      .Add(config.scene)
      .Add(LayoutKey(versions, config, seed))
      .Finish();
}

Sha256Digest FrameKey(const StageVersions& versions, const ConfigDigests& config,
                      const Sha256Digest& scene_hash, uint32_t rig) {
  return KeyBuilder("frame")
      .Add(versions.frame)
      .Add(config.frame)
      .Add(scene_hash)
      .Add(static_cast<uint64_t>(rig))
      .Finish();
}

Sha256Digest RenderKey(const StageVersions& versions, const ConfigDigests& config,
                       const Sha256Digest& scene_hash, std::string_view rigs) {
  return KeyBuilder("render")
      .Add(versions.frame)
      .Add(config.frame)
      .Add(scene_hash)
      .Add(rigs)
      .Finish();
}

Sha256Digest TrainKey(const StageVersions& versions, std::string_view settings,
                      std::span<const DataPart> parts) {
  KeyBuilder key("train");
  key.Add(versions.train).Add(settings);
  AddParts(versions, parts, key);
  return key.Finish();
}

Sha256Digest EvaluateKey(const StageVersions& versions, std::string_view predictor,
                         std::string_view settings, std::span<const DataPart> heldout) {
  KeyBuilder key("evaluate");
  key.Add(versions.evaluate).Add(predictor).Add(settings);
  AddParts(versions, heldout, key);
  return key.Finish();
}

std::string StorePrefixOf(const Sha256Digest& work_key) {
  const std::string hex = HexOf(work_key);
  return hex.substr(0, 2) + "/" + hex;
}

}  // namespace parallax
