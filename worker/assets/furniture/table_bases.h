// The bases of tables.
#pragma once

#include "worker/assets/furniture/tables.h"

namespace parallax {

// Adds the base that the parameters name, below the top; one with a shelf declares its support.
void AddTableBase(kernel::AssetBuilder& b, const TableParams& p);

}  // namespace parallax
