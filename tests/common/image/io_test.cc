#include "common/image/io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/base/rng.h"
#include "common/base/system/file.h"
#include "common/base/system/memory_budget.h"
#include "common/image/jpeg.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

// Random bits in every channel; odd sizes catch wrong strides.
template <typename ImageType>
ImageType Noise(int width, int height) {
  ImageType image(width, height);
  Rng rng(SceneSeed{1}, "noise");
  for (auto& value : image.values()) {
    if constexpr (std::is_floating_point_v<typename ImageType::Value>) {
      value = static_cast<float>(rng.Normal(0, 10));
    } else {
      value = static_cast<typename ImageType::Value>(rng.Bits32());
    }
  }
  return image;
}

constexpr struct { int width, height; } kSizes[] = {{1, 1}, {7, 5}, {64, 33}};

TEST(Png, RoundTripsExactly) {
  for (const auto& size : kSizes) {
    for (const int compression : {1, 2, 3}) {
      const auto rgb = Noise<ImageRgb8>(size.width, size.height);
      EXPECT_EQ(*DecodePngRgb8(*EncodePng(rgb, compression)), rgb);
      const auto u8 = Noise<ImageU8>(size.width, size.height);
      EXPECT_EQ(*DecodePngU8(*EncodePng(u8, compression)), u8);
      const auto u16 = Noise<ImageU16>(size.width, size.height);
      EXPECT_EQ(*DecodePngU16(*EncodePng(u16, compression)), u16);
    }
  }
}

TEST(Png, RedIsRedForOtherReaders) {
  ImageRgb8 image(2, 1);
  image(0, 0, 0) = 255;
  const std::string bytes = *EncodePng(image);
  const cv::Mat bgr =
      cv::imdecode(std::vector<uint8_t>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 255));
}

// Hashes of frames that are stored already must not change.
TEST(Png, BytesAreThoseOfOpenCv) {
  const auto rgb = Noise<ImageRgb8>(64, 33);
  const cv::Mat mat(33, 64, CV_8UC3, const_cast<uint8_t*>(rgb.data()));
  cv::Mat bgr(33, 64, CV_8UC3);
  for (int y = 0; y < 33; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) bgr.at<cv::Vec3b>(y, x)[c] = mat.at<cv::Vec3b>(y, x)[2 - c];
    }
  }
  std::vector<uint8_t> bytes;
  cv::imencode(".png", bgr, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, 0});
  EXPECT_EQ(*EncodePng(rgb), std::string(bytes.begin(), bytes.end()));
}

TEST(Png, BitsReadBackAsBlackAndWhite) {
  ImageU8 bits(11, 2);
  bits(3, 1) = 7;
  const ImageU8 again = *DecodePngU8(*EncodePngBits(bits));
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 11; ++x) EXPECT_EQ(again(x, y), x == 3 && y == 1 ? 255 : 0);
  }
}

TEST(Png, CutAndImpossibleFilesAreRefused) {
  const std::string bytes = *EncodePng(Noise<ImageRgb8>(9, 4));
  for (const size_t length : {size_t{4}, size_t{20}, bytes.size() / 2, bytes.size() - 13}) {
    EXPECT_THAT(std::string(DecodePngRgb8(bytes.substr(0, length)).status().message()),
                HasSubstr("broken PNG: "))
        << length;
  }
  std::string huge = bytes;
  huge[16] = huge[20] = 0x00;
  huge[17] = huge[21] = 0x0f;  // About a million pixels each way.
  EXPECT_FALSE(DecodePngRgb8(huge).ok());
}

// Reads the same file by OpenCV, as R G B.
ImageRgb8 ByOpenCv(const std::string& path) {
  const cv::Mat bgr = cv::imread(path, cv::IMREAD_COLOR);
  ImageRgb8 image(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = bgr.at<cv::Vec3b>(y, x)[2 - c];
    }
  }
  return image;
}

class PictureTest : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  ImageRgb8 ReadAgain() {
    const auto image = ReadPictureRgb8(path_);
    EXPECT_TRUE(image.ok()) << image.status();
    return image.ok() ? *image : ImageRgb8();
  }
  // ctest runs tests of one program side by side.
  std::string path_ = ::testing::TempDir() + "io_test_" +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(PictureTest, GreyDeepAndTransparentPngsBecomeRgb) {
  const cv::Mat samples[] = {cv::Mat(5, 7, CV_8UC1, cv::Scalar(90)),
                             cv::Mat(5, 7, CV_16UC3, cv::Scalar(65535, 32768, 256)),
                             cv::Mat(5, 7, CV_8UC4, cv::Scalar(10, 20, 30, 128))};
  for (const cv::Mat& sample : samples) {
    std::vector<uint8_t> bytes;
    cv::imencode(".png", sample, bytes);
    ASSERT_TRUE(WriteFile(path_, std::string(bytes.begin(), bytes.end())).ok());
    EXPECT_EQ(ReadAgain(), ByOpenCv(path_)) << sample.channels() << " channels";
  }
}

