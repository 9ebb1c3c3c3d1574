// Files as other tools write them: read right, or refused with the reason.
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "common/base/system/file.h"
#include "common/image/hdr.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "common/image/picture_pair.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using std::string_literals::operator""s;
using ::testing::HasSubstr;

std::string Message(const absl::Status& status) { return std::string(ToStd(status.message())); }

class OtherTools : public FolderTest {
 protected:
  std::string Write(const std::string& name, const std::string& bytes) const {
    EXPECT_TRUE(WriteFile(dir_ + "/" + name, bytes).ok());
    return dir_ + "/" + name;
  }
  std::string WriteMat(const std::string& name, const cv::Mat& mat) const {
    EXPECT_TRUE(cv::imwrite(dir_ + "/" + name, mat));
    return dir_ + "/" + name;
  }
};

// ---- PFM

TEST_F(OtherTools, PfmIsReadByItsSizeWhateverEndsItsHeader) {
  ImageF image(3, 2);
  // The first byte of the data is a blank and the end of a line in turn.
  const char* first[] = {"\x20\x00\x80\x3f", "\x0a\x0d\x80\x3f", "\x0d\x0a\x80\x3f"};
  for (const char* bytes : first) {
    std::memcpy(&image.values()[3], bytes, 4);
    const std::string data = EncodePfm(image)->substr(std::string("Pf\n3 2\n-1\n").size());
    for (const std::string header :
         {"Pf\n3 2\n-1\n", "Pf\r\n3 2\r\n-1.0\r\n", "Pf\n3 2\n-1.0 \n", "Pf\r3 2\r-1\r",
          "Pf 3 2 -1 ", "Pf\n3 2\n-256.5\t\r\n", "Pf\n3\n2\n-1e-3\n"}) {
      const auto read = DecodePfm(header + data);
      ASSERT_TRUE(read.ok()) << header << read.status();
      EXPECT_EQ(*read, image) << header;
    }
    for (const std::string other : {"Pf\n3 2\n-1\n\n", "Pf\n3 2\n-1\nx", "Pf\n3 2\n-1\n \n"}) {
      EXPECT_THAT(Message(DecodePfm(other + data).status()), HasSubstr("bytes after its scale"));
    }
    EXPECT_THAT(Message(DecodePfm("Pf\n3 2\n-1\n" + data + "\0"s).status()),
                HasSubstr("PFM with 26 bytes after its scale, wanted the end of the line and 24"));
    EXPECT_THAT(Message(DecodePfm("Pf\n3 2\n-1" + data).status()), HasSubstr("PFM"));
  }
}

TEST_F(OtherTools, PfmOfAPositiveScaleIsBigEndian) {
  const auto read = DecodePfm("Pf\n2 1\n+1.0\n"s + "\x3f\x80\x00\x00\xc0\x20\x00\x00"s);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->values(), (std::vector<float>{1, -2.5f}));
  EXPECT_THAT(Message(DecodePfm("Pf\n1 1\n0\n\0\0\0\0"s).status()), HasSubstr("scale \"0\""));
}

// ---- Radiance

// Four channels of a 9 x 2 picture with runs; the exponent makes a mantissa of 128 one.
std::vector<std::array<uint8_t, 4>> Scanline(int y) {
  std::vector<std::array<uint8_t, 4>> line(9, {128, 64, static_cast<uint8_t>(32 + y), 129});
  line[8] = {16, 8, 4, 130};
  return line;
}

std::string Flat(int y) {
  std::string bytes;
  for (const auto& p : Scanline(y)) bytes.append(p.begin(), p.end());
  return bytes;
}
std::string OldRuns(int y) {
  const auto line = Scanline(y);
  return std::string(line[0].begin(), line[0].end()) + "\x01\x01\x01\x07"s +
         std::string(line[8].begin(), line[8].end());
}
std::string NewRuns(int y) {
  std::string bytes = "\x02\x02\x00\x09"s;
  for (size_t c = 0; c < 4; ++c) {
    bytes += "\x88"s + static_cast<char>(Scanline(y)[0][c]) + "\x01"s +
             static_cast<char>(Scanline(y)[8][c]);
  }
  return bytes;
}

void ExpectPicture(const absl::StatusOr<ImageF3>& read) {
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->width(), 9);
  ASSERT_EQ(read->height(), 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 9; ++x) {
      const auto p = Scanline(y)[static_cast<size_t>(x)];
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ((*read)(x, y, c),
                  std::ldexp(static_cast<float>(p[static_cast<size_t>(c)]), p[3] - 136))
            << x << " " << y << " " << c;
      }
    }
  }
}

