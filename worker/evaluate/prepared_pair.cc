#include "worker/evaluate/prepared_pair.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/image/io.h"
#include "common/image/picture_pair.h"
#include "worker/evaluate/shrink_picture.h"

namespace parallax {
namespace {

// Truth of wrong scale seldom comes so near to zero by chance.
constexpr float kLeastShareOfWidth = 0.01f;
// The mirrored match must be so much better: far from what noise does.
constexpr double kMirroredIsBetter = 0.6;
constexpr int kLeastSamples = 200, kMostSamples = 20000;

std::string Absolute(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

// Whether a file may have more than 8 bits: a PNG of 16.
bool IsDeep(const std::string& path) {
  constexpr size_t kHeader = 25, kDepth = 24;
  char header[kHeader] = "";
  std::ifstream(path, std::ios::binary).read(header, kHeader);
  return header[0] == '\x89' && header[kDepth] == 16;
}

int Difference(const ImageRgb8& a, int ax, const ImageRgb8& b, int bx, int y) {
  int sum = 0;
  for (int c = 0; c < 3; ++c) sum += std::abs(a(ax, y, c) - b(bx, y, c));
  return sum;
}

absl::Status CheckTruth(const BenchmarkPair& pair, const ImageRgb8& left, const ImageRgb8& right,
                        std::vector<std::string>& notes) {
  ASSIGN_OR_RETURN(const PairTruth truth, pair.read_truth());
  const ImageF& disparity_px = truth.disparity_px;
  if (disparity_px.width() != left.width() || disparity_px.height() != left.height()) {
    return InvalidArgument("pair {}: truth of {}x{} for pictures of {}x{}", pair.name,
                           disparity_px.width(), disparity_px.height(), left.width(),
                           left.height());
  }
  const auto& values = disparity_px.values();
  const float largest = *std::max_element(values.begin(), values.end());
  if (largest > 0 && largest < kLeastShareOfWidth * static_cast<float>(left.width())) {
    notes.push_back(fmt::format(
        "pair {}: its largest disparity is {:.3g} px, less than 1 % of the width of {} px: a "
        "wrong scale? (`scale: N` in a list)",
        pair.name, largest, left.width()));
  }
  const std::string swapped = WhySwapped(left, right, disparity_px);
  if (!swapped.empty()) notes.push_back("pair " + pair.name + ": " + swapped);
  return absl::OkStatus();
}

}  // namespace

std::string WhySwapped(const ImageRgb8& left, const ImageRgb8& right, const ImageF& disparity_px) {
  const size_t step = 1 + disparity_px.pixels() / kMostSamples;
  double as_given = 0, mirrored = 0, exchanged = 0;
  int samples = 0;
  for (size_t i = 0; i < disparity_px.pixels(); i += step) {
    const int width = left.width(), x = static_cast<int>(i) % width,
              y = static_cast<int>(i) / width;
    const int d = static_cast<int>(std::lround(disparity_px.values()[i]));
    if (d < 1 || x - d < 0 || x + d >= width) continue;
    as_given += Difference(left, x, right, x - d, y);
    mirrored += Difference(left, x, right, x + d, y);
    exchanged += Difference(right, x, left, x - d, y);
    ++samples;
  }
  if (samples < kLeastSamples) return "";
  if (std::min(mirrored, exchanged) >= kMirroredIsBetter * as_given) return "";
  return fmt::format(
      "its pictures look swapped: with left and right exchanged the truth matches them with {:.0f} "
      "% of the difference",
      100 * std::min(mirrored, exchanged) / as_given);
}

absl::StatusOr<PreparedPair> PreparePair(const BenchmarkPair& pair, const std::string& stem,
                                         PairCheck check) {
  PreparedPair prepared{Absolute(pair.left), Absolute(pair.right), {}};
  const bool reduced = pair.shrink > 1;
  const bool reads = reduced || check != PairCheck::kNothing;
  if (!reads && !IsDeep(pair.left) && !IsDeep(pair.right)) return prepared;
  ASSIGN_OR_RETURN(PicturePair pictures, ReadPicturePair(pair.left, pair.right));
  prepared.notes = std::move(pictures.notes);
  if (reduced) {
    pictures.left = ShrinkPicture(pictures.left, pair.shrink);
    pictures.right = ShrinkPicture(pictures.right, pair.shrink);
  }
  if (reduced || pictures.rescaled) {
    prepared.left = stem + "_left.png";
    prepared.right = stem + "_right.png";
    RETURN_IF_ERROR(WritePng(prepared.left, pictures.left));
    RETURN_IF_ERROR(WritePng(prepared.right, pictures.right));
  }
  if (check == PairCheck::kPicturesAndTruth) {
    RETURN_IF_ERROR(CheckTruth(pair, pictures.left, pictures.right, prepared.notes));
  }
  return prepared;
}

}  // namespace parallax
