#include "worker/render/lights/environment.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <numbers>
#include <utility>

#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/image/hdr.h"
#include "common/image/io.h"
#include "common/math/color.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr int kWidestEnvironment = 2048;  // Larger pictures are averaged down.
constexpr int kMostColumns = 512;         // Columns of the grid that samples are drawn from.

// Means of `factor` x `factor` pixels.
ImageF3 AveragedDown(const ImageF3& image, int factor) {
  if (factor <= 1) return image;
  ImageF3 out(std::max(1, image.width() / factor), std::max(1, image.height() / factor));
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = 0; j < factor; ++j) {
          for (int i = 0; i < factor; ++i) {
            sum += double{image(x * factor + i, y * factor + j, c)};
          }
        }
        out(x, y, c) = static_cast<float>(sum / (factor * factor));
      }
    }
  }
  return out;
}

// The most that a sky of half floats holds: brighter pixels, of the sun, come as infinite.
constexpr float kLargestHalf = 65504;

// Makes values below 0, which resampling leaves beside the sun, 0, and infinite ones as large as
// the largest of the picture, at least kLargestHalf. Returns how many and where, or "". Errors:
// kInvalidArgument for a value that is no number, with its place.
absl::StatusOr<std::string> MendLight(ImageF3& picture) {
  float largest = kLargestHalf;
  for (const float value : picture.values()) {
    if (std::isfinite(value)) largest = std::max(largest, value);
  }
  size_t negative = 0, infinite = 0, first = 0;
  for (size_t i = 0; i < picture.values().size(); ++i) {
    float& value = picture.values()[i];
    if (std::isfinite(value) && value >= 0) continue;
    const size_t pixel = i / 3, width = static_cast<size_t>(picture.width());
    if (std::isnan(value)) {
      return InvalidArgument("a value that is no number (NaN) at column {}, row {}", pixel % width,
                             pixel / width);
    }
    if (negative + infinite == 0) first = pixel;
    ++(value < 0 ? negative : infinite);
    value = value < 0 ? 0 : largest;
  }
  if (negative + infinite == 0) return "";
  std::string text;
  if (negative > 0) text = fmt::format("{} values below 0 taken as 0", negative);
  if (infinite > 0) {
    text +=
        fmt::format("{}{} infinite values as {:g}", text.empty() ? "" : ", ", infinite, largest);
  }
  return fmt::format("{}; the first at column {}, row {}", text,
                     first % static_cast<size_t>(picture.width()),
                     first / static_cast<size_t>(picture.width()));
}

float PixelLuminance(const ImageF3& image, int x, int y) {
  const float* p = image.At(x, y);
  return Luminance(Vec3f(p[0], p[1], p[2]));
}

// The position of `value` among cumulative sums from 0 to 1: the cell, and the share within it.
struct FoundCell {
  int cell = 0;
  float part = 0;
};
FoundCell FindCell(const float* sums, int cells, float value) {
  const float* above = std::upper_bound(sums + 1, sums + cells, value);
  const auto cell = static_cast<int>(above - sums) - 1;
  const float width = sums[cell + 1] - sums[cell];
  return {cell, width > 0 ? std::clamp((value - sums[cell]) / width, 0.0f, 1.0f) : 0.5f};
}

using OpenedEnvironment = std::pair<uint64_t, std::shared_ptr<const Environment>>;
constexpr size_t kEnvironmentsKept = 4;