TEST_F(OtherTools, RadianceIsReadInAllEncodings) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 9\n";
  ExpectPicture(DecodeHdr(header + Flat(0) + Flat(1)));
  ExpectPicture(DecodeHdr(header + OldRuns(0) + OldRuns(1)));
  ExpectPicture(DecodeHdr(header + NewRuns(0) + NewRuns(1)));
  ExpectPicture(DecodeHdr(header + NewRuns(0) + OldRuns(1)));
  // A run of 4 + 256 * 1 pixels.
  std::string long_run =
      "#?RGBE\n\n-Y 1 +X 261\n" + Flat(0).substr(0, 4) + "\x01\x01\x01\x04\x01\x01\x01\x01"s;
  const auto read = DecodeHdr(long_run);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ((*read)(260, 0, 0), 1.0f);
}

TEST_F(OtherTools, RadianceHeadersOfOtherSystemsAreRead) {
  const std::string data = Flat(0) + Flat(1);
  ExpectPicture(
      DecodeHdr("#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\nEXPOSURE=2\r\n\r\n-Y 2 +X 9\r\n" + data));
  ExpectPicture(DecodeHdr("#?RGBE\n# no format\n\n-Y 2 +X 9\n" + data));
  EXPECT_THAT(
      Message(DecodeHdr("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 9\n" + data).status()),
      HasSubstr("wanted FORMAT=32-bit_rle_rgbe"));
}

TEST_F(OtherTools, RadianceIsTurnedToItsOrientation) {
  const auto pixel = [](int x, int y) {
    return std::string{static_cast<char>(16 * y + x + 2), 1, 1, static_cast<char>(136)};
  };
  constexpr int kWidth = 3, kHeight = 2;
  for (const std::string vertical : {"-Y", "+Y"}) {
    for (const std::string horizontal : {"+X", "-X"}) {
      for (const bool rows : {true, false}) {
        std::string data;
        for (int i = 0; i < kWidth * kHeight; ++i) {
          int x = rows ? i % kWidth : i / kHeight, y = rows ? i / kWidth : i % kHeight;
          if (horizontal == "-X") x = kWidth - 1 - x;
          if (vertical == "+Y") y = kHeight - 1 - y;
          data += pixel(x, y);
        }
        const std::string size =
            rows ? vertical + " 2 " + horizontal + " 3\n" : horizontal + " 3 " + vertical + " 2\n";
        const auto read = DecodeHdr("#?RADIANCE\n\n" + size + data);
        ASSERT_TRUE(read.ok()) << size << read.status();
        ASSERT_EQ(read->width(), kWidth);
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            EXPECT_EQ((*read)(x, y, 0), static_cast<float>(16 * y + x + 2)) << size;
          }
        }
      }
    }
  }
}

TEST_F(OtherTools, RadianceThatIsCutOrTooLongIsRefused) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 9\n";
  for (const std::string& data :
       {Flat(0) + Flat(1), OldRuns(0) + OldRuns(1), NewRuns(0) + NewRuns(1)}) {
    for (size_t cut = 1; cut <= data.size(); ++cut) {
      EXPECT_FALSE(DecodeHdr(header + data.substr(0, data.size() - cut)).ok()) << cut;
    }
    EXPECT_THAT(Message(DecodeHdr(header + data + "\n").status()),
                HasSubstr("1 bytes follow its last pixel"));
  }
  EXPECT_THAT(Message(DecodeHdr(header + "\x02\x02\x00\x08"s + NewRuns(0).substr(4)).status()),
              HasSubstr("scanline 1 of 2"));
  EXPECT_THAT(Message(DecodeHdr(header + "\x01\x01\x01\x07"s + Flat(0) + Flat(1)).status()),
              HasSubstr("scanline 1 of 2"));
  for (const char* size :
       {"-Y 2", "-Y 0 +X 9", "-Y 99999 +X 9", "-Z 2 +X 9", "-Y 2 +Y 9", "", "-Y 60000 +X 60000"}) {
    EXPECT_FALSE(DecodeHdr("#?RADIANCE\n\n"s + size + "\n" + Flat(0) + Flat(1)).ok()) << size;
  }
  EXPECT_FALSE(DecodeHdr("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n").ok());
}

