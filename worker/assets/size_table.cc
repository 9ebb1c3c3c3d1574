#include "worker/assets/size_table.h"

#include <vector>

namespace parallax {

const SizeRange* FindSizeRange(std::string_view name) {
  static const std::vector<SizeRange>& table = *new std::vector<SizeRange>{
      {"ArmChair", {0.6f, 0.65f, 0.7f}, {1.25f, 1.1f, 1.15f}},
      {"BarChair", {0.3f, 0.3f, 0.58f}, {0.55f, 0.55f, 1.1f}},
      {"BathroomSink", {0.4f, 0.4f, 0.9f}, {1.0f, 0.85f, 1.4f}},
      {"Bathtub", {1.4f, 0.65f, 0.5f}, {1.85f, 1.05f, 0.95f}},
      {"Bed", {1, 2, 0.4f}, {2.2f, 2.4f, 1.5f}},
      {"BedFrame", {0.95f, 2, 0.28f}, {2.05f, 2.35f, 1.45f}},
      {"BeverageFridge", {0.4f, 0.45f, 0.65f}, {0.65f, 0.7f, 1.25f}},
      {"Blanket", {0.38f, 0.3f, 0.04f}, {0.7f, 0.56f, 0.22f}},
      {"Book", {0.1f, 0.16f, 0.01f}, {0.25f, 0.31f, 0.06f}},
      {"BookColumn", {0.05f, 0.1f, 0.14f}, {0.6f, 0.26f, 0.33f}},
      {"BookStack", {0.11f, 0.15f, 0.03f}, {0.34f, 0.36f, 0.42f}},
      {"Bottle", {0.04f, 0.04f, 0.17f}, {0.11f, 0.11f, 0.36f}},
      {"Bowl", {0.12f, 0.12f, 0.03f}, {0.36f, 0.36f, 0.16f}},
      {"Can", {0.06f, 0.06f, 0.04f}, {0.12f, 0.12f, 0.19f}},
      {"CeilingClassicLamp", {0.2f, 0.2f, 0.08f}, {0.8f, 0.8f, 1}},
      {"CellShelf", {0.6f, 0.3f, 0.6f}, {2.15f, 0.46f, 2.4f}},
      {"Chair", {0.38f, 0.38f, 0.72f}, {0.66f, 0.7f, 1.15f}},
      {"Chopsticks", {0.02f, 0.19f, 0.004f}, {0.09f, 0.27f, 0.02f}},
      {"Cup", {0.06f, 0.06f, 0.045f}, {0.2f, 0.2f, 0.15f}},
      {"CurvedStaircase", {1.0f, 1.5f, 2.4f}, {4.5f, 5.5f, 4.4f}},
      {"DeskLamp", {0.14f, 0.16f, 0.34f}, {0.46f, 0.46f, 0.66f}},
      {"Dishwasher", {0.42f, 0.52f, 0.78f}, {0.64f, 0.72f, 0.9f}},
      {"FloorLamp", {0.28f, 0.28f, 1.3f}, {1.5f, 0.62f, 2.2f}},
      {"FoodBag", {0.11f, 0.03f, 0.14f}, {0.24f, 0.12f, 0.38f}},
      {"FoodBox", {0.11f, 0.025f, 0.12f}, {0.22f, 0.13f, 0.46f}},
      {"Fork", {0.012f, 0.15f, 0.005f}, {0.04f, 0.22f, 0.04f}},
      {"GlassPanelDoor", {0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f}},
      {"Jar", {0.06f, 0.06f, 0.07f}, {0.15f, 0.15f, 0.28f}},
      {"KitchenCabinet", {0.8f, 0.55f, 0.83f}, {3.1f, 0.7f, 0.96f}},
      {"Knife", {0.008f, 0.18f, 0.004f}, {0.05f, 0.32f, 0.04f}},
      {"LargeShelf", {0.85f, 0.28f, 1.7f}, {2.9f, 0.5f, 2.4f}},
      {"Lid", {0.15f, 0.15f, 0.03f}, {0.32f, 0.32f, 0.12f}},
      {"LiteDoor", {0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f}},
      {"LouverDoor", {0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f}},
      {"Mattress", {0.88f, 1.85f, 0.14f}, {1.85f, 2.1f, 0.32f}},
      {"Microwave", {0.42f, 0.3f, 0.22f}, {0.6f, 0.52f, 0.35f}},
      {"OfficeChair", {0.55f, 0.55f, 0.85f}, {0.8f, 0.85f, 1.4f}},
      {"Oven", {0.55f, 0.55f, 0.84f}, {0.95f, 0.78f, 1.12f}},
      {"PanelDoor", {0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f}},
      {"Pillow", {0.36f, 0.3f, 0.06f}, {0.82f, 0.6f, 0.24f}},
      {"Plate", {0.15f, 0.15f, 0.01f}, {0.36f, 0.36f, 0.05f}},
      {"Pot", {0.18f, 0.16f, 0.04f}, {0.6f, 0.34f, 0.3f}},
      {"SimpleBookcase", {0.55f, 0.24f, 0.8f}, {1.15f, 0.45f, 2.1f}},
      {"SimpleDesk", {0.95f, 0.5f, 0.68f}, {1.75f, 0.85f, 0.82f}},
      {"SingleCabinet", {0.4f, 0.36f, 0.65f}, {2, 0.72f, 2.25f}},
      {"Sink", {0.4f, 0.45f, 0.25f}, {1.35f, 0.75f, 0.75f}},
      {"Sofa", {1.3f, 0.65f, 0.65f}, {2.7f, 1.75f, 1.1f}},
      {"SpiralStaircase", {1.2f, 1.2f, 2.4f}, {2.2f, 2.2f, 4.5f}},
      {"Spoon", {0.02f, 0.12f, 0.005f}, {0.06f, 0.22f, 0.05f}},
      {"StraightStaircase", {0.7f, 2.6f, 1.8f}, {1.4f, 5.2f, 4.4f}},
      {"TVStand", {1.1f, 0.34f, 0.33f}, {2, 0.55f, 0.7f}},
      {"TableCocktail", {0.55f, 0.45f, 0.34f}, {1.35f, 0.95f, 0.55f}},
      {"TableDining", {0.9f, 0.75f, 0.68f}, {2.2f, 1.4f, 0.82f}},
      {"Tap", {0.02f, 0.1f, 0.1f}, {0.3f, 0.3f, 0.4f}},
      {"Towel", {0.22f, 0.17f, 0.02f}, {0.44f, 0.34f, 0.14f}},
      {"TriangleShelf", {0.4f, 0.2f, 1.2f}, {0.9f, 0.6f, 2}},
      {"UShapedStaircase", {1.5f, 1.9f, 2.4f}, {2.8f, 3.8f, 4.4f}},
      {"Vase", {0.06f, 0.06f, 0.14f}, {0.5f, 0.46f, 0.44f}},
      {"Wineglass", {0.04f, 0.04f, 0.11f}, {0.16f, 0.16f, 0.25f}},
  };
  for (const SizeRange& range : table) {
    if (range.name == name) return &range;
  }
  return nullptr;
}

}  // namespace parallax
