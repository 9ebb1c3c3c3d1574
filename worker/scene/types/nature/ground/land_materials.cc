#include "worker/scene/types/nature/ground/land_materials.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>

#include "common/math/proto.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/types/nature/ground/beach_tint.h"
#include "worker/scene/types/nature/ground/expand.h"
#include "worker/scene/types/nature/ground/prototypes.h"
#include "worker/scene/types/nature/rules/biomes.h"

namespace parallax {
namespace {

class LandMaterials {
 public:
  LandMaterials(const v1::Biome& biome, const Rng& root, v1::Scene& recipe, v1::Terrain& land)
      : biome_(biome), recipe_(recipe), land_(land), root_(root) {}

  absl::Status Run() {
    const std::vector<std::string> classes = GroundMaterials(biome_, land_);
    if (classes.size() != static_cast<size_t>(land_.ground_size())) {
      return InvalidArgument("terrain: {} ground rules, but {} materials", land_.ground_size(),
                             classes.size());
    }
    v1::SceneObject *ground = nullptr, *roof = nullptr;
    for (v1::SceneObject& object : *recipe_.mutable_objects()) {
      if (object.index() == land_.ground_object_index()) ground = &object;
      if (object.part() == "roof") roof = &object;
    }
    for (size_t i = 0; i < classes.size(); ++i) {
      // Rules have materials of their own, though their classes may be alike.
      const uint32_t index = AddMaterial(classes[i], SeedOf(classes[i] + "/"));
      if (classes[i] == "Gravel") {
        ASSIGN_OR_RETURN(const Vec3d tint, GravelTint(classes.front()));
        Tint(index, tint);
      }
      if (classes[i] == "Sand" && land_.has_water()) {
        ASSIGN_OR_RETURN(const Vec3d tint, BeachTint(SeedOf("Sand/")));
        Tint(index, tint);
      }
      // Between a meadow's tufts lie last year's blades and what is green below them.
      if (classes[i] == "ForestFloor" && !biome_.woods()) Tint(index, ThatchTint());
      land_.mutable_ground(static_cast<int>(i))->set_material_index(index);
      if (ground == nullptr) continue;
      v1::MaterialBinding& binding = *ground->add_materials();
      binding.set_slot(fmt::format("rule_{}", i));
      binding.set_material_index(index);
    }
    if (land_.has_water()) ChooseWater();
    if (roof != nullptr) {
      v1::MaterialBinding& binding = *roof->add_materials();
      binding.set_slot("rock");
      binding.set_material_index(AddMaterial(classes.back(), SeedOf(classes.back() + "/")));
    }
    for (v1::Prototype& prototype : *land_.mutable_prototypes()) {
      RETURN_IF_ERROR(BindSlots(prototype));
    }
    return absl::OkStatus();
  }

 private:
  uint32_t AddMaterial(const std::string& material_class, uint64_t seed) {
    v1::SceneMaterial& made = *recipe_.add_materials();
    made.set_index(static_cast<uint32_t>(recipe_.materials_size()));
    made.set_material_class(material_class);
    made.set_name(fmt::format("{}_{}", material_class, made.index()));
    made.set_seed(seed);
    return made.index();
  }

  void Tint(uint32_t index, const Vec3d& tint) {
    *recipe_.mutable_materials(static_cast<int>(index) - 1)->mutable_tint() = ToProto(tint);
  }

  // Scree is of the land's rock, which is darker than a path's gravel; shores are paler, and
  // beaches are like the sand that lies below their stones.
  absl::StatusOr<Vec3d> GravelTint(const std::string& below) const {
    if (biome_.red_rock()) return Vec3d(1.8, 1.12, 0.64);
    if (!land_.has_water()) return Vec3d(0.56, 0.54, 0.52);
    if (below != "Sand") return Vec3d(0.84, 0.81, 0.76);
    return ShingleTint(SeedOf("Gravel/"), SeedOf("Sand/"));
  }

  Vec3d ThatchTint() const {
    const bool dry = land_.season() == "winter" || land_.season() == "autumn";
    return dry ? Vec3d(0.85, 0.95, 0.8) : Vec3d(0.62, 1.0, 0.8);
  }

  // Things of one scene share what they are made of, as rock and grass of one place do; only leaves
  // of different plants differ.
  uint32_t MaterialFor(const std::string& material_class, const std::string& owner) {
    const std::string key = material_class + "/" + owner;
    const auto found = material_index_.find(key);
    if (found != material_index_.end()) return found->second;
    const uint32_t index = material_index_[key] = AddMaterial(material_class, SeedOf(key));
    // Larches are as bright as their new needles for some weeks of a year only.
    if (material_class == "FreshNeedle") Tint(index, {0.78, 0.7, 0.72});
    return index;
  }

