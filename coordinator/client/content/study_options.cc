#include "coordinator/client/content/study_options.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/edit_distance.h"
#include "common/base/hash.h"
#include "common/base/shell_word.h"
#include "common/base/system/log.h"
#include "common/base/version.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/config.h"
#include "common/config/config_text.h"
#include "common/config/content_folders.h"
#include "common/config/training_plan.h"
#include "common/store/content.h"
#include "coordinator/client/content/own_folders.h"
#include "coordinator/client/views/text.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/keys.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/evaluate/own_benchmark.h"

namespace parallax::client {
namespace {

// Clears the fields in which two submissions of the same study may differ.
v1::StudySpec WithoutIncidentals(v1::StudySpec study) {
  study.clear_source_yaml();
  study.clear_priority();
  study.clear_notify();
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
  if (options.picture_dir) {
    config.mutable_materials()->set_picture_dir(
        config_internal::OwnPathOf(*options.picture_dir, "./option"));
  }
}

}  // namespace

void AddStudyOptions(CLI::App& command, StudyOptions& options) {
  command.add_option("STUDY", options.study, "Study file, or the name of a built-in one")
      ->required();
  const std::string group = "Overrides of the study";
  command.add_option("--pairs", options.pairs, "Stereo pairs of each variant")->group(group);
  command
      .add_option("--scenes", options.scenes,
                  "Scenes of each variant, instead of --pairs: pairs = N x rigs per scene")
      ->group(group);
  command.add_option("--rigs", options.rigs, "Pairs of each scene")->group(group);
  command.add_option("--seed", options.seed, "Another seed: other scenes")
      ->check(WhyNotSeed)
      ->group(group);
  command.add_option("--samples", options.samples, "Samples a pixel")->group(group);
  command.add_option("--profile", options.profile, "preview, default, high or reference")
      ->group(group);
  command
      .add_option("--picture-dir", options.picture_dir,
                  "Your pictures for paintings, screens, covers and packages: a folder of this\n"
                  "machine, or a path below the workers' --picture-root")
      ->type_name("DIR")
      ->group(group);
  AddFollowLinksOption(command);
  command.add_option("--width", options.width, "Image width, pixels")->group(group);
  command.add_option("--height", options.height, "Image height, pixels")->group(group);
}

namespace {

// One side alone would change the pictures' shape.
absl::Status CheckSides(const StudyOptions& options, const v1::StudySpec& study) {
  if (options.width.has_value() == options.height.has_value()) return absl::OkStatus();
  for (const v1::VariantSpec& variant : study.variants()) {
    const int64_t width = variant.config().rigs().width_px();
    const int64_t height = variant.config().rigs().height_px();
    const int64_t new_width = options.width.value_or(width);
    const int64_t new_height = options.height.value_or(height);
    if (width <= 0 || height <= 0) continue;
    const int64_t kept = options.width ? (new_width * height + width / 2) / width
                                       : (new_height * width + height / 2) / height;
    if (kept == (options.width ? height : width)) continue;
    return InvalidArgument(
        "{} {} alone makes pictures of {} x {} out of {} x {}: give {} {} as well, which keeps "
        "their shape",
        options.width ? "--width" : "--height", options.width ? new_width : new_height, new_width,
        new_height, width, height, options.width ? "--height" : "--width", kept);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::StudySpec> ResolveStudy(const StudyOptions& options) {
  if (options.pairs && options.scenes) {
    return InvalidArgument("--pairs and --scenes say the same thing twice; give one of them");
  }
  ASSIGN_OR_RETURN(v1::StudySpec study, LoadStudy(options.study));
  if (options.pairs || options.scenes) study.clear_stream();
  if (study.has_stream() && !options.takes_endless) {
    return InvalidArgument(
        "study '{}' is endless: `parallax stream {}` begins it for trainings that take its pairs; "
        "--pairs N makes N pairs of each variant here",
        study.name(), ShellWord(options.study));
  }
  if (study.has_search() && !options.takes_search) {
    return InvalidArgument(
        "study '{}' is a search: `parallax search {}` begins it on a coordinator, `parallax plan` "
        "estimates its cost",
        study.name(), options.study);
  }
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
  const absl::Status sides = CheckSides(options, study);
  if (options.name) study.set_name(*options.name);
  if (options.seed) {
    for (const v1::VariantSpec& variant : study.variants()) {
      if (variant.seed() != 0 && variant.seed() == *options.seed && study.seed() != *options.seed) {
        return InvalidArgument("--seed: {} is the seed of variant '{}', which draws other scenes",
                               *options.seed, variant.name());
      }
    }
    study.set_seed(*options.seed);
  }
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
  RETURN_IF_ERROR(sides);
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
        "{}, as seen from here; where it is, `parallax config {} DIR` prints what to write as {}",
        what, field.command, field.sha256_name);
  }
  if (exists) return InvalidArgument("{}", what);
  return InvalidArgument("{}, and none of this path beside the study's file", what);
}

// Hashes a variant's folder, or list of folders.
absl::Status TakeHash(const FolderField& field, const std::vector<std::string>& dirs,
                      FolderReaders readers, ContentReports& reports, std::string* sha256) {
  const absl::StatusOr<const ContentReport*> seen = reports.Of(field.kind, dirs);
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
  if (!sha256->empty() && *sha256 != (*seen)->sha256) {
    return FailedPrecondition("the content of {} is not that of {} (it is {})", dirs.front(),
                              field.sha256_name, (*seen)->sha256);
  }
  *sha256 = (*seen)->sha256;
  return absl::OkStatus();
}

// Finds names of own classes that no folder has: its scenes would fail, or go without a word.
absl::Status CheckOwnClasses(const v1::SceneConfig& config,
                             const std::vector<std::string>& classes) {
  const auto check = [&](const char* field, const std::string& name) -> absl::Status {
    if (!IsOwnClass(name) || std::count(classes.begin(), classes.end(), name) > 0) {
      return absl::OkStatus();
    }
    return InvalidArgument("{}: assets.include has no mesh of \"{}\"{} (allowed: {})", field, name,
                           NearestHint(name, classes), fmt::join(classes, ", "));
  };
  for (const std::string& name : config.floating().classes()) {
    RETURN_IF_ERROR(check("floating.classes", name));
  }
  for (const v1::ClassWeight& weight : config.assets().weights()) {
    RETURN_IF_ERROR(check("assets.weights", weight.class_()));
  }
  return absl::OkStatus();
}

absl::Status HashContentOf(v1::SceneConfig& config, FolderReaders readers,
                           ContentReports& reports) {
  v1::MaterialConfig& materials = *config.mutable_materials();
  if (!materials.picture_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kPictureDir, {FromRoot(materials.picture_dir())}, readers, reports,
                             materials.mutable_pictures_sha256()));
  }
  if (!materials.texture_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kTextureDir, {FromRoot(materials.texture_dir())}, readers, reports,
                             materials.mutable_textures_sha256()));
  }
  v1::LightingConfig& lighting = *config.mutable_lighting();
  if (!lighting.hdri_dir().empty()) {
    RETURN_IF_ERROR(TakeHash(kHdriDir, {FromRoot(lighting.hdri_dir())}, readers, reports,
                             lighting.mutable_hdris_sha256()));
  }
  v1::AssetConfig& assets = *config.mutable_assets();
  if (!assets.include().empty()) {
    std::vector<std::string> dirs;
    for (const std::string& name : assets.include()) dirs.push_back(FromRoot(name));
    RETURN_IF_ERROR(TakeHash(kInclude, dirs, readers, reports, assets.mutable_include_sha256()));
    const absl::StatusOr<const ContentReport*> seen = reports.Of(ContentKind::kMeshes, dirs);
    if (seen.ok()) return CheckOwnClasses(config, (*seen)->classes);
  }
  return absl::OkStatus();
}

}  // namespace

