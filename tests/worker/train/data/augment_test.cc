#include "worker/train/data/augment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

constexpr int kWidth = 320, kHeight = 160;

// A smooth random texture: waves of random direction, defined at any real coordinate.
class Texture {
 public:
  explicit Texture(Rng rng) {
    for (auto& wave : waves_) {
      wave = {rng.Uniform(-0.25, 0.25), rng.Uniform(-0.25, 0.25), rng.Uniform(0, 6.28)};
    }
  }
  uint8_t At(double x, double y, int channel) const {
    double sum = 0;
    for (const auto& [fx, fy, phase] : waves_) sum += std::sin(fx * x + fy * y + phase + channel);
    return static_cast<uint8_t>(std::clamp(128 + 25 * sum, 0.0, 255.0));
  }

 private:
  std::array<std::array<double, 3>, 8> waves_;
};

// A plane whose disparity grows from left to right, seen by both eyes: d(x_left) = 10 + x_left
// / 16.
TrainingPair MakePlane() {
  const Texture texture(Rng(SceneSeed{7}, "texture"));
  TrainingPair pair;
  for (TrainingEye* eye : {&pair.left, &pair.right}) {
    eye->image = ImageRgb8(kWidth, kHeight);
    eye->disparity_px = ImageF(kWidth, kHeight);
    eye->trust = ImageU8(kWidth, kHeight, kVisible);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double left_x = (x + 10) * 16 / 15.0;  // Column of the same point in the left eye.
      pair.left.disparity_px(x, y) = static_cast<float>(10 + x / 16.0);
      pair.right.disparity_px(x, y) = static_cast<float>(left_x - x);
      for (int c = 0; c < 3; ++c) {
        pair.left.image(x, y, c) = texture.At(x, y, c);
        pair.right.image(x, y, c) = texture.At(left_x, y, c);
      }
      if (x < pair.left.disparity_px(x, y)) pair.left.trust(x, y) = kOccluded;
      if (left_x > kWidth - 1) pair.right.trust(x, y) = kOccluded;
    }
  }
  return pair;
}

TrainSettings SmallCrops() {
  TrainSettings settings;
  settings.crop_height = 96;
  settings.crop_width = 160;
  return settings;
}

// Mean difference of the left image and the right one warped by the disparity, over visible pixels.
double WarpError(const TrainingCrop& crop) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < crop.height; ++y) {
    for (int x = 0; x < crop.width; ++x) {
      const size_t at = static_cast<size_t>(y * crop.width + x);
      if (crop.weight[at] != 1) continue;
      const double from = x - crop.disparity_px[at];
      const int x0 = static_cast<int>(from);
      if (from < 0 || x0 + 1 >= crop.width)
        ADD_FAILURE() << "visible pixel outside: " << x << "," << y;
      const double t = from - x0;
      const size_t row = static_cast<size_t>(y * crop.width + x0);
      sum += std::abs(crop.left[at] - (1 - t) * crop.right[row] - t * crop.right[row + 1]);
      ++count;
    }
  }
  EXPECT_GT(count, crop.height * crop.width / 4);
  return sum / std::max(1, count);
}

TEST(Augment, DisparityWarpsRightToLeftAfterEveryChangeOfGeometry) {
  const TrainingPair pair = MakePlane();
  struct Case {
    const char* name;
    double scale, stretch, flip, jitter;
  };
  const Case cases[] = {{"crop", 0, 0, 0, 0},      {"enlarge", 0.5, 0, 0, 0},
                        {"reduce", -0.4, 0, 0, 0}, {"stretch", 0, 0.3, 0, 0},
                        {"flip", 0, 0, 1, 0},      {"y_jitter", 0, 0, 0, 1},
                        {"all", 0.3, 0.2, 0.5, 1}};
  for (const Case& c : cases) {
    TrainSettings settings = SmallCrops();
    settings.augment.scale_low = std::min(0.0, c.scale);
    settings.augment.scale_high = std::max(0.0, c.scale);
    settings.augment.stretch = c.stretch;
    settings.augment.flip_probability = c.flip;
    settings.augment.y_jitter_probability = c.jitter;
    for (uint64_t draw = 0; draw < 8; ++draw) {
      const Rng rng = Rng(SceneSeed{1}, c.name).Child("draw", draw);
      const absl::StatusOr<CropGeometry> geometry = DrawGeometry(pair, settings, rng);
      ASSERT_TRUE(geometry.ok()) << geometry.status();
      const TrainingCrop crop = CutCrop(pair, *geometry, settings);
      // A wrong disparity by one pixel or a wrong flip changes this texture by 0.05 and more.
      EXPECT_LT(WarpError(crop), c.jitter > 0 ? 0.035 : 0.02) << c.name << " " << draw;
    }
  }
}

