// A job's rigs as text, sorted and without repeats: "0-19" or "0-3,7". Short in the database,
// readable in a log.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// `rigs` must be ascending without repeats.
std::string RigsText(std::span<const uint32_t> rigs);
// The rigs that a text names. Errors: kInvalidArgument for anything that RigsText doesn't write.
absl::StatusOr<std::vector<uint32_t>> ParseRigs(std::string_view text);

// first, first + 1, ... first + count - 1.
std::vector<uint32_t> RigRange(uint32_t first, uint32_t count);

}  // namespace parallax