std::string FromRoot(const std::string& dir) {
  const std::optional<ContentReference> reference = FindContentReference(dir);
  return "/" + (reference ? reference->path : dir);
}

namespace {

absl::Status HashBenchmark(v1::OwnBenchmark& own, FolderReaders readers) {
  const std::string path = FromRoot(PathOfBenchmark(own));
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    if (!own.sha256().empty()) return absl::OkStatus();
    return InvalidArgument("{} of this path beside the study's file, and no {}{}",
                           own.list().empty() ? "no folder" : "no file", path,
                           readers == FolderReaders::kOfFarm ? ", as seen from here" : "");
  }
  ASSIGN_OR_RETURN(const OwnBenchmarkFiles files, ReadOwnBenchmark(own, path));
  if (!own.sha256().empty() && own.sha256() != files.sha256) {
    return FailedPrecondition("the content of {} is not that of sha256 (it is {})", path,
                              files.sha256);
  }
  own.set_sha256(files.sha256);
  return absl::OkStatus();
}

// Asks for workers whose memory holds this item, and as much again for what is made of it, beside a
// scene. Small ones fit wherever a scene does.
void AskForMemory(const ContentItem& item, v1::StudySpec& study) {
  constexpr int64_t kSmallMb = 256, kSceneMb = 1024;
  const int64_t item_mb = 2 * item.memory_bytes >> 20;
  if (item_mb <= kSmallMb || study.memory_mb() >= kSceneMb + item_mb) return;
  study.set_memory_mb(std::min(kSceneMb + item_mb, kMaxMemoryMb));
  LogWarning("study", {{"note", fmt::format("{} takes {} MB while it is read: jobs go to workers "
                                            "with {} MB or more",
                                            item.name, item_mb, study.memory_mb())}});
}

}  // namespace

absl::Status HashContent(v1::StudySpec& study, FolderReaders readers) {
  ContentReports reports;
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    const absl::Status status = HashContentOf(*variant.mutable_config(), readers, reports);
    if (!status.ok()) return WithContext(status, "variant " + variant.name());
  }
  if (reports.largest()) AskForMemory(*reports.largest(), study);
  if (!study.has_evaluate()) return absl::OkStatus();
  for (v1::OwnBenchmark& own : *study.mutable_evaluate()->mutable_own_benchmarks()) {
    const absl::Status status = HashBenchmark(own, readers);
    if (!status.ok()) return WithContext(status, "evaluate.benchmarks: " + own.name());
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
