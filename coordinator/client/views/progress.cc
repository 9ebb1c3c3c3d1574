#include "coordinator/client/views/progress.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "coordinator/client/views/text.h"

namespace parallax::client {

std::string ProgressBar(const Terminal& terminal, double done, double begun, int columns) {
  done = std::clamp(done, 0.0, 1.0);
  begun = std::clamp(begun, 0.0, 1.0 - done);
  // Rounded down, so that a full bar means that all is done.
  const int full = static_cast<int>(std::floor(done * columns + 1e-9));
  const int started =
      std::min(columns, static_cast<int>(std::floor((done + begun) * columns + 1e-9))) - full;
  const int rest = columns - full - started;
  const auto repeat = [](std::string_view glyph, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text.append(glyph);
    return text;
  };
  if (!terminal.unicode) {
    return "[" + repeat("#", full) + repeat("=", started) + repeat(".", rest) + "]";
  }
  return terminal.Paint(Tone::kGood, repeat("█", full)) +
         terminal.Paint(Tone::kGood, repeat("▒", started)) +
         terminal.Paint(Tone::kDim, repeat("░", rest));
}

std::string FormatRate(std::optional<double> per_second) {
  if (!per_second) return "-";
  // Two digits: the rate is an estimate.
  double per_hour = *per_second * 3600;
  if (per_hour > 0) {
    const double step = std::pow(10, std::floor(std::log10(per_hour)) - 1);
    per_hour = std::round(per_hour / step) * step;
  }
  return FormatNumber(per_hour) + " pairs/h";
}

std::string FormatEta(std::optional<double> seconds) {
  if (!seconds) return "";
  return "ETA " + FormatAbout(*seconds);
}

std::string FormatPercent(double done, double wanted) {
  if (wanted <= 0) return "-";
  return fmt::format("{}%",
                     static_cast<int>(std::floor(std::min(1.0, done / wanted) * 100 + 1e-9)));
}

}  // namespace parallax::client
