#include "coordinator/client/room_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace parallax::client {
namespace {

constexpr double kCharacterAspect = 2.0;  // Height over width.

// The floor's cells plus a border of one for the walls; each cell one glyph.
class Canvas {
 public:
  Canvas(const v1::Room& room, int columns)
      : room_(room),
        columns_(std::max(8, columns)),
        rows_(std::max(4, static_cast<int>(std::lround(room.depth_m() / room.width_m() * columns_ /
                                                       kCharacterAspect)))),
        cells_(static_cast<size_t>(rows_ + 2),
               std::vector<std::string>(static_cast<size_t>(columns_ + 2), " ")) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  // Cell of a world coordinate, from 1; clamped into the room.
  int Column(double x) const { return Cell(x / room_.width_m(), columns_); }
  int Row(double y) const { return Cell(1 - y / room_.depth_m(), rows_); }
  void Set(int row, int column, std::string_view glyph) {
    cells_[static_cast<size_t>(row)][static_cast<size_t>(column)] = glyph;
  }
  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    for (const auto& row : cells_) {
      std::string& line = lines.emplace_back();
      for (const std::string& glyph : row) line += glyph;
    }
    return lines;
  }

 private:
  static int Cell(double fraction, int count) {
    return 1 + std::clamp(static_cast<int>(fraction * count), 0, count - 1);
  }

  const v1::Room& room_;
  int columns_;
  int rows_;
  std::vector<std::vector<std::string>> cells_;
};

void DrawWalls(Canvas& canvas) {
  for (int c = 0; c < canvas.columns() + 2; ++c) {
    canvas.Set(0, c, "#");
    canvas.Set(canvas.rows() + 1, c, "#");
  }
  for (int r = 0; r < canvas.rows() + 2; ++r) {
    canvas.Set(r, 0, "#");
    canvas.Set(r, canvas.columns() + 1, "#");
  }
}

void DrawOpening(const v1::Opening& opening, Canvas& canvas) {
  const char* glyph = opening.kind() == v1::Opening::KIND_DOOR ? "D" : "=";
  const double low = opening.center_m() - opening.width_m() / 2;
  const double high = opening.center_m() + opening.width_m() / 2;
  if (opening.wall() == 0 || opening.wall() == 2) {
    const int row = opening.wall() == 0 ? canvas.rows() + 1 : 0;
    for (int c = canvas.Column(low); c <= canvas.Column(high); ++c) canvas.Set(row, c, glyph);
  } else {
    const int column = opening.wall() == 1 ? canvas.columns() + 1 : 0;
    for (int r = canvas.Row(high); r <= canvas.Row(low); ++r) canvas.Set(r, column, glyph);
  }
}

void DrawFootprints(std::vector<Footprint> footprints, Canvas& canvas) {
  std::stable_sort(footprints.begin(), footprints.end(),
                   [](const auto& a, const auto& b) { return a.top_m < b.top_m; });
  for (const Footprint& print : footprints) {
    const std::string glyph(1, print.symbol);
    for (int r = canvas.Row(print.y1); r <= canvas.Row(print.y0); ++r) {
      for (int c = canvas.Column(print.x0); c <= canvas.Column(print.x1); ++c) {
        canvas.Set(r, c, glyph);
      }
    }
  }
}

// The third column of the rotation: where the camera looks, seen from above.
std::string RigGlyph(const v1::Transform& pose, bool unicode) {
  static constexpr std::array<const char*, 8> kArrows = {"→", "↗", "↑", "↖", "←", "↙", "↓", "↘"};
  static constexpr std::array<const char*, 8> kAscii = {">", "^", "^", "^", "<", "v", "v", "v"};
  const double x = 2 * (pose.qx() * pose.qz() + pose.qw() * pose.qy());
  const double y = 2 * (pose.qy() * pose.qz() - pose.qw() * pose.qx());
  const int eighth = static_cast<int>(std::lround(std::atan2(y, x) / (M_PI / 4)));
  const auto index = static_cast<size_t>((eighth + 8) % 8);
  return unicode ? kArrows[index] : kAscii[index];
}

}  // namespace

std::vector<std::string> DrawRoomPlan(const v1::Scene& scene,
                                      const std::vector<Footprint>& footprints,
                                      const RoomPlanOptions& options) {
  const v1::Room& room = scene.room();
  if (room.width_m() <= 0 || room.depth_m() <= 0) return {};
  Canvas canvas(room, options.columns);
  DrawWalls(canvas);
  for (const v1::Opening& opening : room.openings()) DrawOpening(opening, canvas);
  DrawFootprints(footprints, canvas);
  for (const v1::Rig& rig : scene.rigs()) {
    const v1::Transform& pose = rig.world_from_left();
    canvas.Set(canvas.Row(pose.ty()), canvas.Column(pose.tx()), RigGlyph(pose, options.unicode));
  }
  return canvas.Lines();
}

char PlanSymbol(bool floating, size_t nth) {
  return nth < 26 ? static_cast<char>((floating ? 'a' : 'A') + static_cast<int>(nth)) : '+';
}

}  // namespace parallax::client
