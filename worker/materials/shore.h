// Family `shore`. Private to worker/materials.
#pragma once

#include "worker/materials/families.h"

namespace parallax {

void AddShoreMaterials(MaterialList& list);

}  // namespace parallax
