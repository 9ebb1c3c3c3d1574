// Room on the farm's disks, for /metrics.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/system/file.h"

namespace parallax {

struct FarmSpace {
  std::optional<int64_t> results_bytes;  // StoreUse::Bytes; absent: not counted yet.
  // Names of disks ("store", "database") with their space. A store that is not a folder has none.
  std::vector<std::pair<std::string, DiskSpace>> disks;
};

}  // namespace parallax