// ---- OpenEXR

// An EXR with the named channels, each filled with its number from 1.
std::string ExrOf(const std::string& path, const std::vector<std::string>& channels) {
  Imf::Header header(4, 2);
  Imf::FrameBuffer buffer;
  std::vector<std::vector<float>> values;
  for (size_t i = 0; i < channels.size(); ++i) {
    values.emplace_back(8, static_cast<float>(i + 1));
    header.channels().insert(channels[i], Imf::Channel(Imf::FLOAT));
    buffer.insert(channels[i],
                  Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values[i].data()), 4, 16));
  }
  {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(2);
  }
  return *ReadFile(path);
}

TEST_F(OtherTools, ExrColoursAreFoundByTheirLayer) {
  const std::string path = dir_ + "/a.exr";
  const auto first = [&](const std::vector<std::string>& channels) {
    const auto read = DecodeExrPicture(ExrOf(path, channels));
    EXPECT_TRUE(read.ok()) << read.status();
    return read.ok() ? std::vector<float>(read->data(), read->data() + 3) : std::vector<float>();
  };
  using Rgb = std::vector<float>;
  EXPECT_EQ(first({"R", "G", "B", "A"}), (Rgb{1, 2, 3}));
  EXPECT_EQ(first({"r", "g", "b"}), (Rgb{1, 2, 3}));
  EXPECT_EQ(first({"ViewLayer.Depth.Z", "ViewLayer.Combined.R", "ViewLayer.Combined.G",
                   "ViewLayer.Combined.B", "ViewLayer.Combined.A"}),
            (Rgb{2, 3, 4}));
  EXPECT_EQ(first({"L.Combined.R", "L.Combined.G", "L.Combined.B", "L.DiffCol.R", "L.DiffCol.G",
                   "L.DiffCol.B"}),
            (Rgb{1, 2, 3}));
  EXPECT_EQ(first({"Y"}), (Rgb{1, 1, 1}));
  EXPECT_EQ(first({"Y", "A"}), (Rgb{1, 1, 1}));
  const auto refused = [&](const std::vector<std::string>& channels) {
    return Message(DecodeExrPicture(ExrOf(path, channels)).status());
  };
  EXPECT_THAT(refused({"R", "G"}), HasSubstr("without channel R, G or B; it has G R"));
  EXPECT_THAT(refused({"BY", "RY", "Y"}), HasSubstr("it has BY RY Y"));
  EXPECT_THAT(refused({"a.R", "a.G", "a.B", "b.R", "b.G", "b.B"}), HasSubstr("\"a\", \"b\""));
}

TEST_F(OtherTools, OurOwnMapsOfThreeChannelsAreReadByTheirNamesOnly) {
  const std::string path = dir_ + "/a.exr";
  EXPECT_TRUE(DecodeExrRgb(ExrOf(path, {"R", "G", "B"})).ok());
  EXPECT_THAT(Message(DecodeExrRgb(ExrOf(path, {"Y"})).status()),
              HasSubstr("EXR without channel R, G or B; it has Y"));
  EXPECT_FALSE(DecodeExrRgb(ExrOf(path, {"r", "g", "b"})).ok());
}

TEST_F(OtherTools, ExrMapsMayBeCalledYOrZOrStandAlone) {
  const std::string path = dir_ + "/a.exr";
  EXPECT_EQ((*DecodeExrY(ExrOf(path, {"R"})))(0, 0), 1);
  EXPECT_EQ((*DecodeExrY(ExrOf(path, {"disparity"})))(0, 0), 1);
  EXPECT_EQ((*DecodeExrY(ExrOf(path, {"A", "Z"})))(0, 0), 2);
  EXPECT_EQ((*DecodeExrY(ExrOf(path, {"Z", "Y"})))(0, 0), 2);
  EXPECT_THAT(Message(DecodeExrY(ExrOf(path, {"R", "G", "B"})).status()),
              HasSubstr("it has B G R"));
}

TEST_F(OtherTools, ExrMapsAreNotTakenFromVectors) {
  const std::string path = dir_ + "/a.exr";
  EXPECT_EQ((*DecodeExrY(ExrOf(path, {"N.X", "N.Y", "N.Z", "Depth.Z"})))(0, 0), 4);
  EXPECT_THAT(Message(DecodeExrY(ExrOf(path, {"N.X", "N.Y", "N.Z"})).status()),
              HasSubstr("it has N.X N.Y N.Z"));
  EXPECT_THAT(Message(DecodeExrY(ExrOf(path, {"X", "Y", "Z"})).status()),
              HasSubstr("it has X Y Z"));
  EXPECT_THAT(Message(DecodeExrY(ExrOf(path, {"Depth.Z", "Mist.Z"})).status()),
              HasSubstr("\"Depth\", \"Mist\""));
}

