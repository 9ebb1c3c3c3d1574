// Each family's file adds its classes to the catalogue here. Private to worker/materials.
#pragma once

#include <vector>

#include "worker/materials/kernel/material.h"

namespace parallax {

using MaterialList = std::vector<MaterialClass>;

// Each function appends the classes of one family.
void AddBarkMaterials(MaterialList& list);
void AddCarpetMaterials(MaterialList& list);
void AddCeramicMaterials(MaterialList& list);
void AddEnamelMaterials(MaterialList& list);
void AddFabricMaterials(MaterialList& list);
void AddFoliageMaterials(MaterialList& list);
void AddForestMaterials(MaterialList& list);
void AddGlassMaterials(MaterialList& list);
void AddGroundMaterials(MaterialList& list);
void AddLandMaterials(MaterialList& list);
void AddLeatherMaterials(MaterialList& list);
void AddMasonryMaterials(MaterialList& list);
void AddMetalMaterials(MaterialList& list);
void AddNatureMaterials(MaterialList& list);
void AddPaperMaterials(MaterialList& list);
void AddPictureMaterials(MaterialList& list);
void AddPlainMaterials(MaterialList& list);
void AddPlasticMaterials(MaterialList& list);
void AddPrintMaterials(MaterialList& list);
void AddSkinMaterials(MaterialList& list);
void AddStoneMaterials(MaterialList& list);
void AddTowelMaterials(MaterialList& list);
void AddWallMaterials(MaterialList& list);
void AddWallpaperMaterials(MaterialList& list);
void AddWoodMaterials(MaterialList& list);

}  // namespace parallax
