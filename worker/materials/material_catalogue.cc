#include <algorithm>
#include <cctype>

#include "common/base/edit_distance.h"
#include "common/base/status.h"
#include "worker/materials/land/shore.h"

namespace parallax {
namespace {

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string NearestName(std::string_view wanted) {
  const auto& catalogue = MaterialCatalogue();
  return std::min_element(catalogue.begin(), catalogue.end(),
                          [&](const MaterialClass& a, const MaterialClass& b) {
                            return EditDistance(wanted, a.name, true) <
                                   EditDistance(wanted, b.name, true);
                          })
      ->name;
}

MaterialList BuildCatalogue() {
  MaterialList list;
  AddBarkMaterials(list);
  AddCarpetMaterials(list);
  AddCeramicMaterials(list);
  AddEnamelMaterials(list);
  AddFabricMaterials(list);
  AddFoliageMaterials(list);
  AddForestMaterials(list);
  AddGlassMaterials(list);
  AddGroundMaterials(list);
  AddLandMaterials(list);
  AddLeatherMaterials(list);
  AddMasonryMaterials(list);
  AddMetalMaterials(list);
  AddNatureMaterials(list);
  AddPaperMaterials(list);
  AddPictureMaterials(list);
  AddPlainMaterials(list);
  AddPlasticMaterials(list);
  AddPrintMaterials(list);
  AddShoreMaterials(list);
  AddSkinMaterials(list);
  AddStoneMaterials(list);
  AddTowelMaterials(list);
  AddWallMaterials(list);
  AddWallpaperMaterials(list);
  AddWoodMaterials(list);
  std::sort(list.begin(), list.end(),
            [](const MaterialClass& a, const MaterialClass& b) { return a.name < b.name; });
  return list;
}

}  // namespace

const std::vector<MaterialClass>& MaterialCatalogue() {
  static const MaterialList& catalogue = *new MaterialList(BuildCatalogue());
  return catalogue;
}

const MaterialClass* FindMaterialClass(std::string_view name) {
  const auto& catalogue = MaterialCatalogue();
  const auto found = std::lower_bound(catalogue.begin(), catalogue.end(), name,
                                      [](const MaterialClass& material, std::string_view wanted) {
                                        return material.name < wanted;
                                      });
  return found != catalogue.end() && found->name == name ? &*found : nullptr;
}

std::vector<const MaterialClass*> MaterialsOfFamily(std::string_view family_or_class) {
  const std::string wanted = Lower(family_or_class);
  std::vector<const MaterialClass*> members;
  for (const MaterialClass& material : MaterialCatalogue()) {
    if (material.family == wanted || Lower(material.name) == wanted) members.push_back(&material);
  }
  return members;
}

std::vector<const MaterialClass*> MaterialsTagged(bool MaterialTags::*tag) {
  std::vector<const MaterialClass*> members;
  for (const MaterialClass& material : MaterialCatalogue()) {
    if (material.tags.*tag) members.push_back(&material);
  }
  return members;
}

std::vector<std::string> MaterialFamilies() {
  std::vector<std::string> families;
  for (const MaterialClass& material : MaterialCatalogue()) families.push_back(material.family);
  std::sort(families.begin(), families.end());
  families.erase(std::unique(families.begin(), families.end()), families.end());
  return families;
}

absl::StatusOr<std::unique_ptr<const Material>> MakeMaterial(std::string_view class_name,
                                                             uint64_t seed) {
  const MaterialClass* found = FindMaterialClass(class_name);
  if (found == nullptr) {
    return NotFound("no material class \"{}\"; the nearest is \"{}\"", class_name,
                    NearestName(class_name));
  }
  Rng rng(SceneSeed{seed}, "material/" + found->name);
  return found->sample(rng);
}

}  // namespace parallax
