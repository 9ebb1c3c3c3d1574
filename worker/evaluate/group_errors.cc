#include "worker/evaluate/group_errors.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/image/io.h"
#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr int kGroupsMargin = 24, kTop = 84, kRow = 24, kNameWidth = 220, kBarWidth = 460,
              kNumberWidth = 120;

double Epe(const GroupError& error) { return FigureOf(kEpeMeasure, error.tally); }

}  // namespace

absl::StatusOr<std::vector<GroupError>> GroupErrors(const std::vector<Evaluation>& evaluations,
                                                    const std::string& group, double least_share) {
  Tallies sums;
  int64_t pixels = 0;
  for (const Evaluation& evaluation : evaluations) {
    for (const Scores& scores : evaluation.images) {
      const auto found = scores.groups.find(group);
      if (found == scores.groups.end()) continue;
      pixels += scores.regions.at("all").pixels;
      for (const auto& [name, tally] : found->second) sums[name] += tally;
    }
  }
  if (sums.empty()) {
    return NotFound("no scores by {}", group);
  }
  std::vector<GroupError> errors;
  for (const auto& [name, tally] : sums) {
    const double share = static_cast<double>(tally.pixels) / static_cast<double>(pixels);
    if (share >= least_share) errors.push_back({name, share, tally});
  }
  std::stable_sort(errors.begin(), errors.end(),
                   [](const GroupError& a, const GroupError& b) { return Epe(a) > Epe(b); });
  return errors;
}

std::string GroupErrorsCsv(const std::vector<GroupError>& errors) {
  std::string text = "name,pixels,share,epe,bad-1,bad-2,bad-3,d1\n";
  for (const GroupError& error : errors) {
    text += fmt::format("{},{},{:.6f}", error.name, error.tally.pixels, error.share);
    for (const Measure& measure : {kEpeMeasure, BadAt(1), BadAt(2), BadAt(3), kD1Measure}) {
      text += fmt::format(",{:.4f}", FigureOf(measure, error.tally));
    }
    text += "\n";
  }
  return text;
}

absl::Status DrawGroupErrors(const std::vector<GroupError>& errors, const std::string& title,
                             const std::string& out_png) {
  double largest = 1e-9;
  for (const GroupError& error : errors) largest = std::max(largest, Epe(error));
  const int bars_x = kGroupsMargin + kNameWidth, numbers_x = bars_x + kBarWidth + 12;
  Canvas canvas(numbers_x + 3 * kNumberWidth + kGroupsMargin,
                kTop + kRow * static_cast<int>(errors.size()) + kGroupsMargin);
  canvas.DrawText(kGroupsMargin, 36, title, 14, kText, true);
  const char* headings[] = {"mean error px", "bad-2 %", "of pixels %"};
  for (int c = 0; c < 3; ++c) {
    canvas.DrawText(numbers_x + c * kNumberWidth, kTop - 12, headings[c], 9, kFaint);
  }
  for (size_t i = 0; i < errors.size(); ++i) {
    const GroupError& error = errors[i];
    const int top = kTop + kRow * static_cast<int>(i), text_y = top + 16;
    const double part = Epe(error) / largest;
    canvas.DrawText(kGroupsMargin, text_y, FitText(error.name, 10, kNameWidth - 12), 10);
    canvas.FillBox(bars_x, top + 3, kBarWidth, kRow - 6, kPanel);
    canvas.FillBox(bars_x, top + 3, std::max(1, static_cast<int>(std::lround(kBarWidth * part))),
                   kRow - 6, kAccent);
    const double numbers[] = {Epe(error), FigureOf(BadAt(2), error.tally), 100 * error.share};
    for (int c = 0; c < 3; ++c) {
      canvas.DrawText(numbers_x + c * kNumberWidth, text_y, fmt::format("{:.2f}", numbers[c]), 10);
    }
  }
  return WritePng(out_png, canvas.image(), 3);
}

}  // namespace parallax
