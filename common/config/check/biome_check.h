// Inner part of common/config: checks a land's parts against each other and against the catalogues.
// Pure and thread-safe.
#pragma once

#include <string>

#include "common/config/check/checks.h"

namespace parallax::config_internal {

// Checks what CheckFields does not see: that what is needed is given and nothing else, that names
// and formulas are known where they stand, and that ranges are not reversed. Appends its
// findings; `path` is that of the land.
void CheckBiome(const v1::Biome& biome, const std::string& path, Findings* findings);

}  // namespace parallax::config_internal
