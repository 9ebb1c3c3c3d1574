// The families' registration functions: each appends its classes. AssetCatalogue calls them all.
#pragma once

#include <vector>

#include "worker/assets/asset.h"

namespace parallax {

void RegisterChairs(std::vector<AssetClass>& classes);

}  // namespace parallax
