#include "worker/evaluate/prepared_pair.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/image/io.h"
#include "common/image/picture_pair.h"
#include "worker/evaluate/shrink_picture.h"

namespace parallax {
namespace {

// Truth of wrong scale seldom comes so near to zero by chance.
constexpr float kLeastShareOfWidth = 0.01f;
// Another match must be so much better: far from what noise does.
constexpr double kOtherIsBetter = 0.6;
// Steps of a pixel in files of truth; without a word 256 is taken.
constexpr int kOtherSteps[] = {8, 16, 32, 64, 100, 128, 512, 1000};
constexpr double kUsualSteps = 256;
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

// Sums over pixels of how the pictures differ where the truth as given says, and another one.
class OtherMatch {
 public:
  void Add(int given, int other) {
    given_ += given;
    other_ += other;
    ++samples_;
  }
  // The other difference as a share of the given one; 1 where too few pixels say anything.
  double Share() const {
    return samples_ < kLeastSamples || given_ <= 0 ? 1 : std::min(1.0, other_ / given_);
  }

 private:
  double given_ = 0, other_ = 0;
  int samples_ = 0;
};

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
  const std::string misfit = WhyTruthMisfits(left, right, disparity_px);
  if (!misfit.empty()) {
    notes.push_back("pair " + pair.name + ": " + misfit);
  } else if (largest > 0 && largest < kLeastShareOfWidth * static_cast<float>(left.width())) {
    notes.push_back(fmt::format(
        "pair {}: its largest disparity is {:.3g} px, less than 1 % of the width of {} px: a "
        "wrong scale? (`scale: N` in a list)",
        pair.name, largest, left.width()));
  }
  return absl::OkStatus();
}

}  // namespace

std::string WhyTruthMisfits(const ImageRgb8& left, const ImageRgb8& right,
                            const ImageF& disparity_px) {
  if (left.values() == right.values()) return "its two pictures are the same";
  const size_t step = 1 + disparity_px.pixels() / kMostSamples;
  const int width = left.width();
  const auto inside = [width](int x) { return x >= 0 && x < width; };
  OtherMatch mirrored, exchanged, scaled[std::size(kOtherSteps)];
  for (size_t i = 0; i < disparity_px.pixels(); i += step) {
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    const double d_px = double{disparity_px.values()[i]};
    const int d = static_cast<int>(std::lround(d_px));
    if (!(d_px > 0) || !inside(x - d)) continue;
    const int given = Difference(left, x, right, x - d, y);
    for (size_t k = 0; k < std::size(kOtherSteps); ++k) {
      const int other = static_cast<int>(std::lround(d_px * kUsualSteps / kOtherSteps[k]));
      if (other != d && inside(x - other)) {
        scaled[k].Add(given, Difference(left, x, right, x - other, y));
      }
    }
    if (d < 1 || !inside(x + d)) continue;
    mirrored.Add(given, Difference(left, x, right, x + d, y));
    exchanged.Add(given, Difference(right, x, left, x - d, y));
  }
  const double swapped = std::min(mirrored.Share(), exchanged.Share());
  if (swapped < kOtherIsBetter) {
    return fmt::format(
        "its pictures look swapped: with left and right exchanged the truth matches them with "
        "{:.0f} % of the difference",
        100 * swapped);
  }
  const OtherMatch* best = std::min_element(
      std::begin(scaled), std::end(scaled),
      [](const OtherMatch& a, const OtherMatch& b) { return a.Share() < b.Share(); });
  if (best->Share() >= kOtherIsBetter) return "";
  const int steps = kOtherSteps[best - scaled];
  return fmt::format(
      "its truth looks wrongly scaled: {:.3g} times as large it matches the pictures with {:.0f} % "
      "of the difference, as by `scale: {}` in a list where 256 was taken",
      kUsualSteps / steps, 100 * best->Share(), steps);
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
