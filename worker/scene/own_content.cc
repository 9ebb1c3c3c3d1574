#include "worker/scene/own_content.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "common/base/rng.h"
#include "worker/materials/environment_folder.h"
#include "worker/materials/user_picture.h"

namespace parallax {
namespace {

absl::Status CompareContent(const std::string& seen, const std::string& wanted,
                            const std::string& what) {
  if (wanted.empty() || seen == wanted) return absl::OkStatus();
  return DataLoss(
      "{}: its content is not that which the study was submitted with (it is {}, wanted {})", what,
      seen, wanted);
}

absl::StatusOr<std::string> LocatedFolder(const std::string& dir, const char* field) {
  absl::StatusOr<std::string> found = BelowPictureRoot(dir);
  if (!found.ok()) return WithContext(found.status(), field);
  return found;
}

template <typename Names>
absl::StatusOr<OwnMeshes> ReadMeshes(const Names& names) {
  std::vector<std::string> dirs;
  for (const std::string& name : names) {
    ASSIGN_OR_RETURN(dirs.emplace_back(), LocatedFolder(name, "assets.include"));
  }
  return ReadMeshFolders(dirs);
}

void ChooseEnvironment(const v1::LightingConfig& config, const OwnContent& own, const Rng& stream,
                       v1::Sky& sky) {
  if (!stream.Child("own").Bernoulli(config.hdri_p())) return;
  sky.set_environment(stream.Child("picture").Pick(own.environments));
  sky.set_environment_turn_rad(stream.Child("turn").Uniform(0, 2 * std::numbers::pi));
}

bool UsesMeshes(const v1::Scene& scene) {
  return std::any_of(scene.objects().begin(), scene.objects().end(), [](const auto& object) {
    return object.part().empty() && IsOwnClass(object.asset_class());
  });
}

bool UsesTextures(const v1::Scene& scene) {
  return std::any_of(scene.materials().begin(), scene.materials().end(), [](const auto& material) {
    return material.material_class().starts_with(kOwnPrefix);
  });
}

bool UsesEnvironments(const v1::Scene& scene) {
  return scene.sky().environment() != 0 ||
         std::any_of(scene.keyframes().begin(), scene.keyframes().end(),
                     [](const auto& keyframe) { return keyframe.sky().environment() != 0; });
}

absl::Status NoFolder(const char* what) {
  return InvalidArgument(
      "the scene uses {} of the user's, and nobody says in which folder they are", what);
}

}  // namespace

absl::StatusOr<OwnContent> ReadOwnContent(const v1::SceneConfig& config) {
  OwnContent own;
  if (!config.assets().include().empty()) {
    ASSIGN_OR_RETURN(OwnMeshes meshes, ReadMeshes(config.assets().include()));
    RETURN_IF_ERROR(
        CompareContent(meshes.sha256, config.assets().include_sha256(), "assets.include"));
    own.meshes = std::move(meshes.meshes);
  }
  if (const std::string& name = config.materials().texture_dir(); !name.empty()) {
    ASSIGN_OR_RETURN(const std::string dir, LocatedFolder(name, "materials.texture_dir"));
    ASSIGN_OR_RETURN(TextureFolder folder, ReadTextureFolder(dir));
    RETURN_IF_ERROR(CompareContent(folder.sha256, config.materials().textures_sha256(),
                                   "materials.texture_dir"));
    own.textures = std::move(folder.sets);
  }
  if (const std::string& name = config.lighting().hdri_dir(); !name.empty()) {
    ASSIGN_OR_RETURN(const std::string dir, LocatedFolder(name, "lighting.hdri_dir"));
    ASSIGN_OR_RETURN(EnvironmentFolder folder, ReadEnvironmentFolder(dir));
    RETURN_IF_ERROR(
        CompareContent(folder.sha256, config.lighting().hdris_sha256(), "lighting.hdri_dir"));
    own.environments = std::move(folder.seeds);
  }
  return own;
}

absl::Status LocateOwnContent(const v1::RenderJob& job) {
  const v1::Scene& scene = job.scene();
  if (UsesMeshes(scene)) {
    if (job.include().empty()) return NoFolder("meshes");
    RETURN_IF_ERROR(ReadMeshes(job.include()).status());
  }
  if (UsesTextures(scene)) {
    if (job.texture_dir().empty()) return NoFolder("texture sets");
    ASSIGN_OR_RETURN(const std::string dir,
                     LocatedFolder(job.texture_dir(), "materials.texture_dir"));
    RETURN_IF_ERROR(ReadTextureFolder(dir).status());
  }
  if (UsesEnvironments(scene)) {
    if (job.hdri_dir().empty()) return NoFolder("surroundings");
    ASSIGN_OR_RETURN(const std::string dir, LocatedFolder(job.hdri_dir(), "lighting.hdri_dir"));
    RETURN_IF_ERROR(ReadEnvironmentFolder(dir).status());
  }
  return absl::OkStatus();
}

void ChooseEnvironments(const v1::LightingConfig& config, const OwnContent& own, SceneSeed seed,
                        v1::Scene& recipe) {
  if (own.environments.empty()) return;
  const Rng root(seed, "dress/environment");
  if (recipe.keyframes().empty()) {
    ChooseEnvironment(config, own, root, *recipe.mutable_sky());
    return;
  }
  for (int i = 0; i < recipe.keyframes_size(); ++i) {
    ChooseEnvironment(config, own, root.Child("keyframe", static_cast<uint64_t>(i)),
                      *recipe.mutable_keyframes(i)->mutable_sky());
  }
  *recipe.mutable_sky() = recipe.keyframes(0).sky();
}

}  // namespace parallax
