#include "worker/scene/choose_materials.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "worker/materials/kernel/material.h"
#include "worker/materials/kernel/sets.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/user_picture.h"
#include "worker/scene/palettes.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

constexpr int kPrints = 14;

MaterialClasses ClassesTagged(bool MaterialTags::*tag, bool with_uv) {
  MaterialClasses classes = MaterialsTagged(tag);
  std::erase_if(classes, [&](const MaterialClass* c) { return c->tags.needs_uv && !with_uv; });
  return classes;
}

class MaterialChooser {
 public:
  MaterialChooser(const v1::MaterialConfig& config, const PartMaterialFn& part_material,
                  SceneInProgress& scene)
      : config_(config),
        part_material_(part_material),
        scene_(scene),
        root_(scene.seed, "dress/material"),
        palettes_(scene.recipe, root_) {}

  absl::Status Run() {
    RETURN_IF_ERROR(FindReplacements());
    if (!config_.picture_dir().empty()) RETURN_IF_ERROR(ReadPictures());
    for (v1::SceneObject& object : *scene_.recipe.mutable_objects()) {
      auto slots = SlotsOf(object);
      if (!slots.ok()) return WithContext(slots.status(), "object " + object.name());
      object.clear_materials();
      const Rng own = root_.Child("object/" + object.name());
      const bool lit = IsLit(object);
      for (const MaterialSlot& slot : *slots) {
        v1::MaterialBinding& binding = *object.add_materials();
        binding.set_slot(slot.name);
        binding.set_material_index(object.part().empty() ? OfObject(object, slot, own, lit)
                                                         : part_material_(object, slot, palettes_));
      }
    }
    return absl::OkStatus();
  }

 private:
  absl::Status ReadPictures() {
    ASSIGN_OR_RETURN(const std::string dir, BelowPictureRoot(config_.picture_dir()));
    ASSIGN_OR_RETURN(pictures_, ReadPictureFolder(dir));
    const std::string& wanted = config_.pictures_sha256();
    const std::string seen = ContentHashOf(pictures_);
    if (wanted.empty() || seen == wanted) return absl::OkStatus();
    return DataLoss(
        "picture_dir: the pictures in {} are not those that the study was submitted with (content "
        "{}, wanted {})",
        dir, seen, wanted);
  }

  absl::Status FindReplacements() {
    switch (config_.mode()) {
      case v1::MaterialConfig::MODE_NONE:
        replacements_ = MaterialsOfFamily("PlainGrey");
        break;
      case v1::MaterialConfig::MODE_ONE_DIFFUSE:
        replacements_ = MaterialsOfFamily(config_.diffuse_material());
        std::erase_if(replacements_, [](const MaterialClass* c) { return !c->tags.any_object; });
        break;
      case v1::MaterialConfig::MODE_METAL_GLASS:
        replacements_ = ClassesTagged(&MaterialTags::metal_or_glass, false);
        break;
      default:
        replacements_ = ClassesTagged(&MaterialTags::any_object, false);
        if (config_.replacements().empty()) break;
        std::erase_if(replacements_, [&](const MaterialClass* c) { return !IsChosen(*c); });
    }
    if (!config_.troublesome()) {
      std::erase_if(replacements_, [](const MaterialClass* c) { return IsTroublesome(*c); });
    }
    if (!replacements_.empty()) return absl::OkStatus();
    if (config_.mode() == v1::MaterialConfig::MODE_ALL) {
      return InvalidArgument(
          "materials.replacements: none of them can be the material of any object");
    }
    return InvalidArgument(
        "materials.diffuse_material: no material of the catalogue is called \"{}\"",
        config_.diffuse_material());
  }

  // Whether `replacements` names the material or its family.
  bool IsChosen(const MaterialClass& material) const {
    return std::any_of(config_.replacements().begin(), config_.replacements().end(),
                       [&](const std::string& name) {
                         const MaterialClasses named = MaterialsOfFamily(name);
                         return std::find(named.begin(), named.end(), &material) != named.end();
                       });
  }

  // Whether the object's slot gets a material of the catalogue; and the stream that draws which.
  std::optional<Rng> Replacement(const MaterialSlot& slot, const Rng& own) const {
    if (config_.mode() != v1::MaterialConfig::MODE_ALL) return own;
    if (Prints(slot)) return std::nullopt;
    const auto per = config_.replace_per();
    const bool part = per == v1::MaterialConfig::REPLACE_PER_PART;
    const Rng where = part ? own.Child("part/" + slot.name) : own;
    const Rng& coin = per == v1::MaterialConfig::REPLACE_PER_SCENE ? root_ : where;
    if (!coin.Child("replaced").Bernoulli(config_.replace_probability())) return std::nullopt;
    return where;
  }