std::mutex& OpenedMutex() {
  static auto* mutex = new std::mutex;
  return *mutex;
}
std::deque<OpenedEnvironment>& NewestOpened() {  // Under OpenedMutex.
  static auto* newest = new std::deque<OpenedEnvironment>;
  return *newest;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Environment>> OpenEnvironment(uint64_t seed) {
  {
    std::lock_guard<std::mutex> lock(OpenedMutex());
    for (const OpenedEnvironment& opened : NewestOpened()) {
      if (opened.first == seed) return opened.second;
    }
  }
  ASSIGN_OR_RETURN(const std::string path, FindEnvironment(seed));
  ASSIGN_OR_RETURN(std::shared_ptr<const Environment> environment, Environment::Read(path));
  std::lock_guard<std::mutex> lock(OpenedMutex());
  NewestOpened().emplace_front(seed, environment);
  if (NewestOpened().size() > kEnvironmentsKept) NewestOpened().pop_back();
  return environment;
}

absl::StatusOr<std::shared_ptr<const Environment>> Environment::Read(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  const bool exr = bytes.substr(0, 4) == std::string_view("\x76\x2f\x31\x01", 4);
  absl::StatusOr<ImageF3> picture = exr ? DecodeExrPicture(bytes) : DecodeHdr(bytes);
  if (!picture.ok()) return WithContext(picture.status(), path);
  const absl::StatusOr<std::string> note = MendLight(*picture);
  if (!note.ok()) return WithContext(note.status(), path);
  if (!note->empty()) LogWarning("sky", {{"file", path}, {"note", *note}});
  auto environment = MakeNoted(*picture, *note);
  if (!environment.ok()) return WithContext(environment.status(), path);
  return environment;
}

absl::StatusOr<std::shared_ptr<const Environment>> Environment::Make(const ImageF3& picture) {
  return MakeNoted(picture, "");
}

absl::StatusOr<std::shared_ptr<const Environment>> Environment::MakeNoted(const ImageF3& picture,
                                                                          std::string note) {
  const int width = picture.width(), height = picture.height();
  if (height < 2 || std::abs(width - 2 * height) > 1) {
    return InvalidArgument(
        "{} x {} pixels, wanted twice as wide as high: an equirectangular picture", width, height);
  }
  for (const float value : picture.values()) {
    if (std::isfinite(value) && value >= 0) continue;
    return InvalidArgument("a value of {:f}, wanted finite ones of at least 0", value);
  }
  std::shared_ptr<Environment> environment(new Environment);
  environment->note_ = std::move(note);
  environment->picture_ =
      AveragedDown(picture, (width + kWidestEnvironment - 1) / kWidestEnvironment);
  environment->MakeDensity();
  if (!(environment->mean_luminance_ > 0 && environment->ground_irradiance_ > 0)) {
    return InvalidArgument("black above the horizon, wanted light");
  }
  return std::shared_ptr<const Environment>(std::move(environment));
}

void Environment::MakeDensity() {
  const int factor = std::max(1, (picture_.width() + kMostColumns - 1) / kMostColumns);
  const ImageF3 cells = AveragedDown(picture_, factor);
  columns_ = cells.width();
  rows_ = cells.height();
  density_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  rows_up_to_.assign(1, 0);
  double total = 0, upper = 0, upper_angle = 0;
  std::vector<double> rows;
  for (int y = 0; y < rows_; ++y) {
    const double top = std::cos(std::numbers::pi * y / rows_);
    const double bottom = std::cos(std::numbers::pi * (y + 1) / rows_);
    const double angle = 2 * std::numbers::pi * (top - bottom) / columns_;  // A cell's solid angle.
    double row = 0;
    std::vector<double> sums = {0};
    for (int x = 0; x < columns_; ++x) {
      const double light = double{PixelLuminance(cells, x, y)};
      density_[static_cast<size_t>(y * columns_ + x)] = static_cast<float>(light);
      row += light * angle;
      sums.push_back(row);
      if (bottom < 0) continue;
      upper += light * angle;
      upper_angle += angle;
      ground_irradiance_ += static_cast<float>(light * angle * 0.5 * (top + bottom));
    }
    for (const double sum : sums) {
      cells_up_to_.push_back(row > 0 ? static_cast<float>(sum / row) : 0.0f);
    }
    rows.push_back(row);
    total += row;
  }
  if (!(total > 0)) return;
  double sum = 0;
  for (const double row : rows) rows_up_to_.push_back(static_cast<float>((sum += row) / total));
  for (float& density : density_) density = static_cast<float>(double{density} / total);
  mean_luminance_ = static_cast<float>(upper / upper_angle);
}

Vec2f Environment::PlaceOf(const Vec3f& direction) const {
  const float azimuth = std::atan2(direction.y(), direction.x());
  const float polar = std::acos(std::clamp(direction.z(), -1.0f, 1.0f));
  return {(0.5f - azimuth / (2.0f * kPi)) * static_cast<float>(picture_.width()),
          polar / kPi * static_cast<float>(picture_.height())};
}

Vec3f Environment::DirectionOf(float x, float y) const {
  const float azimuth = (0.5f - x / static_cast<float>(picture_.width())) * 2.0f * kPi;
  const float polar = y / static_cast<float>(picture_.height()) * kPi;
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
          std::cos(polar)};
}

Vec3f Environment::Radiance(const Vec3f& direction) const {
  const Vec2f place = PlaceOf(direction) - Vec2f(0.5f, 0.5f);
  const auto x0 = static_cast<int>(std::floor(place.x()));
  const auto y0 = static_cast<int>(std::floor(place.y()));
  const float s = place.x() - static_cast<float>(x0), t = place.y() - static_cast<float>(y0);
  const auto at = [this](int x, int y) {
    const int width = picture_.width();
    const float* p =
        picture_.At((x % width + width) % width, std::clamp(y, 0, picture_.height() - 1));
    return Vec3f(p[0], p[1], p[2]);
  };
  const Vec3f above = at(x0, y0) * (1 - s) + at(x0 + 1, y0) * s;
  const Vec3f below = at(x0, y0 + 1) * (1 - s) + at(x0 + 1, y0 + 1) * s;
  return above * (1 - t) + below * t;
}

Vec3x8 Environment::Radiance(const Vec3x8& directions) const {
  Vec3x8 radiance = Vec3x8::Zero();
  for (int lane = 0; lane < kLanes; ++lane) radiance.Set(lane, Radiance(directions.Get(lane)));
  return radiance;
}

Vec3f Environment::Sample(float u, float v) const {
  const FoundCell row = FindCell(rows_up_to_.data(), rows_, v);
  const float* sums = &cells_up_to_[static_cast<size_t>(row.cell * (columns_ + 1))];
  const FoundCell cell = FindCell(sums, columns_, u);
  // Uniform over the cell's solid angle: uniform in the cosine between its two sides.
  const float top = std::cos(kPi * static_cast<float>(row.cell) / static_cast<float>(rows_));
  const float bottom = std::cos(kPi * static_cast<float>(row.cell + 1) / static_cast<float>(rows_));
  const float cosine = std::clamp(top + (bottom - top) * row.part, -1.0f, 1.0f);
  const float x = (static_cast<float>(cell.cell) + cell.part) / static_cast<float>(columns_);
  return DirectionOf(x * static_cast<float>(picture_.width()),
                     std::acos(cosine) / kPi * static_cast<float>(picture_.height()));
}

float Environment::Pdf(const Vec3f& direction) const {
  const Vec2f place = PlaceOf(direction);
  const auto cell = [](float at, int size, int cells) {
    return std::clamp(static_cast<int>(at / static_cast<float>(size) * static_cast<float>(cells)),
                      0, cells - 1);
  };
  const int x = cell(place.x(), picture_.width(), columns_);
  const int y = cell(place.y(), picture_.height(), rows_);
  return density_[static_cast<size_t>(y * columns_ + x)];
}

}  // namespace parallax
