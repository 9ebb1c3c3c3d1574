// Family `shore`. Private to worker/materials.
#pragma once

#include "worker/materials/kernel/material_families.h"

namespace parallax {

void AddShoreMaterials(MaterialList& list);

}  // namespace parallax
