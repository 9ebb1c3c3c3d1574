#include "coordinator/client/content/study_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/version.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/config.h"
#include "common/config/training_plan.h"
#include "common/store/content.h"
#include "coordinator/client/content/own_folders.h"
#include "coordinator/client/views/text.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/keys.h"

namespace parallax::client {
namespace {

constexpr char kBuiltinTrainer[] = "builtin";

// Clears the fields in which two submissions of the same study may differ.
v1::StudySpec WithoutIncidentals(v1::StudySpec study) {
  study.clear_source_yaml();
  study.clear_priority();
  return study;
}

// The file itself was in order, so what is wrong comes from an option; the variants would all say
// the same.
absl::Status OfOptions(const absl::Status& status) {
  if (status.ok()) return status;
  return MakeError(status.code(), "with these options " + FirstLine(ToStd(status.message())));
}

void ApplyToVariant(const StudyOptions& options, int rigs_per_scene, v1::SceneConfig& config) {
  v1::RigConfig& rigs = *config.mutable_rigs();
  // Rigs beyond the config's own number mean that more are chosen; fewer leave the choice as it is.
  const int eyes = EyesOfLeft(rigs);
  if (PairsOfScene(rigs) < rigs_per_scene) rigs.set_count((rigs_per_scene + eyes - 1) / eyes);
  if (options.width) rigs.set_width_px(*options.width);
  if (options.height) rigs.set_height_px(*options.height);
  if (options.samples) config.mutable_render()->set_samples_per_pixel(*options.samples);
  if (options.profile) config.mutable_render()->set_profile(*options.profile);
  if (options.picture_dir) config.mutable_materials()->set_picture_dir(*options.picture_dir);
}

}  // namespace

void AddStudyOptions(CLI::App& command, StudyOptions& options) {
  command.add_option("STUDY", options.study, "Study file, or the name of a built-in one")
      ->required();
  const std::string group = "Overrides of the study";
  command.add_option("--pairs", options.pairs, "Stereo pairs of each variant")->group(group);
  command.add_option("--scenes", options.scenes, "The same as scenes: pairs = N x rigs per scene")
      ->group(group);
  command.add_option("--rigs", options.rigs, "Pairs taken of each scene")->group(group);
  command.add_option("--seed", options.seed, "Another seed: other scenes")
      ->check(WhyNotSeed)
      ->group(group);
  command.add_option("--samples", options.samples, "Samples a pixel")->group(group);
  command.add_option("--profile", options.profile, "preview, default, high or reference")
      ->group(group);
  command
      .add_option("--picture-dir", options.picture_dir,
                  "Your pictures for paintings, screens, covers and packages: a path below the\n"
                  "workers' --picture-root (with `run`: any folder of this machine)")
      ->type_name("DIR")
      ->group(group);
  command.add_option("--width", options.width, "Image width, pixels")->group(group);
  command.add_option("--height", options.height, "Image height, pixels")->group(group);
}

absl::Status TakePicturesFromHere(StudyOptions& options) {
  if (!options.picture_dir) return absl::OkStatus();
  std::error_code error;
  const std::filesystem::path dir = std::filesystem::canonical(*options.picture_dir, error);
  if (error || !std::filesystem::is_directory(dir, error)) {
    return NotFound("--picture-dir: there is no folder {}", *options.picture_dir);
  }
  options.picture_dir = dir.relative_path().string();
  return absl::OkStatus();
}

absl::StatusOr<v1::StudySpec> ResolveStudy(const StudyOptions& options) {
  if (options.pairs && options.scenes) {
    return InvalidArgument("--pairs and --scenes say the same thing twice; give one of them");
  }
  ASSIGN_OR_RETURN(v1::StudySpec study, LoadStudy(options.study));
  const struct {
    const char* name;
    std::optional<int64_t> value;
  } positives[] = {{"--pairs", options.pairs},
                   {"--scenes", options.scenes},
                   {"--rigs", options.rigs},
                   {"--samples", options.samples}};
  for (const auto& option : positives) {
    if (option.value && *option.value < 1) {
      return InvalidArgument("{}: {} was given, at least 1 is needed", option.name, *option.value);
    }
    if (option.value && *option.value > kMaxPairs) {
      return InvalidArgument("{}: {} was given, at most {} is allowed", option.name, *option.value,
                             kMaxPairs);
    }
  }
  // The pairs that are held out follow from the rest; the options do not change their number.
  auto& variants = *study.mutable_variants();
  for (int i = variants.size(); i-- > 0;) {
    if (variants[i].heldout()) variants.DeleteSubrange(i, 1);
  }
  if (options.name) study.set_name(*options.name);
  if (options.seed) study.set_seed(*options.seed);
  if (options.rigs) study.set_rigs_per_scene(*options.rigs);
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    if (options.rigs) variant.clear_rigs_per_scene();
    // Variants that differ in size keep their proportions.
    if (options.pairs && variant.pairs() > 0) {
      const double share =
          static_cast<double>(variant.pairs()) / static_cast<double>(study.pairs());
      variant.set_pairs(
          std::max<int64_t>(1, std::llround(share * static_cast<double>(*options.pairs))));
    }
    if (options.scenes && (variant.pairs() > 0 || variant.rigs_per_scene() > 0)) {
      variant.set_pairs(*options.scenes * RigsPerSceneOf(study, variant));
    }
  }
  if (options.pairs) study.set_pairs(*options.pairs);
  if (options.scenes) study.set_pairs(*options.scenes * study.rigs_per_scene());
  if (options.priority) study.set_priority(*options.priority);
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    ApplyToVariant(options, RigsPerSceneOf(study, variant), *variant.mutable_config());
  }
  RETURN_IF_ERROR(OfOptions(ValidateStudy(study)));
  ResolveTraining(&study);
  return study;
}

