// A job's rigs as text, sorted and without repeats: "0-19" or "0-3,7". The text is short in the
// database and readable in a log. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// Returns the text of `rigs`, which must be ascending without repeats.
std::string RigsText(std::span<const uint32_t> rigs);
// Parses such a text. Errors: kInvalidArgument for anything that RigsText does not write.
absl::StatusOr<std::vector<uint32_t>> ParseRigs(std::string_view text);

// Returns first, first + 1, ... first + count - 1.
std::vector<uint32_t> RigRange(uint32_t first, uint32_t count);

}  // namespace parallax