  absl::StatusOr<std::vector<MaterialSlot>> SlotsOf(const v1::SceneObject& object) {
    if (!object.part().empty()) {
      ASSIGN_OR_RETURN(const Mesh mesh, MakePart(scene_.recipe, object));
      return mesh.slots;
    }
    ASSIGN_OR_RETURN(const PooledAsset* asset,
                     scene_.pool.Get(object.asset_class(), object.seed()));
    return asset->mesh->slots;
  }

  bool IsLit(const v1::SceneObject& object) const {
    return std::any_of(
        scene_.recipe.lights().begin(), scene_.recipe.lights().end(), [&](const v1::Light& light) {
          return light.kind() == v1::Light::KIND_MESH && light.object_index() == object.index();
        });
  }

  // The slot without metal, glass and mirrors, where the config leaves them out.
  MaterialSlot Allowed(MaterialSlot slot) const {
    if (!config_.has_metal_and_glass() || config_.metal_and_glass()) return slot;
    std::erase_if(slot.families, [](const std::string& name) {
      const MaterialClasses classes = MaterialsOfFamily(name);
      return std::any_of(classes.begin(), classes.end(), [](const MaterialClass* c) {
        return c->tags.metal_or_glass || IsTroublesome(*c);
      });
    });
    if (slot.families.empty()) slot.families.push_back("MattePlastic");
    return slot;
  }

  uint32_t OfObject(const v1::SceneObject& object, const MaterialSlot& slot, const Rng& own,
                    bool lit) {
    if (slot.emissive) return Emissive(object, slot, own, lit);
    const bool all = config_.mode() == v1::MaterialConfig::MODE_ALL;
    if (const std::optional<Rng> where = Replacement(slot, own)) {
      const std::vector<TextureSet>& sets = scene_.own.textures;
      if (all && !sets.empty() && where->Child("own texture").Bernoulli(config_.texture_p())) {
        const TextureSet& set = where->Child("texture set").Pick(sets);
        return palettes_.IndexOf(set.name, set.seed);
      }
      Rng draw = where->Child("replacement");
      const MaterialClass& material = *draw.Pick(replacements_);
      return palettes_.IndexOf(material.name, draw.Seed());
    }
    if (IsOwnClass(object.asset_class()) && HasOwnLooks(object, slot)) {
      return palettes_.IndexOf(OwnMeshMaterial(slot.name), object.seed());
    }
    if (Prints(slot) && !pictures_.empty()) {
      Rng draw = own.Child("picture/" + slot.name);
      const FolderFile& picture = draw.Pick(pictures_);
      return palettes_.IndexOf(kUserPicture, draw.Seed(), picture);
    }
    const bool screen = Prints(slot) && slot.name.find("screen") != std::string::npos;
    if (Prints(slot) && !screen && object.relation() != "on_wall") {
      // Book covers and the like come from a small stock: a room has hundreds of them.
      return palettes_.FromFamilies(slot, own.Child("slot/" + slot.name),
                                    "print/" + PrintsFor(slot.name).front()->name, kPrints);
    }
    const MaterialSlot allowed = Allowed(slot);
    if (Prints(slot) || object.role() == v1::OBJECT_ROLE_FLOATING) {
      // Pictures on walls, screens and floating objects are not shared.
      return palettes_.FromFamilies(allowed, own.Child("slot/" + slot.name),
                                    "own/" + object.name() + "/" + slot.name, 1);
    }
    // Equal models get equal materials: the address is the model's.
    const Rng model = root_.Child("model/" + object.asset_class() + "/" + slot.name, object.seed());
    return palettes_.FromFamilies(allowed, model, "", 0);
  }

  // Whether the user's mesh brings the slot's material.
  bool HasOwnLooks(const v1::SceneObject& object, const MaterialSlot& slot) const {
    const auto file = OpenOwnMesh(object.asset_class(), object.seed());
    if (!file.ok()) return false;  // SlotsOf has reported it.
    const auto& slots = (*file)->mesh.slots;
    for (size_t i = 0; i < slots.size(); ++i) {
      if (slots[i].name == slot.name) return (*file)->materials[i].looks.has_value();
    }
    return false;
  }

  uint32_t Emissive(const v1::SceneObject& object, const MaterialSlot& slot, const Rng& own,
                    bool lit) {
    // A lamp that is not on shows a white bulb.
    const MaterialClasses classes = MaterialsOfFamily(lit ? "emissive" : "MattePlastic");
    return palettes_.FromPalette(classes, "own/" + object.name() + "/" + slot.name, 1,
                                 own.Child("bulb"));
  }

  const v1::MaterialConfig& config_;
  const PartMaterialFn& part_material_;
  SceneInProgress& scene_;
  const Rng root_;
  Palettes palettes_;
  MaterialClasses replacements_;
  std::vector<FolderFile> pictures_;  // The user's.
};

}  // namespace

absl::Status ChooseMaterials(const v1::MaterialConfig& config, const PartMaterialFn& part_material,
                             SceneInProgress& scene) {
  return MaterialChooser(config, part_material, scene).Run();
}

}  // namespace parallax