namespace {

// A field of a config that names a folder of the user's content.
struct FolderField {
  ContentKind kind;
  const char* name;
  const char* sha256_name;
  const char* command;  // Subcommand of `parallax config`.
};
constexpr FolderField kPictureDir = {ContentKind::kPictures, "materials.picture_dir",
                                     "materials.pictures_sha256", "pictures"};
constexpr FolderField kTextureDir = {ContentKind::kTextures, "materials.texture_dir",
                                     "materials.textures_sha256", "textures"};
constexpr FolderField kHdriDir = {ContentKind::kHdris, "lighting.hdri_dir", "lighting.hdris_sha256",
                                  "hdris"};
constexpr FolderField kInclude = {ContentKind::kMeshes, "assets.include", "assets.include_sha256",
                                  "meshes"};

// Makes the error for a folder that has no such files here, or does not exist.
absl::Status NothingInFolder(const FolderField& field, const std::string& dir,
                             const absl::Status& seen, FolderReaders readers) {
  std::error_code error;
  const bool exists = std::filesystem::is_directory(dir, error);
  const std::string what = exists ? std::string(ToStd(seen.message()))
                                  : fmt::format("{}: no such folder {}", field.name, dir);
  if (readers == FolderReaders::kOfFarm) {
    return InvalidArgument(
        "{}, as seen from here; where it is, `parallax config {} DIR` tells what to write as {}",
        what, field.command, field.sha256_name);
  }
  if (exists) return InvalidArgument("{}", what);
  return InvalidArgument(
      "{}; `run` counts these paths from /: home/ada/own stands for "
      "/home/ada/own{}",
      what,
      field.kind == ContentKind::kPictures ? ", and its option --picture-dir takes any folder"
                                           : "");
}

// Hashes a variant's folder, or list of folders.
absl::Status TakeHash(const FolderField& field, const std::vector<std::string>& named,
                      FolderReaders readers, ContentHashes& hashes, std::string* sha256) {
  std::vector<std::string> dirs;
  for (const std::string& name : named) dirs.push_back(FromRoot(name));
  const absl::StatusOr<std::string> seen = hashes.Of(field.kind, dirs);
  if (absl::IsNotFound(seen.status())) {
    if (!sha256->empty()) return absl::OkStatus();
    std::error_code error;
    const auto missing = std::find_if(dirs.begin(), dirs.end(), [&](const std::string& dir) {
      return !std::filesystem::is_directory(dir, error);
    });
    return NothingInFolder(field, missing == dirs.end() ? dirs.front() : *missing, seen.status(),
                           readers);
  }
  RETURN_IF_ERROR(seen.status());
  if (!sha256->empty() && *sha256 != *seen) {
    return FailedPrecondition("the content of {} is not that of {} (it is {})", dirs.front(),
                              field.sha256_name, *seen);
  }
  *sha256 = *seen;
  return absl::OkStatus();
}

absl::Status HashContentOf(v1::SceneConfig& config, FolderReaders readers, ContentHashes& hashes) {
  v1::MaterialConfig& materials = *config.mutable_materials();
  if (!materials.picture_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kPictureDir, {materials.picture_dir()}, readers, hashes,
                             materials.mutable_pictures_sha256()));
  }
  if (!materials.texture_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kTextureDir, {materials.texture_dir()}, readers, hashes,
                             materials.mutable_textures_sha256()));
  }
  v1::LightingConfig& lighting = *config.mutable_lighting();
  if (!lighting.hdri_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kHdriDir, {lighting.hdri_dir()}, readers, hashes,
                             lighting.mutable_hdris_sha256()));
  }
  v1::AssetConfig& assets = *config.mutable_assets();
  if (!assets.include().empty()) {
    RETURN_IF_ERROR(TakeHash(kInclude, {assets.include().begin(), assets.include().end()}, readers,
                             hashes, assets.mutable_include_sha256()));
  }
  return absl::OkStatus();
}

}  // namespace

