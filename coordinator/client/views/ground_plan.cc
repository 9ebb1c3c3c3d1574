#include "coordinator/client/views/ground_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace parallax::client {
namespace {

constexpr double kCharacterAspect = 2.0;  // Height over width.

// The ground's cells plus a border of one for the edge; each cell one glyph.
class GlyphCanvas {
 public:
  GlyphCanvas(const Eigen::AlignedBox3d& extent, int columns)
      : low_(extent.min()),
        size_(extent.sizes()),
        columns_(std::max(8, columns)),
        rows_(std::max(
            4, static_cast<int>(std::lround(size_.y() / size_.x() * columns_ / kCharacterAspect)))),
        cells_(static_cast<size_t>(rows_ + 2),
               std::vector<std::string>(static_cast<size_t>(columns_ + 2), " ")) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  // Cell of a world coordinate, from 1; clamped into the extent.
  int Column(double x) const { return Cell((x - low_.x()) / size_.x(), columns_); }
  int Row(double y) const { return Cell(1 - (y - low_.y()) / size_.y(), rows_); }
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

  const Vec3d low_, size_;
  int columns_;
  int rows_;
  std::vector<std::vector<std::string>> cells_;
};

void DrawEdge(GlyphCanvas& canvas) {
  for (int c = 0; c < canvas.columns() + 2; ++c) {
    canvas.Set(0, c, "#");
    canvas.Set(canvas.rows() + 1, c, "#");
  }
  for (int r = 0; r < canvas.rows() + 2; ++r) {
    canvas.Set(r, 0, "#");
    canvas.Set(r, canvas.columns() + 1, "#");
  }
}

void DrawGap(const GroundPlan& plan, const GroundPlan::Gap& gap, GlyphCanvas& canvas) {
  const std::string glyph(1, gap.glyph);
  if (gap.edge == 0 || gap.edge == 2) {
    const double from = plan.extent.min().x();
    const int row = gap.edge == 0 ? canvas.rows() + 1 : 0;
    const int last = canvas.Column(from + gap.to_m);
    for (int c = canvas.Column(from + gap.from_m); c <= last; ++c) canvas.Set(row, c, glyph);
  } else {
    const double from = plan.extent.min().y();
    const int column = gap.edge == 1 ? canvas.columns() + 1 : 0;
    const int last = canvas.Row(from + gap.from_m);
    for (int r = canvas.Row(from + gap.to_m); r <= last; ++r) canvas.Set(r, column, glyph);
  }
}

void DrawFootprints(std::vector<Footprint> footprints, GlyphCanvas& canvas) {
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

std::vector<std::string> DrawGroundPlan(const GroundPlan& plan, const v1::Scene& scene,
                                        const std::vector<Footprint>& footprints,
                                        const GroundPlanOptions& options) {
  GlyphCanvas canvas(plan.extent, options.columns);
  DrawEdge(canvas);
  for (const GroundPlan::Gap& gap : plan.gaps) DrawGap(plan, gap, canvas);
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
