#include "worker/assets/size_table.h"

#include <vector>

namespace parallax {

const SizeRange* FindSizeRange(std::string_view name) {
  static const std::vector<SizeRange>& table = *new std::vector<SizeRange>{
      {"ArmChair", {0.6f, 0.65f, 0.7f}, {1.25f, 1.1f, 1.15f}},
      {"BarChair", {0.3f, 0.3f, 0.58f}, {0.55f, 0.55f, 1.1f}},
      {"CellShelf", {0.6f, 0.3f, 0.6f}, {2.15f, 0.46f, 2.4f}},
      {"Chair", {0.38f, 0.38f, 0.72f}, {0.66f, 0.7f, 1.15f}},
      {"KitchenCabinet", {0.8f, 0.55f, 0.83f}, {3.1f, 0.7f, 0.96f}},
      {"LargeShelf", {0.85f, 0.28f, 1.7f}, {2.9f, 0.5f, 2.4f}},
      {"OfficeChair", {0.55f, 0.55f, 0.85f}, {0.8f, 0.85f, 1.4f}},
      {"SimpleBookcase", {0.55f, 0.24f, 0.8f}, {1.15f, 0.45f, 2.1f}},
      {"SimpleDesk", {0.95f, 0.5f, 0.68f}, {1.75f, 0.85f, 0.82f}},
      {"SingleCabinet", {0.4f, 0.36f, 0.65f}, {2, 0.72f, 2.25f}},
      {"Sofa", {1.3f, 0.65f, 0.65f}, {2.7f, 1.75f, 1.1f}},
      {"TVStand", {1.1f, 0.34f, 0.33f}, {2, 0.55f, 0.7f}},
      {"TableCocktail", {0.55f, 0.45f, 0.34f}, {1.35f, 0.95f, 0.55f}},
      {"TableDining", {0.9f, 0.75f, 0.68f}, {2.2f, 1.4f, 0.82f}},
      {"TriangleShelf", {0.4f, 0.2f, 1.2f}, {0.9f, 0.6f, 2}},
  };
  for (const SizeRange& range : table) {
    if (range.name == name) return &range;
  }
  return nullptr;
}

}  // namespace parallax
