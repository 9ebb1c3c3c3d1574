#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "worker/layout/room_shell.h"
#include "worker/materials/material.h"
#include "worker/materials/sets.h"
#include "worker/materials/user_picture.h"
#include "worker/scene/dress.h"
#include "worker/scene/room_materials.h"

namespace parallax {
namespace {

using Classes = std::vector<const MaterialClass*>;

constexpr int kPrints = 14;

// How many different members of a family a room's own things share: people buy in sets.
int PaletteSize(const std::string& family) {
  static const std::map<std::string, int> sizes = {
      {"wood", 3},        {"metal", 3},  {"paint", 3},           {"glass", 2},
      {"plastic", 4},     {"fabric", 4}, {"ApplianceEnamel", 2}, {"HousingPlastic", 2},
      {"BrushedMetal", 2}};
  const auto found = sizes.find(family);
  return found == sizes.end() ? 6 : found->second;
}

Classes ClassesTagged(bool MaterialTags::*tag, bool with_uv) {
  Classes classes = MaterialsTagged(tag);
  std::erase_if(classes, [&](const MaterialClass* c) { return c->tags.needs_uv && !with_uv; });
  return classes;
}

bool Prints(const MaterialSlot& slot) {
  return std::find(slot.families.begin(), slot.families.end(), "picture") != slot.families.end();
}

bool Names(const std::string& slot, std::string_view word) {
  return slot.find(word) != std::string::npos;
}

// What is printed on a slot: covers on books, labels on cans, paintings in frames.
Classes PrintsFor(const std::string& slot) {
  Classes classes = MaterialsOfFamily("picture");
  const auto keep = [&](std::string_view word) {
    std::erase_if(classes, [&](const MaterialClass* c) { return !Names(c->name, word); });
  };
  if (Names(slot, "cover")) {
    keep("BookCover");
  } else if (Names(slot, "label") || Names(slot, "front")) {
    keep("ProductLabel");
  } else if (Names(slot, "screen")) {
    keep("ScreenPicture");
  } else if (Names(slot, "page")) {
    keep("PrintedPage");
  } else {
    std::erase_if(classes, [](const MaterialClass* c) {
      return !Names(c->name, "Paint") && !Names(c->name, "Botanical") && !Names(c->name, "Poster");
    });
  }
  return classes.empty() ? MaterialsOfFamily("picture") : classes;
}

// Gives each drawn (class, seed) one entry of the recipe, in order of first use.
class MaterialTable {
 public:
  explicit MaterialTable(v1::Scene& recipe) : recipe_(recipe) {}

  uint32_t IndexOf(const MaterialClass& material, uint64_t seed) {
    return IndexOf(material.name, seed, "");
  }

  uint32_t IndexOf(const std::string& name, uint64_t seed, const std::string& picture_file) {
    auto [entry, is_new] = index_.try_emplace({name + ":" + picture_file, seed}, 0);
    if (is_new) {
      v1::SceneMaterial& added = *recipe_.add_materials();
      added.set_index(static_cast<uint32_t>(recipe_.materials_size()));
      added.set_name(name + "_" + std::to_string(added.index()));
      added.set_material_class(name);
      added.set_seed(seed);
      if (!picture_file.empty()) added.set_picture_file(picture_file);
      entry->second = added.index();
    }
    return entry->second;
  }

 private:
  v1::Scene& recipe_;
  std::map<std::pair<std::string, uint64_t>, uint32_t> index_;
};

class MaterialChooser {
 public:
  MaterialChooser(const v1::MaterialConfig& config, SceneInProgress& scene)
      : config_(config), scene_(scene), root_(scene.seed, "dress/material"), table_(scene.recipe) {}

  absl::Status Run() {
    RETURN_IF_ERROR(FindReplacements());
    if (!config_.picture_dir().empty()) {
      ASSIGN_OR_RETURN(pictures_, ListPictures(config_.picture_dir()));
    }
    for (v1::SceneObject& object : *scene_.recipe.mutable_objects()) {
      auto slots = SlotsOf(object);
      if (!slots.ok()) return WithContext(slots.status(), "object " + object.name());
      object.clear_materials();
      const Rng own = root_.Child("object/" + object.name());
      const bool lit = IsLit(object);
      for (const MaterialSlot& slot : *slots) {
        v1::MaterialBinding& binding = *object.add_materials();
        binding.set_slot(slot.name);
        binding.set_material_index(object.role() == v1::OBJECT_ROLE_ARCHITECTURE
                                       ? Architecture(object, slot)
                                       : OfObject(object, slot, own, lit));
      }
    }
    return absl::OkStatus();
  }

