// Keys of results. A key is the SHA-256 of a stage's name, its version, the config fields that it
// reads (FieldRule.stage in config.proto) and the key of the stage before. Equal keys mean equal
// results, within a study and across studies, on every machine. Pure functions; thread-safe.
//
// Decisions. A change to any function here orphans every stored result: nothing breaks, but
// everything is made again. A frame's key covers the recipe's content rather than the recipe's key,
// so variants with equal recipes share frames. Keys cover the SHA-256 of a config's bytes rather
// than the bytes, so that a scene's keys cost microseconds. The stage `finish` stores nothing under
// a key: its verdicts are made whenever an archive is written.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/base/hash.h"
#include "common/base/ids.h"
#include "common/base/version.h"
#include "google/protobuf/message_lite.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// Serialises a message with sorted map entries: equal messages give equal bytes in every process of
// this build.
std::string DeterministicBytes(const google::protobuf::MessageLite& message);

// Returns the seed of scene `ordinal`. It is the same for all variants of a study with this seed,
// so that variants differ only by their configs (common random numbers).
SceneSeed SceneSeedOf(uint64_t study_seed, uint32_t ordinal);

// Digests of each stage's config fields, computed once for all scenes of a variant.
struct ConfigDigests {
  Sha256Digest layout;
  Sha256Digest scene;
  Sha256Digest frame;
};
// Returns the digests of a config.
ConfigDigests DigestsOf(const v1::SceneConfig& config);

// Return the keys of a layout and of a dressed scene.
Sha256Digest LayoutKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed);
Sha256Digest SceneKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed);
// Returns the key of one frame. `scene_hash` is the SHA-256 of the Scene's deterministic bytes.
Sha256Digest FrameKey(const StageVersions& versions, const ConfigDigests& config,
                      const Sha256Digest& scene_hash, uint32_t rig);
// Returns the key of one render job. `rigs` is its rigs as text, for example "0-19".
Sha256Digest RenderKey(const StageVersions& versions, const ConfigDigests& config,
                       const Sha256Digest& scene_hash, std::string_view rigs);

// The values that decide which pairs of a variant a training or evaluation reads.
struct DataPart {
  ConfigDigests config;
  uint64_t seed = 0;  // Seed of the variant's scenes.
  int64_t pairs = 0;
  uint32_t rigs_per_scene = 0;
  double weight = 1;
  std::string filters;  // Deterministic bytes of FilterConfig, which says what is left out.
};
// Returns the key of one training. `settings` is the deterministic bytes of everything else that
// decides the network. The key does not cover scenes that failed for good: their replacements give
// other pairs of the same distribution.
Sha256Digest TrainKey(const StageVersions& versions, std::string_view settings,
                      std::span<const DataPart> parts);
// Returns the key of one evaluation. `predictor` is the bytes of a training's key, or a baseline's
// name. `heldout` decides the pairs of the benchmark that the study makes itself.
Sha256Digest EvaluateKey(const StageVersions& versions, std::string_view predictor,
                         std::string_view settings, std::span<const DataPart> heldout);

// Returns the folder of the store for attempts at a job with this work key: "<2 hex>/<64 hex>".
std::string StorePrefixOf(const Sha256Digest& work_key);

}  // namespace parallax
