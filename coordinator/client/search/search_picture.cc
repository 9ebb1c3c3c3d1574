#include "coordinator/client/search/search_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "coordinator/client/search/search_names.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/trial_space.h"

namespace parallax::client {
namespace {

constexpr double kWidth = 960, kHeight = 860;
// Colours of rungs, the last one darkest, and of verdicts.
constexpr const char* kRungColours[] = {"#b9c9dc", "#7fa3cc", "#3f74b5", "#1c4a86"};
constexpr const char* kBetter = "#2a8a4a";
constexpr const char* kWorse = "#c0504d";
constexpr const char* kNotTold = "#9aa0a6";
constexpr const char* kBestColour = "#e07b00";

struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;
};

// A score in the order in which pairs were paid.
struct Point {
  const v1::SearchTrial* trial;
  const v1::SearchScore* score;
  double core_hours = 0;  // The pairs up to this trial took so long.
};

std::string Escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    safe += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return safe;
}

std::string NumberLabel(double value) { return fmt::format("{:.4g}", value); }

// A linear axis from low to high with round ticks.
class Axis {
 public:
  Axis(double low, double high, double from_px, double to_px) : from_px_(from_px), to_px_(to_px) {
    if (!(high > low)) high = low + 1;
    const double raw = (high - low) / 5;
    const double power = std::pow(10, std::floor(std::log10(raw)));
    step_ = power * (raw / power < 1.5 ? 1 : raw / power < 3.5 ? 2 : raw / power < 7.5 ? 5 : 10);
    low_ = std::floor(low / step_) * step_;
    high_ = std::ceil(high / step_) * step_;
  }

  double At(double value) const {
    return from_px_ + (value - low_) / (high_ - low_) * (to_px_ - from_px_);
  }
  std::vector<double> Ticks() const {
    std::vector<double> ticks;
    for (int i = 0; low_ + i * step_ <= high_ + step_ / 2; ++i) ticks.push_back(low_ + i * step_);
    return ticks;
  }

 private:
  double low_ = 0, high_ = 1, step_ = 1;
  double from_px_, to_px_;
};

class Picture {
 public:
  explicit Picture(const v1::SearchStatus& search)
      : search_(search), spec_(search.study().search()) {
    CollectPoints();
    Out("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
        "{1}\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n",
        kWidth, kHeight);
    Out("<rect width=\"{}\" height=\"{}\" fill=\"white\"/>\n", kWidth, kHeight);
    Text(20, 28, search.name() + ": " + SearchProgress(search), "start", 16);
    if (points_.empty()) {
      Text(20, 60, "No trial has a score yet.", "start", 13);
    } else {
      DrawByTrial({70, 70, 480, 400});
      DrawByHours({560, 70, 940, 400});
      DrawLegend(426);
      DrawParallel({70, 540, 900, 790});
    }
    out_ += "</svg>\n";
  }

  std::string Take() { return std::move(out_); }

