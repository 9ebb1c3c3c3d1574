#include "worker/scene/own_content.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "common/base/rng.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/materials/pictures/user_picture.h"

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

// Whether the keyframe is of a rig whose left eye is that of the rig before it.
bool SharesLeft(const v1::Scene& scene, int keyframe) {
  return keyframe > 0 && keyframe < scene.rigs_size() && scene.rigs(keyframe).shares_left();
}

// A left eye is rendered once, so all of its keyframes must show the same surroundings.
absl::Status CheckSharedSkies(const v1::Scene& scene) {
  for (int i = 1; i < scene.keyframes_size(); ++i) {
    const v1::Sky &sky = scene.keyframes(i).sky(), &before = scene.keyframes(i - 1).sky();
    if (!SharesLeft(scene, i) || (sky.environment() == before.environment() &&
                                  sky.environment_turn_rad() == before.environment_turn_rad())) {
      continue;
    }
    return InvalidArgument(
        "scene: keyframe {} shows other surroundings than keyframe {}, whose left eye its rig "
        "shares; wanted the same",
        i, i - 1);
  }
  return absl::OkStatus();
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
    RETURN_IF_ERROR(CheckSharedSkies(scene));
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
  uint64_t lefts = 0;  // Left eyes that have their surroundings.
  for (int i = 0; i < recipe.keyframes_size(); ++i) {
    v1::Sky& sky = *recipe.mutable_keyframes(i)->mutable_sky();
    if (SharesLeft(recipe, i)) {
      sky = v1::Sky(recipe.keyframes(i - 1).sky());
    } else {
      ChooseEnvironment(config, own, root.Child("keyframe", lefts++), sky);
    }
  }
  *recipe.mutable_sky() = recipe.keyframes(0).sky();
}

}  // namespace parallax