std::string FromRoot(const std::string& dir) {
  const std::optional<ContentReference> reference = FindContentReference(dir);
  return "/" + (reference ? reference->path : dir);
}

absl::Status HashContent(v1::StudySpec& study, FolderReaders readers) {
  ContentHashes hashes;
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    const absl::Status status = HashContentOf(*variant.mutable_config(), readers, hashes);
    if (!status.ok()) return WithContext(status, "variant " + variant.name());
  }
  return absl::OkStatus();
}

absl::Status CheckTrainer(const v1::StudySpec& study, const std::string& file,
                          const std::string& allowed, const std::string& trainers_dir) {
  if (!study.has_train()) return absl::OkStatus();
  const std::string& trainer = study.train().trainer();
  const int line = LineOfField(study.source_yaml(), "train.trainer");
  const std::string where =
      file + (line > 0 ? fmt::format(":{}", line) : "") + ": train.trainer: " + Quoted(trainer);
  const std::string names = allowed.empty() ? kBuiltinTrainer : allowed;
  if (("," + names + ",").find("," + trainer + ",") == std::string::npos) {
    return InvalidArgument("{} may not run here, allowed by --allow-trainers: {}", where, names);
  }
  std::error_code error;
  const std::string contract = trainers_dir + "/" + trainer + ".yaml";
  if (trainer == kBuiltinTrainer || std::filesystem::is_regular_file(contract, error)) {
    return absl::OkStatus();
  }
  return InvalidArgument("{}: {}", where,
                         trainers_dir.empty()
                             ? "name the folder with " + trainer + ".yaml by --trainers"
                             : "no such file " + contract);
}

absl::Status CheckGpu(const v1::StudySpec& study, const std::string& file,
                      const std::string& device) {
  const struct {
    const char* field;
    int gpus;
  } needs[] = {{"train.needs.gpus", study.train().needs().gpus()},
               {"evaluate.needs.gpus", study.evaluate().needs().gpus()}};
  std::error_code error;
  for (const auto& need : needs) {
    if (need.gpus == 0 || std::filesystem::exists(device, error)) continue;
    const int line = LineOfField(study.source_yaml(), need.field);
    return InvalidArgument("{}{}: {}: {}, but this machine has no GPU ({} is missing)", file,
                           line > 0 ? fmt::format(":{}", line) : "", need.field, need.gpus, device);
  }
  return absl::OkStatus();
}

std::string DescribeSize(const v1::StudySpec& study) {
  const bool alike = std::all_of(study.variants().begin(), study.variants().end(),
                                 [](const auto& variant) { return variant.pairs() == 0; });
  const std::string variants = Plural(study.variants_size(), "variant");
  return alike ? variants + " x " + Plural(study.pairs(), "pair")
               : variants + ", " + Plural(TotalPairsOf(study), "pair") + " in all";
}

std::string IdempotencyKey(const v1::StudySpec& study) {
  return Sha256Hex("study " + DescribeVersions() + "\n" +
                   DeterministicBytes(WithoutIncidentals(study)));
}

}  // namespace parallax::client
