#include "worker/train/network/exchange_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/csrc/jit/api/module.h>
#include <unistd.h>

#include <filesystem>

#include "common/base/system/file.h"

namespace parallax {
namespace {

using testing::HasSubstr;

// A picture of one colour.
ImageRgb8 Picture(int width, int height, uint8_t red, uint8_t green, uint8_t blue) {
  ImageRgb8 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y, 0) = red;
      image(x, y, 1) = green;
      image(x, y, 2) = blue;
    }
  }
  return image;
}

std::string Onnx(const std::string& name) { return std::string(NETWORKS) + "/" + name + ".onnx"; }

// A TorchScript module in a file; `forward` is its source.
class TorchScriptFile {
 public:
  explicit TorchScriptFile(const std::string& forward)
      : path_(testing::TempDir() + "script_" + std::to_string(getpid()) + "_" +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ".pt") {
    torch::jit::Module module("Network");
    module.define(forward);
    module.save(path_);
  }
  ~TorchScriptFile() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

absl::StatusOr<ImageF> Predict(const std::string& path, ExchangeFormat format,
                               const NetworkConventions& conventions, const ImageRgb8& left,
                               const ImageRgb8& right) {
  absl::StatusOr<ExchangeNetwork> network = ExchangeNetwork::Load(path, format, conventions, 1);
  if (!network.ok()) return network.status();
  return network->Predict(left, right);
}

// Every pixel is near `wanted`, and the picture is of the size of `left`.
void ExpectEverywhere(const absl::StatusOr<ImageF>& disparity, double wanted,
                      const ImageRgb8& left) {
  ASSERT_TRUE(disparity.ok()) << disparity.status();
  ASSERT_EQ(disparity->width(), left.width());
  ASSERT_EQ(disparity->height(), left.height());
  for (const float value : disparity->values()) ASSERT_NEAR(value, wanted, 1e-3);
}

TEST(OnnxNetwork, TakesPairsOfAnySizeAndGivesTheOutputThatIsAskedFor) {
  for (const int width : {50, 64, 101}) {
    const ImageRgb8 left = Picture(width, 40, 90, 60, 30), right = Picture(width, 40, 60, 30, 0);
    ExpectEverywhere(Predict(Onnx("two_inputs"), ExchangeFormat::kOnnx, {}, left, right), 30, left);
    ExpectEverywhere(Predict(Onnx("two_inputs"), ExchangeFormat::kOnnx, {.output = 0}, left, right),
                     15, left);
  }
}

TEST(OnnxNetwork, NamesOfInputsSayWhichEyeTheyAre) {
  const ImageRgb8 left = Picture(64, 32, 90, 60, 30), right = Picture(64, 32, 60, 30, 0);
  ExpectEverywhere(Predict(Onnx("right_first"), ExchangeFormat::kOnnx, {}, left, right), 30, left);
}

TEST(OnnxNetwork, TheSecondInputMayBeTheLeftEye) {
  std::string bytes = *ReadFile(Onnx("right_first"));
  for (size_t at; (at = bytes.find("right")) != std::string::npos;) bytes.replace(at, 5, "image");
  const std::string path = testing::TempDir() + "left_second_" + std::to_string(getpid()) + ".onnx";
  ASSERT_TRUE(WriteFile(path, bytes).ok());
  const ImageRgb8 left = Picture(64, 32, 90, 60, 30), right = Picture(64, 32, 60, 30, 0);
  ExpectEverywhere(Predict(path, ExchangeFormat::kOnnx, {}, left, right), 30, left);
  std::filesystem::remove(path);
}

TEST(OnnxNetwork, SoftmaxWithoutAnAxisTakesTheLastOne) {
  // A row of equal values gives 1 / width; over the channels it would be 1 / 3 for equal ones.
  const ImageRgb8 left = Picture(64, 32, 9, 9, 9), right = Picture(64, 32, 0, 0, 0);
  ExpectEverywhere(Predict(Onnx("last_axis"), ExchangeFormat::kOnnx, {}, left, right), 320.0 / 64,
                   left);
}

TEST(OnnxNetwork, OneNetworkTakesPairsOfSeveralSizes) {
  auto network = ExchangeNetwork::Load(Onnx("two_inputs"), ExchangeFormat::kOnnx, {}, 1);
  ASSERT_TRUE(network.ok()) << network.status();
  for (const int width : {50, 101, 50}) {
    const ImageRgb8 left = Picture(width, 40, 90, 60, 30), right = Picture(width, 40, 60, 30, 0);
    ExpectEverywhere(network->Predict(left, right), 30, left);
  }
}

// The file says 64x32: pictures are scaled to it, and disparities by 128 / 64 back.
TEST(OnnxNetwork, ANetworkOfOneSizeSeesScaledPictures) {
  const ImageRgb8 left = Picture(128, 50, 40, 40, 40), right = Picture(128, 50, 30, 30, 30);
  ExpectEverywhere(Predict(Onnx("stacked"), ExchangeFormat::kOnnx, {.negate = true}, left, right),
                   20, left);
  ExpectEverywhere(Predict(Onnx("stacked"), ExchangeFormat::kOnnx, {}, left, right), 0, left);
}

TEST(OnnxNetwork, ErrorsTellWhatTheFileIsAndWhatIsWanted) {
  const ImageRgb8 left = Picture(64, 32, 1, 1, 1);
  const struct {
    std::string path;
    NetworkConventions conventions;
    const char* says;
  } cases[] = {
      {std::string(NETWORKS) + "/make_networks.py", {}, "is not an ONNX file"},
      {Onnx("three_inputs"), {}, "its inputs are left, right, mask, but must be two of 3 channels"},
      {Onnx("unknown"), {}, "of type \"GridSample\"; a command with another library"},
      {Onnx("stacked"),
       {.width_px = 32, .height_px = 32},
       "takes pictures of 64x32 px, but the size is 32x32"},
      {Onnx("two_inputs"), {.width_px = -64, .height_px = 32}, "the network's size is -64x32 px"},
      {Onnx("two_inputs"), {.width_px = 64}, "the network's size is 64x0 px"},
      {Onnx("two_inputs"), {.output = 2}, "the network has 2 outputs, but the output is number 2"},
      {Onnx("two_inputs"),
       {.output = -3},
       "the network has 2 outputs, but the output is number -3"},
  };
  for (const auto& c : cases) {
    const absl::Status status =
        Predict(c.path, ExchangeFormat::kOnnx, c.conventions, left, left).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(c.says));
  }
  EXPECT_TRUE(absl::IsNotFound(
      ExchangeNetwork::Load("/no/such.onnx", ExchangeFormat::kOnnx, {}, 1).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(
      Predict(Onnx("two_inputs"), ExchangeFormat::kOnnx, {}, left, Picture(32, 32, 1, 1, 1))
          .status()));
}

TEST(TorchScriptNetwork, SeesTheRangeMeanAndOrderOfChannelsThatItWants) {
  const TorchScriptFile first(
      "def forward(self, left, right):\n  return left[:, 0:1] - 0 * right[:, 0:1]\n");
  const ImageRgb8 left = Picture(50, 40, 204, 102, 51), right = Picture(50, 40, 0, 0, 0);
  const auto format = ExchangeFormat::kTorchScript;
  ExpectEverywhere(Predict(first.path(), format, {}, left, right), 204, left);
  ExpectEverywhere(Predict(first.path(), format, {.pixel_range = 1}, left, right), 0.8, left);
  ExpectEverywhere(Predict(first.path(), format, {.bgr = true}, left, right), 51, left);
  NetworkConventions conventions{.pixel_range = 1};
  conventions.mean = {0.3, 0, 0};
  conventions.std = {0.25, 1, 1};
  ExpectEverywhere(Predict(first.path(), format, conventions, left, right), 2, left);
}

TEST(TorchScriptNetwork, NamesOfArgumentsSayWhichEyeTheyAre) {
  const ImageRgb8 left = Picture(64, 32, 90, 60, 30), right = Picture(64, 32, 60, 30, 0);
  for (const auto& [first, second] :
       {std::pair("right", "left"), {"right", "b"}, {"a", "img_left"}, {"imgR", "imgL"}}) {
    const std::string one = first, two = second;
    const TorchScriptFile file("def forward(self, " + one + ", " + two + "):\n  return " + two +
                               "[:, 0:1] - " + one + "[:, 0:1]\n");
    ExpectEverywhere(Predict(file.path(), ExchangeFormat::kTorchScript, {}, left, right), 30, left);
  }
}

TEST(TorchScriptNetwork, PaddingRepeatsTheLastPixelsAndIsCutOff) {
  const TorchScriptFile width(
      "def forward(self, left, right):\n"
      "  return (left[:, 0:1] * 0 + left.size(3)).squeeze(1), [left[:, 0:1].mean() + right * 0]\n");
  const ImageRgb8 left = Picture(50, 40, 204, 102, 51), right = Picture(50, 40, 0, 0, 0);
  const auto format = ExchangeFormat::kTorchScript;
  ExpectEverywhere(Predict(width.path(), format, {.output = 0}, left, right), 64, left);
  ExpectEverywhere(Predict(width.path(), format, {.pad_multiple = 60, .output = 0}, left, right),
                   60, left);
  ExpectEverywhere(Predict(width.path(), format, {}, left, right), 204, left);
  // Scaled to 100 px, so that its 100 are 50 of the picture's.
  ExpectEverywhere(
      Predict(width.path(), format, {.width_px = 100, .height_px = 20, .output = 0}, left, right),
      50, left);
}

TEST(TorchScriptNetwork, ErrorsTellWhatTheNetworkSays) {
  const ImageRgb8 left = Picture(64, 32, 1, 1, 1);
  const struct {
    const char* forward;
    absl::StatusCode code;
    const char* says;
  } cases[] = {
      {"def forward(self, a, b, c):\n  return a\n", absl::StatusCode::kInvalidArgument,
       "forward takes 3 arguments"},
      {"def forward(self, a, b):\n  return a[:, 0:1, ::2]\n", absl::StatusCode::kInvalidArgument,
       "has the shape (1, 1, 16, 64), but must be disparities of the 64x32 px"},
      {"def forward(self, a, b):\n  return a[:, 0:1] / 0 * 0\n", absl::StatusCode::kInternal,
       "pixel (0, 0) is not finite"},
      {"def forward(self, a, b):\n  assert False, 'too small'\n  return a\n",
       absl::StatusCode::kInternal, "AssertionError: too small"},
  };
  for (const auto& c : cases) {
    const TorchScriptFile file(c.forward);
    const absl::Status status =
        Predict(file.path(), ExchangeFormat::kTorchScript, {}, left, left).status();
    EXPECT_EQ(status.code(), c.code) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(c.says));
  }
  const absl::Status status =
      Predict(Onnx("stacked"), ExchangeFormat::kTorchScript, {}, left, left).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("cannot load it as TorchScript"));
}

}  // namespace
}  // namespace parallax
