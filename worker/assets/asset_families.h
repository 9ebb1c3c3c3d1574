// The families' registration functions: each appends its classes. AssetCatalogue calls them all.
#pragma once

#include <vector>

#include "worker/assets/asset.h"

namespace parallax {

// Each function appends the classes of one family.
void RegisterWindows(std::vector<AssetClass>& classes);
void RegisterKitchens(std::vector<AssetClass>& classes);
void RegisterStairs(std::vector<AssetClass>& classes);
void RegisterDoors(std::vector<AssetClass>& classes);
void RegisterAppliances(std::vector<AssetClass>& classes);
void RegisterBathroom(std::vector<AssetClass>& classes);
void RegisterChairs(std::vector<AssetClass>& classes);
void RegisterSofas(std::vector<AssetClass>& classes);
void RegisterTables(std::vector<AssetClass>& classes);
void RegisterStorage(std::vector<AssetClass>& classes);
void RegisterBeds(std::vector<AssetClass>& classes);
void RegisterBooks(std::vector<AssetClass>& classes);
void RegisterTableware(std::vector<AssetClass>& classes);
void RegisterLamps(std::vector<AssetClass>& classes);
void RegisterPlants(std::vector<AssetClass>& classes);
void RegisterNature(std::vector<AssetClass>& classes);
void RegisterWall(std::vector<AssetClass>& classes);
void RegisterTextiles(std::vector<AssetClass>& classes);
void RegisterMisc(std::vector<AssetClass>& classes);

}  // namespace parallax
