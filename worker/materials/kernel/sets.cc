#include "worker/materials/kernel/sets.h"

#include <algorithm>
#include <iterator>

namespace parallax {

bool IsTroublesome(const MaterialClass& material) {
  static constexpr std::string_view kNames[] = {"ClearGlass", "Mirror", "SolidGlass"};
  return std::find(std::begin(kNames), std::end(kNames), material.name) != std::end(kNames);
}

}  // namespace parallax