 private:
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
    }
    if (!config_.troublesome()) {
      std::erase_if(replacements_, [](const MaterialClass* c) { return IsTroublesome(*c); });
    }
    if (!replacements_.empty()) return absl::OkStatus();
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "materials.diffuse_material: no material of the catalogue is called \"" +
                         config_.diffuse_material() + "\"");
  }

  absl::StatusOr<std::vector<MaterialSlot>> SlotsOf(const v1::SceneObject& object) {
    if (!object.room_part().empty()) {
      ASSIGN_OR_RETURN(const Mesh mesh, MakeRoomPart(scene_.recipe, object));
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

  // One member of a family's palette in this room. `where` draws the class and the member.
  uint32_t FromPalette(const Classes& classes, const std::string& palette, int size, Rng where) {
    const uint64_t member = static_cast<uint64_t>(where.UniformInt(0, size - 1));
    Rng draw = root_.Child("palette/" + palette, member);
    const MaterialClass& material = *draw.Pick(classes);
    return table_.IndexOf(material, draw.Seed());
  }

  // Walls, floor and so on: one material for each slot name in a room. Joinery is alike in the
  // whole house; what walls and floors are made of goes by the kind of room.
  uint32_t Architecture(const v1::SceneObject& object, const MaterialSlot& slot) {
    const uint32_t index = object.room_index();
    const std::string& kind = RoomOf(scene_.recipe, object).kind();
    const std::string room = index == 0 ? "room/" : "room_" + std::to_string(index) + "/";
    const Rng where = root_.Child(room + slot.name);
    const auto of_room = [&](RoomSurface surface, const std::string& palette) {
      return FromPalette(RoomMaterials(kind, surface), index == 0 ? palette : room + palette, 1,
                         where);
    };
    if (slot.name == "wall") return of_room(RoomSurface::kWall, "wall");
    if (slot.name == "floor") return of_room(RoomSurface::kFloor, "floor");
    if (slot.name == "ceiling") return of_room(RoomSurface::kCeiling, "ceiling");
    if (slot.name == "cornice") {
      return FromPalette(MaterialsTagged(&MaterialTags::ceiling), "ceiling", 1, where);
    }
    // All joinery is painted alike; doors now and then are bare wood.
    if (slot.name == "skirting" || slot.name == "frame" || slot.name == "leaf") {
      const bool wood =
          root_.Child(slot.name == "leaf" ? "wooden leaf" : "wooden trim").Bernoulli(0.3);
      return FromPalette(MaterialsOfFamily(wood ? "wood" : "LacquerPaint"), wood ? "wood" : "trim",
                         1, where);
    }
    return FromFamilies(slot, root_.Child("room/" + slot.name), "room/" + slot.name, 1);
  }

  // The first family mostly, a later one now and then.
  uint32_t FromFamilies(const MaterialSlot& slot, Rng where, const std::string& palette, int size) {
    Classes chosen;
    std::string family;
    for (const std::string& name : slot.families) {
      Classes classes = name == "picture" ? PrintsFor(slot.name) : MaterialsOfFamily(name);
      // A slot that names a family leaves special classes alone unless it names one itself.
      const bool exact = classes.size() == 1 && classes[0]->family != name;
      if (!exact && !Prints(slot)) {
        std::erase_if(classes, [](const MaterialClass* c) {
          return !c->tags.any_object || c->tags.weathered;
        });
      }
      if (classes.empty()) continue;
      if (!chosen.empty() && where.Bernoulli(0.7)) continue;
      const bool keep = chosen.empty();
      chosen = classes;
      family = name;
      if (!keep || where.Bernoulli(0.65)) break;
    }
    if (chosen.empty()) {
      chosen = MaterialsOfFamily("plastic");
      family = "plastic";
    }
    return FromPalette(chosen, palette.empty() ? family : palette,
                       size > 0 ? size : PaletteSize(family), where);
  }

  uint32_t OfObject(const v1::SceneObject& object, const MaterialSlot& slot, const Rng& own,
                    bool lit) {
    if (slot.emissive) return Emissive(object, slot, own, lit);
    const bool all = config_.mode() == v1::MaterialConfig::MODE_ALL;
    if (!all || (!Prints(slot) && own.Child("replaced").Bernoulli(config_.replace_probability()))) {
      Rng draw = own.Child("replacement");
      const MaterialClass& material = *draw.Pick(replacements_);
      return table_.IndexOf(material, draw.Seed());
    }
    if (Prints(slot) && !pictures_.empty()) {
      Rng draw = own.Child("picture/" + slot.name);
      const std::string& file = draw.Pick(pictures_);
      return table_.IndexOf(kUserPicture, draw.Seed(), file);
    }
    const bool screen = Prints(slot) && Names(slot.name, "screen");
    if (Prints(slot) && !screen && object.relation() != "on_wall") {
      // Book covers and the like come from a small stock: a room has hundreds of them.
      return FromFamilies(slot, own.Child("slot/" + slot.name),
                          "print/" + PrintsFor(slot.name).front()->name, kPrints);
    }
    if (Prints(slot) || object.role() == v1::OBJECT_ROLE_FLOATING) {
      // Pictures on walls, screens and floating things share with nobody.
      return FromFamilies(slot, own.Child("slot/" + slot.name),
                          "own/" + object.name() + "/" + slot.name, 1);
    }
    // Equal models look alike: the address is the model's.
    const Rng model = root_.Child("model/" + object.asset_class() + "/" + slot.name, object.seed());
    return FromFamilies(slot, model, "", 0);
  }

  uint32_t Emissive(const v1::SceneObject& object, const MaterialSlot& slot, const Rng& own,
                    bool lit) {
    // A lamp that is not on shows a white bulb.
    const Classes classes = MaterialsOfFamily(lit ? "emissive" : "MattePlastic");
    return FromPalette(classes, "own/" + object.name() + "/" + slot.name, 1, own.Child("bulb"));
  }

  const v1::MaterialConfig& config_;
  SceneInProgress& scene_;
  Rng root_;
  MaterialTable table_;
  Classes replacements_;
  std::vector<std::string> pictures_;  // The user's.
};

}  // namespace

absl::Status ChooseMaterials(const v1::MaterialConfig& config, SceneInProgress& scene) {
  return MaterialChooser(config, scene).Run();
}

}  // namespace parallax
