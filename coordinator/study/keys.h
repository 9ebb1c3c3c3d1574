// Keys of results: SHA-256 over a stage's name, its version, the config fields that it reads
// (FieldRule.stage in config.proto) and the key of the stage before. Equal keys mean equal results,
// within a study and across studies, on every machine. Pure functions; thread-safe.
//
// Decisions: a change to any function here orphans every stored result (nothing breaks, everything
// is made again). A frame follows its recipe's content rather than the recipe's key: variants whose
// recipes come out alike share frames. A key takes the SHA-256 of a config's bytes rather than the
// bytes, so that a scene's keys cost microseconds. The stage `finish` stores nothing under a key:
// its verdicts are made whenever an archive is written.
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

// Serialised with map entries sorted: the same message gives the same bytes in every process of
// this build.
std::string DeterministicBytes(const google::protobuf::MessageLite& message);

// Of scene `ordinal` of every variant of a study with this seed: common random numbers.
SceneSeed SceneSeedOf(uint64_t study_seed, uint32_t ordinal);

// The config fields of each stage alone, digested once for all scenes of a variant.
struct ConfigDigests {
  Sha256Digest layout;
  Sha256Digest scene;
  Sha256Digest frame;
};
ConfigDigests DigestsOf(const v1::SceneConfig& config);

Sha256Digest LayoutKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed);
Sha256Digest SceneKey(const StageVersions& versions, const ConfigDigests& config, SceneSeed seed);
// `scene_hash` is the SHA-256 of the Scene's deterministic bytes.
Sha256Digest FrameKey(const StageVersions& versions, const ConfigDigests& config,
                      const Sha256Digest& scene_hash, uint32_t rig);
// Of one render job: its rigs as text, for example "0-19".
Sha256Digest RenderKey(const StageVersions& versions, const ConfigDigests& config,
                       const Sha256Digest& scene_hash, std::string_view rigs);

// A variant's pairs as a training or evaluation reads them: what decides which pairs they are.
struct DataPart {
  ConfigDigests config;
  uint64_t seed = 0;  // Its scenes are drawn from this seed.
  int64_t pairs = 0;
  uint32_t rigs_per_scene = 0;
  double weight = 1;
  std::string filters;  // Deterministic bytes of FilterConfig, which says what is left out.
};
// Key of one training. `settings` is the deterministic bytes of all else that decides the network.
// The key does not know of scenes that failed for good: their replacements give other pairs of the
// same distribution.
Sha256Digest TrainKey(const StageVersions& versions, std::string_view settings,
                      std::span<const DataPart> parts);
// Key of one evaluation. `predictor` is the bytes of a training's key, or a baseline's name;
// `heldout` names the pairs of the benchmark that the study makes itself.
Sha256Digest EvaluateKey(const StageVersions& versions, std::string_view predictor,
                         std::string_view settings, std::span<const DataPart> heldout);

// Where the attempts of a job with this work key write: "<2 hex>/<64 hex>".
std::string StorePrefixOf(const Sha256Digest& work_key);

}  // namespace parallax