TEST(Augment, WarpCheckSeesWrongDisparities) {
  TrainingCrop crop = CutCrop(
      MakePlane(), {.x = 50, .y = 20, .width = 160, .height = 96, .y_right = 20}, SmallCrops());
  EXPECT_LT(WarpError(crop), 0.01);
  for (float& disparity : crop.disparity_px) disparity -= 2;
  EXPECT_GT(WarpError(crop), 0.04);
}

TEST(Augment, ColoursChangeImagesOnlyAndStayInRange) {
  const TrainSettings settings = SmallCrops();
  const CropGeometry geometry{.x = 50, .y = 20, .width = 160, .height = 96, .y_right = 20};
  const TrainingCrop plain = CutCrop(MakePlane(), geometry, settings);
  for (uint64_t draw = 0; draw < 20; ++draw) {
    TrainingCrop crop = plain;
    ChangeColours(crop, settings.augment, Rng(SceneSeed{2}).Child("draw", draw));
    EXPECT_EQ(crop.disparity_px, plain.disparity_px);
    EXPECT_EQ(crop.weight, plain.weight);
    EXPECT_NE(crop.left, plain.left);
    for (const std::vector<float>* image : {&crop.left, &crop.right}) {
      for (const float value : *image) ASSERT_TRUE(value >= 0 && value <= 1) << value;
    }
  }
}

TEST(Augment, HueAndSaturationKeepGreyGrey) {
  TrainingCrop crop;
  crop.height = crop.width = 64;
  crop.left = crop.right = std::vector<float>(3 * 64 * 64, 0.5f);
  AugmentSettings settings;
  settings.colour_probability = 1;
  settings.noise_probability = settings.erase_probability = settings.blur_probability = 0;
  ChangeColours(crop, settings, Rng(SceneSeed{3}));
  EXPECT_NEAR(crop.left[0], crop.left[64 * 64], 1e-5);
  EXPECT_NEAR(crop.left[0], crop.left[2 * 64 * 64], 1e-5);
}

TEST(Augment, PixelsWithoutTruthOrBeyondTheRangeHaveNoWeight) {
  TrainingPair pair = MakePlane();
  TrainSettings settings = SmallCrops();
  settings.max_disparity = 32;
  std::fill(pair.left.trust.values().begin(), pair.left.trust.values().begin() + kWidth * 30,
            kNoTruth);
  const TrainingCrop crop =
      CutCrop(pair, {.x = 160, .y = 0, .width = 160, .height = 96, .y_right = 0}, settings);
  for (size_t i = 0; i < crop.weight.size(); ++i) {
    const bool none = i < 160 * 30 || crop.disparity_px[i] >= 32;
    EXPECT_EQ(crop.weight[i] == 0, none) << i;
  }
}

TEST(Augment, RefusesPairsSmallerThanTheCrop) {
  TrainSettings settings = SmallCrops();
  settings.crop_width = 352;
  const absl::Status status = Augment(MakePlane(), settings, Rng(SceneSeed{1})).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_EQ(status.message(), "a pair of 320x160 px is smaller than the crop of 352x96");
}

}  // namespace
}  // namespace parallax
