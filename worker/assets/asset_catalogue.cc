#include <algorithm>
#include <limits>
#include <string>

#include "common/base/edit_distance.h"
#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/assets/asset_families.h"
#include "worker/assets/detail.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/assets/kernel/detail_scope.h"

namespace parallax {
namespace {

std::vector<AssetClass> BuildCatalogue() {
  std::vector<AssetClass> classes;
  RegisterWindows(classes);
  RegisterKitchens(classes);
  RegisterStairs(classes);
  RegisterDoors(classes);
  RegisterAppliances(classes);
  RegisterBathroom(classes);
  RegisterChairs(classes);
  RegisterSofas(classes);
  RegisterTables(classes);
  RegisterStorage(classes);
  RegisterBeds(classes);
  RegisterBooks(classes);
  RegisterTableware(classes);
  RegisterLamps(classes);
  RegisterPlants(classes);
  RegisterNature(classes);
  RegisterWall(classes);
  RegisterTextiles(classes);
  RegisterMisc(classes);
  std::sort(classes.begin(), classes.end(),
            [](const AssetClass& a, const AssetClass& b) { return a.name < b.name; });
  return classes;
}

}  // namespace

const std::vector<AssetClass>& AssetCatalogue() {
  static const std::vector<AssetClass>& classes = *new std::vector<AssetClass>(BuildCatalogue());
  return classes;
}

const AssetClass* FindAssetClass(std::string_view name) {
  const std::vector<AssetClass>& classes = AssetCatalogue();
  const auto found =
      std::lower_bound(classes.begin(), classes.end(), name,
                       [](const AssetClass& c, std::string_view n) { return c.name < n; });
  return found != classes.end() && found->name == name ? &*found : nullptr;
}

absl::StatusOr<Asset> MakeAsset(std::string_view class_name, uint64_t seed) {
  if (IsOwnClass(class_name)) {
    ASSIGN_OR_RETURN(const std::shared_ptr<const MeshFile> file, OpenOwnMesh(class_name, seed));
    return Asset{file->mesh, {}};
  }
  const AssetClass* found = FindAssetClass(class_name);
  if (found == nullptr) {
    size_t least = std::numeric_limits<size_t>::max();
    std::string nearest;
    for (const AssetClass& c : AssetCatalogue()) {
      const size_t distance = EditDistance(class_name, c.name, true);
      if (distance < least) {
        least = distance;
        nearest = c.name;
      }
    }
    return NotFound("no asset class '{}'; the nearest is '{}'", class_name, nearest);
  }
  Rng rng(SceneSeed{seed}, "asset/" + found->name);
  return found->sample(rng);
}

absl::StatusOr<Asset> MakeAsset(std::string_view class_name, uint64_t seed, float target_edge_m) {
  if (target_edge_m != 0 && !(target_edge_m >= 0.0005f)) {
    return InvalidArgument("a target edge is 0 or at least half a millimetre");
  }
  const kernel::DetailScope scope(target_edge_m);
  return MakeAsset(class_name, seed);
}

}  // namespace parallax
