#include "coordinator/client/views/learning_curves.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

struct Point {
  std::string benchmark, metric, set, trainer;
  int64_t seed = 0, step = 0;
  double value = 0;
};

// Steps of all trained checkpoints, by their hash.
std::map<std::string, int64_t> StepsByHash(const std::string& out_dir) {
  std::map<std::string, int64_t> steps;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(out_dir + "/training", error)) {
    if (entry.path().filename() != "training.json") continue;
    const auto text = ReadFile(entry.path());
    const auto json = nlohmann::json::parse(text.value_or(""), nullptr, /*allow_exceptions=*/false);
    if (!json.is_object() || !json.contains("checkpoints")) continue;
    for (const auto& one : json["checkpoints"]) {
      steps[one.value("sha256", "")] = one.value("step", int64_t{0});
    }
  }
  return steps;
}

std::vector<Point> PointsOf(const std::vector<Evaluation>& evaluations,
                            const std::map<std::string, int64_t>& steps) {
  std::vector<Point> points;
  for (const Evaluation& one : evaluations) {
    const auto step = steps.find(one.run.checkpoint);
    if (!one.run.seed || step == steps.end()) continue;
    points.push_back({one.benchmark, MetricName(one.headline), one.run.variant, one.run.trainer,
                      *one.run.seed, step->second, FigureOf(one.headline, one)});
  }
  return points;
}

std::string Csv(const std::vector<Point>& points) {
  std::string csv = "benchmark,metric,set,trainer,seed,step,value\n";
  for (const Point& p : points) {
    csv += fmt::format("{},{},{},{},{},{},{:.6g}\n", p.benchmark, p.metric, p.set, p.trainer,
                       p.seed, p.step, p.value);
  }
  return csv;
}

// Mean over seeds, by set and step.
using Lines = std::map<std::string, std::map<int64_t, double>>;

Lines LinesOf(const std::vector<Point>& points, const std::string& benchmark) {
  std::map<std::string, std::map<int64_t, std::pair<double, int>>> sums;
  for (const Point& p : points) {
    if (p.benchmark != benchmark || !std::isfinite(p.value)) continue;
    auto& [sum, count] = sums[p.set][p.step];
    sum += p.value;
    ++count;
  }
  Lines lines;
  for (const auto& [set, by_step] : sums) {
    for (const auto& [step, sum] : by_step) lines[set][step] = sum.first / sum.second;
  }
  return lines;
}

constexpr int kWidth = 900, kHeight = 520, kLeft = 80, kTop = 60, kRight = 230, kBottom = 50;

class Picture {
 public:
  explicit Picture(const Lines& lines) {
    for (const auto& [set, line] : lines) {
      for (const auto& [step, value] : line) {
        most_steps_ = std::max(most_steps_, static_cast<double>(step));
        highest_ = std::max(highest_, value);
      }
    }
  }

  void DrawAxes(const std::string& title, const std::string& metric) {
    canvas_.DrawText(kLeft, 32, title, 13, kText, true);
    canvas_.DrawText(kLeft, kHeight - 12, "steps", 9, kFaint);
    canvas_.DrawText(kLeft, 50, metric, 9, kFaint);
    for (int i = 0; i <= 4; ++i) {
      const int y = Y(highest_ * i / 4);
      canvas_.FillBox(kLeft, y, kWidth - kLeft - kRight, 1, kPanel);
      canvas_.DrawText(12, y + 4, fmt::format("{:.3g}", highest_ * i / 4), 9, kFaint);
      canvas_.DrawText(X(most_steps_ * i / 4) - 10, kHeight - kBottom + 16,
                       fmt::format("{:.0f}", most_steps_ * i / 4), 9, kFaint);
    }
  }

  void DrawLine(const std::string& name, const std::map<int64_t, double>& line, const Rgb& color,
                int row) {
    double last_x = -1, last_y = 0;
    for (const auto& [step, value] : line) {
      const double x = X(static_cast<double>(step)), y = Y(value);
      if (last_x >= 0) DrawSegment(last_x, last_y, x, y, color);
      canvas_.FillBox(static_cast<int>(x) - 3, static_cast<int>(y) - 3, 6, 6, color);
      last_x = x, last_y = y;
    }
    const int y = kTop + 20 * row, x = kWidth - kRight + 16;
    canvas_.FillBox(x, y, 10, 10, color);
    canvas_.DrawText(x + 18, y + 10, FitText(name, 9, kRight - 44), 9);
  }

  const ImageRgb8& image() const { return canvas_.image(); }

 private:
  int X(double step) const {
    return kLeft + static_cast<int>((kWidth - kLeft - kRight) * step / most_steps_);
  }
  int Y(double value) const {
    return kHeight - kBottom - static_cast<int>((kHeight - kTop - kBottom) * value / highest_);
  }
  void DrawSegment(double x0, double y0, double x1, double y1, const Rgb& color) {
    const int steps = static_cast<int>(std::max(std::abs(x1 - x0), std::abs(y1 - y0))) + 1;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      canvas_.FillBox(static_cast<int>(x0 + t * (x1 - x0)), static_cast<int>(y0 + t * (y1 - y0)), 2,
                      2, color);
    }
  }

  Canvas canvas_{kWidth, kHeight};
  double most_steps_ = 1, highest_ = 1e-9;
};

absl::Status Draw(const std::vector<Point>& points, const std::string& benchmark,
                  const std::string& out_png) {
  const Lines lines = LinesOf(points, benchmark);
  const auto metric = std::find_if(points.begin(), points.end(),
                                   [&](const Point& p) { return p.benchmark == benchmark; });
  Picture picture(lines);
  picture.DrawAxes("Learning curves: " + benchmark, metric->metric);
  int row = 0;
  for (const auto& [set, line] : lines) {
    const double hue = lines.size() < 2 ? 0.3 : 0.15 + 0.75 * row / (lines.size() - 1.0);
    picture.DrawLine(set, line, Turbo(hue), row);
    ++row;
  }
  return WritePng(out_png, picture.image(), 3);
}

}  // namespace

absl::Status WriteLearningCurves(const std::string& out_dir,
                                 const std::vector<Evaluation>& evaluations) {
  std::vector<Point> points = PointsOf(evaluations, StepsByHash(out_dir));
  if (points.empty()) return absl::OkStatus();
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return std::tie(a.benchmark, a.set, a.trainer, a.seed, a.step) <
           std::tie(b.benchmark, b.set, b.trainer, b.seed, b.step);
  });
  RETURN_IF_ERROR(WriteFile(out_dir + "/curves/learning_curves.csv", Csv(points)));
  std::set<std::string> benchmarks;
  for (const Point& p : points) benchmarks.insert(p.benchmark);
  for (const std::string& benchmark : benchmarks) {
    RETURN_IF_ERROR(Draw(points, benchmark, out_dir + "/curves/" + benchmark + ".png"));
  }
  return absl::OkStatus();
}

}  // namespace parallax::client