// A JPEG that says in Exif how its camera was held.
std::string WithOrientation(const std::string& jpeg, int orientation) {
  using std::string_literals::operator""s;
  const std::string exif = "Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"s +
                           static_cast<char>(orientation) + "\0\0\0\0\0\0"s;
  const size_t length = exif.size() + 2;
  return jpeg.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) +
         static_cast<char>(length & 0xff) + exif + jpeg.substr(2);
}

TEST_F(PictureTest, JpegsStandUprightAsOpenCvShowsThem) {
  const std::string jpeg = *EncodeJpeg(Noise<ImageRgb8>(23, 10), 95);
  for (int orientation = 0; orientation <= 9; ++orientation) {
    ASSERT_TRUE(WriteFile(path_, WithOrientation(jpeg, orientation)).ok());
    EXPECT_EQ(ReadAgain(), ByOpenCv(path_)) << "orientation " << orientation;
  }
}

TEST_F(PictureTest, ReadingFailsWithTheReason) {
  const std::string jpeg = *EncodeJpeg(Noise<ImageRgb8>(64, 64), 95);
  const std::pair<std::string, std::string> cases[] = {
      {jpeg.substr(0, jpeg.size() / 2), "broken JPEG: Corrupt JPEG data: premature end"},
      {"\xff\xd8 nothing", "broken JPEG: "},
      {"RIFF....WEBP", "neither a PNG nor a JPEG"},
      {"", "neither a PNG nor a JPEG"}};
  for (const auto& [bytes, reason] : cases) {
    ASSERT_TRUE(WriteFile(path_, bytes).ok());
    EXPECT_THAT(std::string(ReadPictureRgb8(path_).status().message()), HasSubstr(reason));
  }
}

TEST(Exr, FloatRoundTripsBitByBit) {
  for (const auto& size : kSizes) {
    ImageF image = Noise<ImageF>(size.width, size.height);
    image(0, 0) = std::numeric_limits<float>::denorm_min();
    const ImageF again = *DecodeExrY(*EncodeExrY(image));
    ASSERT_EQ(again.pixels(), image.pixels());
    for (size_t i = 0; i < image.pixels(); ++i) {
      EXPECT_EQ(std::bit_cast<uint32_t>(again.values()[i]),
                std::bit_cast<uint32_t>(image.values()[i]));
    }
  }
}

TEST(Exr, OpenCvReadsDepthAsOneFloatChannel) {
  const ImageF image = Noise<ImageF>(37, 21);
  const std::string path = ::testing::TempDir() + "io_test_depth.exr";
  ASSERT_TRUE(WriteExrY(path, image).ok());
  ::setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  const cv::Mat read = cv::imread(path, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_32FC1);
  ASSERT_EQ(read.cols, 37);
  ASSERT_EQ(read.rows, 21);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) EXPECT_EQ(read.at<float>(y, x), image(x, y));
  }
  std::filesystem::remove(path);
}

TEST(Exr, NormalsKeepHalfPrecisionAndChannelOrder) {
  ImageF3 image = Noise<ImageF3>(19, 9);
  for (float& value : image.values()) value = std::tanh(value);
  const ImageF3 again = *DecodeExrRgb(*EncodeExrHalfRgb(image));
  ASSERT_EQ(again.width(), 19);
  for (size_t i = 0; i < image.values().size(); ++i) {
    EXPECT_NEAR(again.values()[i], image.values()[i], 0.0005f);
  }
  // Values that are halves already come back exactly.
  EXPECT_EQ(*DecodeExrRgb(*EncodeExrHalfRgb(again)), again);
}

TEST(Pfm, RoundTripsWithTheBottomRowFirst) {
  const ImageF image = Noise<ImageF>(7, 5);
  const std::string bytes = *EncodePfm(image);
  EXPECT_EQ(bytes.substr(0, 10), "Pf\n7 5\n-1\n");
  float first;
  std::memcpy(&first, bytes.data() + 10, sizeof(first));
  EXPECT_EQ(first, image(0, 4));
  EXPECT_EQ(*DecodePfm(bytes), image);
}