TEST_F(OtherTools, ExrOfSeveralPartsMayBeginWithItsDepth) {
  const std::string path = dir_ + "/parts.exr";
  std::vector<Imf::Header> headers(2, Imf::Header(4, 2));
  headers[0].setName("depth");
  headers[0].channels().insert("Z", Imf::Channel(Imf::FLOAT));
  headers[1].setName("rgba");
  for (const char* name : {"R", "G", "B"}) {
    headers[1].channels().insert(name, Imf::Channel(Imf::FLOAT));
  }
  for (Imf::Header& header : headers) header.setType(Imf::SCANLINEIMAGE);
  std::vector<float> depth(8, 9), color(24);
  for (size_t i = 0; i < color.size(); ++i) color[i] = static_cast<float>(i % 3 + 1);
  {
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
    Imf::FrameBuffer first, second;
    first.insert("Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth.data()), 4, 16));
    const char* names[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c) {
      second.insert(names[c],
                    Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(color.data() + c), 12, 48));
    }
    Imf::OutputPart depth_part(file, 0);
    depth_part.setFrameBuffer(first);
    depth_part.writePixels(2);
    Imf::OutputPart color_part(file, 1);
    color_part.setFrameBuffer(second);
    color_part.writePixels(2);
  }
  const std::string bytes = *ReadFile(path);
  const auto picture = DecodeExrPicture(bytes);
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ((*picture)(3, 1, 2), 3);
  EXPECT_EQ((*DecodeExrY(bytes))(0, 0), 9);
  const auto map = DecodeExrRgb(bytes);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ((*map)(3, 1, 2), 3);
}

// ---- Pictures

TEST_F(OtherTools, PairsOfFewBitsAreScaledAlike) {
  for (const int bits : {10, 12, 14}) {
    const int most = (1 << bits) - 1;
    cv::Mat left(4, 5, CV_16UC1, cv::Scalar(most / 2)), right(4, 5, CV_16UC1, cv::Scalar(most / 4));
    left.at<uint16_t>(0, 0) = static_cast<uint16_t>(most);
    right.at<uint16_t>(0, 0) = static_cast<uint16_t>(most / 2);
    const auto pair = ReadPicturePair(WriteMat("l.png", left), WriteMat("r.png", right));
    ASSERT_TRUE(pair.ok()) << pair.status();
    EXPECT_TRUE(pair->rescaled);
    EXPECT_EQ(pair->left(0, 0), 255);
    EXPECT_NEAR(pair->left(1, 0), 127, 1) << bits;
    EXPECT_NEAR(pair->right(1, 0), 64, 1) << bits;
    ASSERT_EQ(pair->notes.size(), 2u);
    EXPECT_THAT(pair->notes[0], HasSubstr("l.png: 16 bits, of which it uses the lower ones: " +
                                          std::to_string(most) + " is taken as white"));
  }
}

TEST_F(OtherTools, PairsOfSixteenBitsKeepTheUpperEight) {
  cv::Mat left(4, 5, CV_16UC3, cv::Scalar(300, 20000, 65535)),
      right(4, 5, CV_16UC1, cv::Scalar(300));
  const auto pair = ReadPicturePair(WriteMat("l.png", left), WriteMat("r.png", right));
  ASSERT_TRUE(pair.ok()) << pair.status();
  EXPECT_FALSE(pair->rescaled);
  EXPECT_TRUE(pair->notes.empty());
  EXPECT_EQ(pair->left(0, 0, 0), 255);
  EXPECT_EQ(pair->left(0, 0, 1), 20000 >> 8);
  EXPECT_EQ(pair->right(0, 0), 1);
  EXPECT_THAT(Message(ReadPicturePair(WriteMat("l.png", left),
                                      WriteMat("r.png", cv::Mat(4, 6, CV_8UC1, cv::Scalar(1))))
                          .status()),
              HasSubstr("r.png: 6x4, but "));
}

// The chunk sBIT of a grey PNG, right behind its header.
std::string WithSignificantBits(const std::string& png, const std::string& chunk) {
  return png.substr(0, 33) + chunk + png.substr(33);
}

