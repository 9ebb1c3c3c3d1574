#include "coordinator/study/rigs.h"

#include <fmt/core.h>

#include <charconv>
#include <numeric>

namespace parallax {
namespace {

constexpr uint32_t kMaxRigs = 100000;

absl::Status BadRigs(std::string_view text) {
  return InvalidArgument("rigs '{}': wanted ascending ranges such as 0-3,7", text);
}

// Takes a number off the front.
bool TakeNumber(std::string_view& text, uint32_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number > kMaxRigs) return false;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return true;
}

}  // namespace

std::string RigsText(std::span<const uint32_t> rigs) {
  std::string text;
  for (size_t i = 0; i < rigs.size();) {
    size_t last = i;
    while (last + 1 < rigs.size() && rigs[last + 1] == rigs[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += std::to_string(rigs[i]);
    if (last > i) text += fmt::format("-{}", rigs[last]);
    i = last + 1;
  }
  return text;
}

absl::StatusOr<std::vector<uint32_t>> ParseRigs(std::string_view text) {
  std::vector<uint32_t> rigs;
  for (std::string_view rest = text; !rest.empty();) {
    uint32_t first = 0;
    if (!TakeNumber(rest, first)) return BadRigs(text);
    uint32_t last = first;
    if (!rest.empty() && rest.front() == '-') {
      rest.remove_prefix(1);
      if (!TakeNumber(rest, last) || last <= first) return BadRigs(text);
    }
    if (!rigs.empty() && first <= rigs.back()) return BadRigs(text);
    for (uint32_t rig = first; rig <= last; ++rig) rigs.push_back(rig);
    if (rest.empty()) break;
    if (rest.front() != ',' || rest.size() == 1) return BadRigs(text);
    rest.remove_prefix(1);
  }
  return rigs;
}

std::vector<uint32_t> RigRange(uint32_t first, uint32_t count) {
  std::vector<uint32_t> rigs(count);
  std::iota(rigs.begin(), rigs.end(), first);
  return rigs;
}

}  // namespace parallax