TEST(ImageIo, FilesRoundTrip) {
  const std::string folder = ::testing::TempDir() + "io_test_files/";
  std::filesystem::create_directories(folder);
  const auto rgb = Noise<ImageRgb8>(9, 4);
  const auto u8 = Noise<ImageU8>(9, 4);
  const auto u16 = Noise<ImageU16>(9, 4);
  const auto depth = Noise<ImageF>(9, 4);
  ImageF3 normals(9, 4, 0.5f);
  ASSERT_TRUE(WritePng(folder + "rgb.png", rgb).ok());
  ASSERT_TRUE(WritePng(folder + "u8.png", u8).ok());
  ASSERT_TRUE(WritePng(folder + "u16.png", u16).ok());
  ASSERT_TRUE(WriteExrY(folder + "y.exr", depth).ok());
  ASSERT_TRUE(WriteExrHalfRgb(folder + "n.exr", normals).ok());
  ASSERT_TRUE(WritePfm(folder + "d.pfm", depth).ok());
  EXPECT_EQ(*ReadPngRgb8(folder + "rgb.png"), rgb);
  EXPECT_EQ(*ReadPngU8(folder + "u8.png"), u8);
  EXPECT_EQ(*ReadPngU16(folder + "u16.png"), u16);
  EXPECT_EQ(*ReadExrY(folder + "y.exr"), depth);
  EXPECT_EQ(*ReadExrRgb(folder + "n.exr"), normals);
  EXPECT_EQ(*ReadPfm(folder + "d.pfm"), depth);
  EXPECT_THAT(std::string(ReadPngU16(folder + "u8.png").status().message()),
              HasSubstr("u8.png: PNG of 8 bits and 1 channels, wanted 16 bits and 1"));
  EXPECT_EQ(ReadExrY(folder + "no.exr").status().code(), absl::StatusCode::kNotFound);
  std::filesystem::remove_all(folder);
}

TEST(ImageIo, EncodingIsTheSameEachTime) {
  const auto rgb = Noise<ImageRgb8>(64, 33);
  EXPECT_EQ(*EncodePng(rgb), *EncodePng(rgb));
  const auto depth = Noise<ImageF>(64, 33);
  EXPECT_EQ(*EncodeExrY(depth), *EncodeExrY(depth));
}

TEST(ImageIo, EmptyImagesAreErrors) {
  EXPECT_FALSE(EncodePng(ImageRgb8()).ok());
  EXPECT_FALSE(EncodePng(ImageU16()).ok());
  EXPECT_FALSE(EncodeExrY(ImageF()).ok());
  EXPECT_FALSE(EncodeExrHalfRgb(ImageF3()).ok());
  EXPECT_FALSE(EncodePfm(ImageF()).ok());
}

TEST(ImageIo, BrokenBytesAreErrorsAndNotCrashes) {
  const std::string good[] = {*EncodePng(Noise<ImageRgb8>(16, 16)),
                              *EncodeExrY(Noise<ImageF>(16, 16)),
                              *EncodePfm(Noise<ImageF>(16, 16))};
  for (const std::string& bytes : good) {
    for (const size_t size :
         {size_t{0}, size_t{3}, size_t{20}, bytes.size() / 2, bytes.size() - 9}) {
      const std::string cut = bytes.substr(0, size);
      EXPECT_FALSE(DecodeExrY(cut).ok());
      EXPECT_FALSE(DecodePfm(cut).ok());
      (void)DecodePngRgb8(cut).ok();  // libpng gives what it has of a cut file: only no crash.
    }
    EXPECT_FALSE(DecodeExrRgb(bytes).ok());
    EXPECT_FALSE(DecodePngU16(bytes).ok());
  }
  EXPECT_EQ(std::string(DecodePngU8("GIF89a").status().message()), "not a PNG");
  EXPECT_FALSE(DecodePfm("Pf\n-1 5\n-1\n").ok());
  EXPECT_FALSE(DecodePfm("Pf\n99999999 99999999\n-1\n").ok());
}

TEST(ImageIo, PicturesBeyondTheMemoryLimitAreRefusedBeforeTheyAreDecoded) {
  const std::string png = *EncodePng(ImageRgb8(4096, 4096));  // 48 MB decoded.
  const std::string exr = *EncodeExrY(ImageF(4096, 4096));    // 64 MB.
  const std::string pfm = *EncodePfm(ImageF(4096, 4096));
  SetMemoryLimit(ResidentMemory() + (32 << 20));
  EXPECT_EQ(DecodePngRgb8(png).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DecodePictureRgb8(png).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DecodeExrY(exr).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DecodePfm(pfm).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(DecodePngRgb8(png).status().message()),
              testing::HasSubstr("PNG of 4096 x 4096 pixels: needs about 48 MB"));
  SetMemoryLimit(0);
  EXPECT_TRUE(DecodePngRgb8(png).ok());
}

}  // namespace
}  // namespace parallax