TEST_F(OtherTools, SignificantBitsSayWhatIsWhite) {
  const std::string png = *EncodePng(ImageU16(3, 2, 1023));
  // Twelve bits. The checksum is that of "sBIT\x0c".
  const std::string chunk = "\0\0\0\x01sBIT\x0c\xe1\x67\x9f\x80"s;
  const auto pair = ReadPicturePair(Write("l.png", WithSignificantBits(png, chunk)),
                                    Write("r.png", WithSignificantBits(png, chunk)));
  ASSERT_TRUE(pair.ok()) << pair.status();
  EXPECT_EQ(pair->left(0, 0), 64);  // 1023 of 4095.
}

TEST_F(OtherTools, JpegsWithStrayBytesAreReadWithANote) {
  const std::string jpeg = *EncodeJpeg(ImageRgb8(16, 16, 100), 90);
  const auto good = DecodePictureRgb8(jpeg);
  const size_t table = jpeg.find("\xff\xc4"s);
  ASSERT_NE(table, std::string::npos);
  for (const std::string& odd : {jpeg.substr(0, table) + "\x11\x22"s + jpeg.substr(table),
                                 jpeg.substr(0, jpeg.size() - 2)}) {
    const std::string path = Write("odd.jpg", odd);
    const auto read = ReadPictureRgb8(path);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(*read, *good);
    const auto notes = CheckPicture(path);
    ASSERT_TRUE(notes.ok()) << notes.status();
    ASSERT_EQ(notes->size(), 1u);
    EXPECT_THAT((*notes)[0], HasSubstr("odd.jpg: read, but damaged: "));
  }
}

TEST_F(OtherTools, JpegsOfFourInksAreNamed) {
  // An encoder for four components is more than this needs: the frame header says it.
  std::string jpeg = *EncodeJpeg(ImageRgb8(16, 16, 100), 90);
  const size_t frame = jpeg.find("\xff\xc0"s);
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(
      frame, 19,
      "\xff\xc0\x00\x14\x08\x00\x10\x00\x10\x04\x01\x11\x00\x02\x11\x01\x03\x11\x01\x04\x11\x00"s);
  EXPECT_THAT(Message(DecodePictureRgb8(jpeg).status()), HasSubstr("four inks (CMYK)"));
}

// A progressive file has all coefficients in memory before its first pixel is decoded.
TEST_F(OtherTools, ProgressiveJpegsAreRefusedByTheSizeInTheirHeader) {
  std::string jpeg = *EncodeJpeg(ImageRgb8(16, 16, 100), 90);
  const size_t frame = jpeg.find("\xff\xc0"s);
  ASSERT_NE(frame, std::string::npos);
  jpeg[frame + 1] = '\xc2';
  jpeg.replace(frame + 5, 4, "\xff\xdc\xff\xdc"s);  // 65500, twice.
  EXPECT_THAT(Message(DecodePictureRgb8(jpeg).status()),
              HasSubstr("JPEG of 65500 x 65500 pixels, allowed are"));
}

TEST_F(OtherTools, PgmAndPpmAreReadToTheirMaximum) {
  const auto color = DecodePictureRgb8("P6 2 1 255\n\x01\x02\x03\xff\x00\x80"s);
  ASSERT_TRUE(color.ok()) << color.status();
  EXPECT_EQ(color->values(), (std::vector<uint8_t>{1, 2, 3, 255, 0, 128}));
  const auto grey = DecodePictureRgb8("P5\n# a camera\n2 1\n4095\n\x0f\xff\x07\xff"s);
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_EQ(grey->values(), (std::vector<uint8_t>{255, 255, 255, 127, 127, 127}));
  for (const std::string& bad :
       {"P5 2 1 255\n\x01"s, "P5 2 1 255\n\x01\x02\x03"s, "P5 2 1 0\n\x01\x02"s,
        "P5 2 1 70000\n\x01\x02\x03\x04"s, "P6 x"s}) {
    EXPECT_THAT(Message(DecodePictureRgb8(bad).status()), HasSubstr("broken PGM or PPM")) << bad;
  }
  EXPECT_THAT(Message(DecodePictureRgb8("P5 99999 1 255\n\x01").status()),
              HasSubstr("PGM or PPM of 99999 x 1 pixels, allowed are"));
}

}  // namespace
}  // namespace parallax
