#include "worker/assets/size_table.h"

#include <vector>

namespace parallax {

const SizeRange* FindSizeRange(std::string_view name) {
  static const std::vector<SizeRange>& table = *new std::vector<SizeRange>{
      {"BarChair", {0.3f, 0.3f, 0.58f}, {0.55f, 0.55f, 1.1f}},
      {"Chair", {0.38f, 0.38f, 0.72f}, {0.66f, 0.7f, 1.15f}},
      {"OfficeChair", {0.55f, 0.55f, 0.85f}, {0.8f, 0.85f, 1.4f}},
  };
  for (const SizeRange& range : table) {
    if (range.name == name) return &range;
  }
  return nullptr;
}

}  // namespace parallax