  // Stones are of the rock that the ground is of.
  uint64_t SeedOf(const std::string& key) const {
    return root_.Child("material").Child(key).Seed();
  }

  void ChooseWater() {
    const uint32_t index = AddMaterial("StillWater", SeedOf("water"));
    land_.mutable_water()->set_material_index(index);
    for (v1::SceneObject& object : *recipe_.mutable_objects()) {
      if (object.index() != land_.water().object_index()) continue;
      v1::MaterialBinding& binding = *object.add_materials();
      binding.set_slot("water");
      binding.set_material_index(index);
    }
  }

  absl::Status BindSlots(v1::Prototype& prototype) {
    std::map<std::string, uint32_t> bound;
    for (uint32_t shape = 0; shape < prototype.shapes(); ++shape) {
      ASSIGN_OR_RETURN(const auto mesh, PrototypeMesh(prototype, shape, PlantDetail::kFar));
      for (const MaterialSlot& slot : mesh->slots) {
        if (bound.contains(slot.name)) continue;
        const std::string material_class = ClassFor(prototype, slot);
        if (material_class.empty()) continue;
        const bool own = slot.sheet && material_class.ends_with("Leaf");
        bound[slot.name] =
            MaterialFor(material_class, own ? prototype.asset_class() : std::string());
        v1::MaterialBinding& binding = *prototype.add_materials();
        binding.set_slot(slot.name);
        binding.set_material_index(bound[slot.name]);
      }
    }
    return absl::OkStatus();
  }

  // A class of the first family of the slot that has any; what the season changes.
  std::string ClassFor(const v1::Prototype& prototype, const MaterialSlot& slot) const {
    const std::string& season = land_.season();
    for (const std::string& family : slot.families) {
      const auto classes = MaterialsOfFamily(family);
      if (classes.empty()) continue;
      Rng rng = root_.Child("class").Child(prototype.asset_class()).Child(slot.name);
      std::string name = rng.Pick(classes)->name;
      if (prototype.season().empty() &&
          (name == "SummerLeaf" || name == "SpringLeaf" || name == "AutumnLeaf") &&
          CatalogueClass(prototype) != "LeafLitter") {
        if (season == "spring") name = "SpringLeaf";
        if (season == "summer") name = "SummerLeaf";
        if (season == "autumn") name = "AutumnLeaf";
      }
      // Moss needs the damp of woods.
      if (name == "MossyRock" && !biome_.woods()) name = "Rock";
      // Stones are of the rock that they broke from.
      if ((name == "Rock" || name == "Sandstone") && !biome_.woods()) {
        name = GroundMaterials(biome_, land_).back();
      }
      const double early = CatalogueClass(prototype) == "Reed" ? 0.85 : 0.35;
      const bool withers =
          biome_.red_rock() || season == "winter" || (season == "autumn" && rng.Bernoulli(early));
      if (name == "GrassBlade" && withers) name = "DryGrass";
      return name;
    }
    return {};
  }

  const v1::Biome& biome_;
  v1::Scene& recipe_;
  v1::Terrain& land_;
  const Rng root_;
  std::map<std::string, uint32_t> material_index_;
};

}  // namespace

absl::Status ChooseLandMaterials(const v1::NatureConfig& nature, const Rng& root, v1::Scene& recipe,
                                 v1::Terrain& land) {
  const v1::Biome* biome = FindBiome(nature, land.biome());
  if (biome == nullptr) return InvalidArgument("terrain: no biome \"{}\"", land.biome());
  return LandMaterials(*biome, root, recipe, land).Run();
}

namespace {

// The largest index of the recipe's own objects; 0: none.
uint32_t LastIndex(const v1::Scene& recipe) {
  uint32_t last = 0;
  for (const v1::SceneObject& part : recipe.objects()) last = std::max(last, part.index());
  return last;
}

}  // namespace

absl::Status CheckIndices(const v1::Scene& recipe, const Expansion& expansion) {
  constexpr uint64_t kMost = 65535;
  uint64_t objects = LastIndex(recipe);
  for (const uint32_t indices : expansion.indices) objects += indices;
  if (objects < kMost) return absl::OkStatus();
  return OutOfRange("terrain: {} objects with an index each, allowed are {}", objects, kMost - 1);
}

absl::Status CountLand(const v1::Scene& recipe,
                       const google::protobuf::RepeatedPtrField<v1::Rig>& views,
                       v1::Terrain& land) {
  land.clear_expansion_hash();
  ASSIGN_OR_RETURN(const auto expansion, ExpandTerrain(land, views));
  RETURN_IF_ERROR(CheckIndices(recipe, *expansion));
  NumberLayers(*expansion, LastIndex(recipe) + 1, land);
  land.set_expansion_hash(expansion->hash);
  land.set_instances(static_cast<uint32_t>(expansion->instances.size()));
  return absl::OkStatus();
}

}  // namespace parallax