 private:
  template <typename... Args>
  void Out(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...);
  }
  void Text(double x, double y, std::string_view text, const char* anchor, int size = 12) {
    Out("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\" stroke=\"white\" "
        "stroke-width=\"3\" paint-order=\"stroke\">{}</text>\n",
        x, y, anchor, size, Escaped(text));
  }
  void Line(double x1, double y1, double x2, double y2, const char* colour, double width = 1) {
    Out("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
        "stroke-width=\"{}\"/>\n",
        x1, y1, x2, y2, colour, width);
  }

  bool IsBest(const v1::SearchTrial& trial) const {
    return search_.has_best() && trial.number() == search_.best();
  }

  void CollectPoints() {
    double core_s = 0;
    for (int rung = 0; rung < search_.rungs(); ++rung) {
      const int64_t pairs = PairsOfRung(search_.study(), rung) -
                            (rung == 0 ? 0 : PairsOfRung(search_.study(), rung - 1));
      for (const v1::SearchTrial& trial : search_.trials()) {
        for (const v1::SearchScore& score : trial.scores()) {
          if (score.rung() != rung) continue;
          core_s += score.core_s_per_pair() * static_cast<double>(std::max<int64_t>(0, pairs));
          points_.push_back({&trial, &score, core_s / 3600});
        }
      }
    }
  }

  // The axis of errors, from the least to the largest end of an interval; far ends are cut.
  Axis Errors(const Box& box) const {
    double low = std::numeric_limits<double>::infinity(), high = -low, largest = -low;
    for (const Point& point : points_) {
      const v1::SearchFigure& error = point.score->objective();
      low = std::min(low, std::max(0.0, error.low()));
      high = std::max(high, error.high());
      largest = std::max(largest, error.value());
    }
    return {low, std::min(high, largest * 1.3), box.bottom, box.top};
  }

  void DrawFrame(const Box& box, const Axis& x, const Axis& y, const char* x_label,
                 const char* title) {
    Text(box.left, box.top - 14, title, "start", 13);
    for (const double tick : y.Ticks()) {
      Line(box.left, y.At(tick), box.right, y.At(tick), "#e6e6e6");
      Text(box.left - 6, y.At(tick) + 4, NumberLabel(tick), "end");
    }
    for (const double tick : x.Ticks()) {
      Line(x.At(tick), box.bottom, x.At(tick), box.bottom + 4, "#888");
      Text(x.At(tick), box.bottom + 18, NumberLabel(tick), "middle");
    }
    Line(box.left, box.bottom, box.right, box.bottom, "#888");
    Text((box.left + box.right) / 2, box.bottom + 36, x_label, "middle");
  }

  void DrawPoint(const Box& box, double x, const Axis& axis, const Point& point) {
    const v1::SearchFigure& error = point.score->objective();
    const char* const colour =
        IsBest(*point.trial)
            ? kBestColour
            : kRungColours[std::min<size_t>(static_cast<size_t>(point.score->rung()),
                                            std::size(kRungColours) - 1)];
    const auto inside = [&](double y) { return std::clamp(y, box.top, box.bottom); };
    if (error.low() < error.high()) {
      Line(x, inside(axis.At(error.low())), x, inside(axis.At(error.high())), colour, 1.5);
    }
    const double y = inside(axis.At(error.value()));
    if (point.trial->number() == 0) {
      Out("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8\" height=\"8\" fill=\"{}\" "
          "stroke=\"#222\"/>\n",
          x - 4, y - 4, colour);
    } else {
      Out("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>\n", x, y,
          IsBest(*point.trial) ? 5.5 : 4.0, colour);
    }
  }

  void DrawByTrial(const Box& box) {
    const Axis x(0, std::max(1, search_.trials_size() - 1), box.left + 10, box.right);
    const Axis y = Errors(box);
    DrawFrame(box, x, y, "trial", "Error by trial, %");
    for (const Point& point : points_) DrawPoint(box, x.At(point.trial->number()), y, point);
  }

  void DrawByHours(const Box& box) {
    const Axis x(0, points_.back().core_hours, box.left, box.right - 10);
    const Axis y = Errors(box);
    DrawFrame(box, x, y, "core-hours of pairs", "Error by core-hours of pairs, %");
    // The least error of each rung so far.
    std::string path;
    double least = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Point& point = points_[i];
      const bool is_first = i == 0 || points_[i - 1].score->rung() != point.score->rung();
      const double error = point.score->objective().value();
      const double next = is_first ? error : std::min(least, error);
      path += fmt::format("{} {:.1f} {:.1f} ", is_first ? "M" : "L", x.At(point.core_hours),
                          y.At(is_first ? error : least));
      path += fmt::format("L {:.1f} {:.1f} ", x.At(point.core_hours), y.At(next));
      least = next;
    }
    Out("<path d=\"{}\" fill=\"none\" stroke=\"#555\" stroke-dasharray=\"4 3\"/>\n", path);
    for (const Point& point : points_) DrawPoint(box, x.At(point.core_hours), y, point);
  }

  void DrawLegend(double y) {
    double x = 70;
    const auto entry = [&](const std::string& shape, const std::string& text) {
      out_ += shape;
      Text(x + 10, y + 26, text, "start");
      x += 22 + 7.0 * static_cast<double>(text.size());
    };
    for (int rung = 0; rung < search_.rungs(); ++rung) {
      const char* const colour =
          kRungColours[std::min<size_t>(static_cast<size_t>(rung), std::size(kRungColours) - 1)];
      entry(fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"{}\"/>\n", x, y + 22, colour),
            fmt::format("rung {}", rung + 1));
    }
    entry(fmt::format("<rect x=\"{}\" y=\"{}\" width=\"8\" height=\"8\" fill=\"white\" "
                      "stroke=\"#222\"/>\n",
                      x - 4, y + 18),
          "default");
    entry(fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"5.5\" fill=\"{}\"/>\n", x, y + 22,
                      kBestColour),
          "best");
    entry(fmt::format("<path d=\"M {} {} h 12\" stroke=\"#555\" stroke-dasharray=\"4 3\"/>\n",
                      x - 6, y + 22),
          "least error so far on a rung");
  }

  // ---- Parallel coordinates
  // Returns where a trial's value is on the axis of a field, 0 at the bottom to 1; nothing where it
  // has none.
  std::optional<double> PlaceOf(const v1::SearchTrial& trial, const v1::SearchField& field) const {
    const std::string* const value = ValueOf(trial.values(), field.path());
    if (value == nullptr) return std::nullopt;
    if (field.choices().empty()) return PlaceInRange(field, *value);
    const auto at = std::find(field.choices().begin(), field.choices().end(), *value);
    return (static_cast<double>(at - field.choices().begin()) + 0.5) / field.choices_size();
  }

  void DrawField(const Box& box, double x, const v1::SearchField& field, const std::string& name) {
    Line(x, box.top, x, box.bottom, "#888");
    Text(x, box.top - 10, name, "middle");
    if (field.choices().empty()) {
      Text(x, box.bottom + 16, NumberLabel(field.low()), "middle");
      Text(x + 5, box.top + 10, NumberLabel(field.high()), "start");
      return;
    }
    for (int i = 0; i < field.choices_size(); ++i) {
      const double y = box.bottom - (i + 0.5) / field.choices_size() * (box.bottom - box.top);
      std::string text = field.choices(i);
      if (text.size() > 16) text = text.substr(0, 15) + "...";
      Text(x + 5, y + 4, text, "start", 11);
    }
  }

  void DrawParallel(const Box& box) {
    Text(box.left, box.top - 44, "Values of the trials, and their error from the default's",
         "start", 13);
    const auto count = static_cast<size_t>(spec_.space_size());
    const double apart = (box.right - box.left) / static_cast<double>(count);
    const std::vector<std::string> names = ShortNames(spec_);
    double low = 0, high = 0;
    for (const v1::SearchTrial& trial : search_.trials()) {
      if (trial.scores().empty()) continue;
      const double value = trial.scores(trial.scores_size() - 1).difference().value();
      low = std::min(low, value);
      high = std::max(high, value);
    }
    const Axis difference(low, high, box.bottom, box.top);
    // The best last, so that it is on top.
    std::vector<const v1::SearchTrial*> trials = InOrder(search_);
    std::stable_sort(trials.begin(), trials.end(), [&](const auto* a, const auto* b) {
      return std::pair(IsBest(*a), a->scores_size()) < std::pair(IsBest(*b), b->scores_size());
    });
    for (const v1::SearchTrial* trial : trials) {
      if (trial->number() == 0 || trial->scores().empty()) continue;
      const v1::SearchScore& score = trial->scores(trial->scores_size() - 1);
      std::string path;
      for (size_t i = 0; i < count; ++i) {
        const std::optional<double> place = PlaceOf(*trial, spec_.space(static_cast<int>(i)));
        // A field that is not varied in this trial: below its axis.
        const double y = place ? box.bottom - *place * (box.bottom - box.top) : box.bottom + 26;
        path += fmt::format("{} {:.1f} {:.1f} ", i == 0 ? "M" : "L",
                            box.left + apart * static_cast<double>(i), y);
      }
      path += fmt::format("L {:.1f} {:.1f}", box.right, difference.At(score.difference().value()));
      const bool is_best = IsBest(*trial);
      Out("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" opacity=\"{}\"/>\n", path,
          is_best                       ? kBestColour
          : score.verdict() == "better" ? kBetter
          : score.verdict() == "worse"  ? kWorse
                                        : kNotTold,
          is_best ? 3.0 : 1.5, is_best ? 1.0 : 0.7);
    }
    for (size_t i = 0; i < count; ++i) {
      DrawField(box, box.left + apart * static_cast<double>(i), spec_.space(static_cast<int>(i)),
                names[i]);
    }
    Line(box.right, box.top, box.right, box.bottom, "#888");
    Text(box.right, box.top - 10, "points", "middle");
    for (const double tick : difference.Ticks()) {
      Line(box.right, difference.At(tick), box.right + 4, difference.At(tick), "#888");
      Text(box.right + 8, difference.At(tick) + 4, NumberLabel(tick), "start");
    }
    double x = box.left;
    for (const auto& [colour, text] :
         {std::pair(kBestColour, "best"), std::pair(kBetter, "better than the default"),
          std::pair(kNotTold, "not significant"), std::pair(kWorse, "worse")}) {
      Line(x, box.bottom + 46, x + 16, box.bottom + 46, colour, 3);
      Text(x + 22, box.bottom + 50, text, "start");
      x += 40 + 7.0 * static_cast<double>(std::string_view(text).size());
    }
  }

  const v1::SearchStatus& search_;
  const v1::SearchSpec& spec_;
  std::vector<Point> points_;  // By rungs, then by trials.
  std::string out_;
};

}  // namespace

std::string SearchSvg(const v1::SearchStatus& search) { return Picture(search).Take(); }

}  // namespace parallax::client
