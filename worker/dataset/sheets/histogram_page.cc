#include "worker/dataset/sheets/histogram_page.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr int kWidth = 1800, kPageMargin = 40, kPanelHeight = 380, kBarRows = 22, kBarHeight = 26;

std::string Percent(double share) {
  return fmt::format("{:.{}f} %", 100 * share, share < 0.0995 ? 1 : 0);
}

std::string Short(double value) { return fmt::format("{:g}", value); }

// A bin's height is its share of the panel's largest bin. `limits` are marked with the share that
// lies below.
void DrawHistogram(Canvas& canvas, int x, int y, int width, const std::string& title,
                   const Histogram& histogram, double tick, const std::vector<int>& limits) {
  canvas.FillBox(x, y, width, kPanelHeight, kPanel);
  canvas.DrawText(x + 20, y + 34, title, 13, kText, true);
  const int left = x + 20, bottom = y + kPanelHeight - 44, height = kPanelHeight - 130;
  const int plot_width = width - 40;
  const size_t bins = histogram.counts.size();
  const auto at = [&](double value) {
    return left + static_cast<int>(std::lround(value / histogram.bin_width * plot_width /
                                               static_cast<double>(bins)));
  };
  const int64_t most =
      std::max<int64_t>(1, *std::max_element(histogram.counts.begin(), histogram.counts.end()));
  for (size_t i = 0; i < bins; ++i) {
    const double share = static_cast<double>(histogram.counts[i]) / static_cast<double>(most);
    const int bar = static_cast<int>(std::ceil(share * height));
    const double edge = static_cast<double>(i) * histogram.bin_width;
    const int begin = at(edge), end = at(edge + histogram.bin_width);
    canvas.FillBox(begin, bottom - bar, std::max(end - begin - 1, 1), bar,
                   i + 1 == bins ? kWarn : kAccent);
  }
  canvas.FillBox(left, bottom, plot_width, 1, kFaint);
  const double last = static_cast<double>(bins - 1) * histogram.bin_width;
  for (double value = 0; value <= last; value += tick) {
    canvas.FillBox(at(value), bottom, 1, 6, kFaint);
    const std::string label = Short(value) + (value + tick > last ? "+" : "");
    canvas.DrawText(at(value) - Canvas::TextWidth(label, 9) / 2, bottom + 22, label, 9, kFaint);
  }
  for (const int limit : limits) {
    canvas.FillBox(at(limit), bottom - height - 14, 1, height + 14, kWarn);
    canvas.DrawText(at(limit) + 5, bottom - height - 4, std::to_string(limit), 9, kWarn, true);
    canvas.DrawText(at(limit) + 5, bottom - height + 12, Percent(histogram.FractionBelow(limit)), 8,
                    kText);
  }
}

void DrawShares(Canvas& canvas, int x, int y, int width, const std::string& title,
                const std::map<std::string, int64_t>& pixels, int64_t total) {
  std::vector<std::pair<std::string, int64_t>> rows(pixels.begin(), pixels.end());
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  canvas.FillBox(x, y, width, 60 + kBarRows * kBarHeight, kPanel);
  canvas.DrawText(x + 20, y + 34, fmt::format("{} ({})", title, rows.size()), 13, kText, true);
  if (rows.size() > kBarRows) {
    int64_t rest = 0;
    for (size_t i = kBarRows - 1; i < rows.size(); ++i) rest += rows[i].second;
    const std::string name = fmt::format("{} more", rows.size() - kBarRows + 1);
    rows.resize(kBarRows - 1);
    rows.emplace_back(name, rest);
  }
  const int64_t most = rows.empty() ? 1 : std::max<int64_t>(rows.front().second, 1);
  for (size_t i = 0; i < rows.size(); ++i) {
    const int top = y + 52 + static_cast<int>(i) * kBarHeight;
    const double share =
        static_cast<double>(rows[i].second) / static_cast<double>(std::max<int64_t>(total, 1));
    const double length = static_cast<double>(rows[i].second) / static_cast<double>(most);
    canvas.DrawText(x + 20, top + 17, FitText(rows[i].first, 9.5, 180), 9.5);
    const int bar = static_cast<int>(std::min(length, 1.0) * (width - 310));
    canvas.FillBox(x + 210, top + 5, std::max(bar, 1), kBarHeight - 10, kAccent);
    canvas.DrawText(x + 218 + std::max(bar, 1), top + 17, Percent(share), 8.5, kFaint);
  }
}

void AddCounts(const nlohmann::ordered_json& json, const char* key, Histogram& histogram) {
  if (!json.contains(key)) return;
  const auto counts = json[key].value("counts", std::vector<int64_t>());
  for (size_t i = 0; i < counts.size() && i < histogram.counts.size(); ++i) {
    histogram.counts[i] += counts[i];
  }
}

void AddPixels(const nlohmann::ordered_json& json, const char* key,
               std::map<std::string, int64_t>& pixels) {
  if (!json.contains(key)) return;
  for (const auto& [name, count] : json[key].items()) pixels[name] += count.get<int64_t>();
}

}  // namespace

absl::StatusOr<HistogramData> SumHistograms(const std::vector<std::string>& frame_dirs) {
  HistogramData data;
  for (const std::string& dir : frame_dirs) {
    ASSIGN_OR_RETURN(const nlohmann::ordered_json json, ReadFrameJson(dir));
    try {
      AddCounts(json, "disparity_histogram", data.disparity);
      AddCounts(json, "depth_histogram", data.depth);
      AddPixels(json, "object_pixels", data.object_pixels);
      AddPixels(json, "material_pixels", data.material_pixels);
      const auto& intrinsics = json.at("intrinsics");
      data.pixels += intrinsics.at("width").get<int64_t>() * intrinsics.at("height").get<int64_t>();
    } catch (const nlohmann::json::exception& error) {
      return DataLoss("{}/frame.json: {}", dir, error.what());
    }
    ++data.frames;
  }
  return data;
}

ImageRgb8 DrawHistogramPage(const std::string& title, const HistogramData& data) {
  const int half = (kWidth - 3 * kPageMargin) / 2;
  const int shares_y = 90 + 2 * (kPanelHeight + 24);
  Canvas canvas(kWidth, shares_y + 60 + kBarRows * kBarHeight + kPageMargin);
  canvas.DrawText(kPageMargin, 56, title, 19, kText, true);
  const std::string count = fmt::format("{}{}", data.frames, data.frames == 1 ? " pair" : " pairs");
  canvas.DrawText(kWidth - kPageMargin - Canvas::TextWidth(count, 13), 56, count, 13, kFaint);
  DrawHistogram(
      canvas, kPageMargin, 90, kWidth - 2 * kPageMargin,
      "Disparity of the left view, pixels; below each limit of training code: share of pixels",
      data.disparity, 64, {std::begin(kDisparityLimitsPx), std::end(kDisparityLimitsPx)});
  DrawHistogram(canvas, kPageMargin, 90 + kPanelHeight + 24, kWidth - 2 * kPageMargin,
                "Depth of the left view, metres", data.depth, 1, {});
  DrawShares(canvas, kPageMargin, shares_y, half, "Classes by share of pixels", data.object_pixels,
             data.pixels);
  DrawShares(canvas, 2 * kPageMargin + half, shares_y, half, "Materials by share of pixels",
             data.material_pixels, data.pixels);
  return canvas.image();
}

}  // namespace parallax
