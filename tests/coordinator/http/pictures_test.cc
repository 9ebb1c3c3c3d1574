#include "coordinator/http/pictures.h"

#include <atomic>
#include <cstring>
#include <thread>
#include <vector>

#include "common/image/jpeg.h"
#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

class PicturesTest : public HttpTest {
 protected:
  PicturesTest() { PutPictures("ab/x"); }
  ImageRgb8 Decoded(const std::string& jpeg) {
    const std::string path = dir_ + "/a.jpg";
    EXPECT_TRUE(WriteFile(path, jpeg).ok());
    return *ReadPictureRgb8(path);
  }
};

TEST_F(PicturesTest, AreReducedToTheWidthAskedForAndNeverEnlarged) {
  Pictures pictures(store_.get());
  const ImageRgb8 small = Decoded(*pictures.Jpeg("ab/x/left.png", 16));
  EXPECT_EQ(small.width(), 16);
  EXPECT_EQ(small.height(), 9);
  // The one white column of four that became one: a quarter of its light.
  EXPECT_NEAR(small(2, 4, 0), 40, 12);
  EXPECT_GT(small(8, 4, 0), 70);
  EXPECT_LT(small(8, 4, 0), 130);
  EXPECT_EQ(Decoded(*pictures.Jpeg("ab/x/left.png", 4000)).width(), kWidth);
}

TEST_F(PicturesTest, MapsAreExact) {
  Pictures pictures(store_.get());
  const std::string bytes = *pictures.Map("ab/x/disparity_left.exr");
  ASSERT_EQ(bytes.size(), 8u + 4u * kWidth * kHeight);
  uint32_t size[2];
  std::memcpy(size, bytes.data(), sizeof size);
  EXPECT_EQ(size[0], static_cast<uint32_t>(kWidth));
  EXPECT_EQ(size[1], static_cast<uint32_t>(kHeight));
  float values[2];
  std::memcpy(values, bytes.data() + 8 + 4 * (2 * kWidth + 3), sizeof values);
  EXPECT_EQ(values[0], 0.0f);
  EXPECT_EQ(values[1], 7.25f);
  const std::string masks = *pictures.Map("ab/x/masks_left.png");
  ASSERT_EQ(masks.size(), 8u + 2u * kWidth * kHeight);
  EXPECT_EQ(masks[8], 5);
}

TEST_F(PicturesTest, WhatWasMadeIsKeptUpToTheBound) {
  Pictures pictures(store_.get());
  const std::string made = *pictures.Jpeg("ab/x/left.png", 32);
  ASSERT_TRUE(store_->RemoveTree("ab").ok());
  EXPECT_EQ(*pictures.Jpeg("ab/x/left.png", 32), made);
  EXPECT_EQ(pictures.Jpeg("ab/x/left.png", 16).status().code(), absl::StatusCode::kNotFound);

  PutPictures("cd/y");
  Pictures forgetful(store_.get(), made.size() + made.size() / 2);
  ASSERT_TRUE(forgetful.Jpeg("cd/y/left.png", 32).ok());
  ASSERT_TRUE(forgetful.Jpeg("cd/y/right.png", 32).ok());
  ASSERT_TRUE(store_->RemoveTree("cd").ok());
  EXPECT_TRUE(forgetful.Jpeg("cd/y/right.png", 32).ok());
  EXPECT_FALSE(forgetful.Jpeg("cd/y/left.png", 32).ok());
}

TEST_F(PicturesTest, ACrowdGetsAllOfThem) {
  Pictures pictures(store_.get());
  std::atomic<int> got = 0;
  std::vector<std::thread> crowd;
  for (int i = 0; i < 16; ++i) {
    crowd.emplace_back([&, i] {
      for (int width = 8; width < kWidth; ++width) {
        got += pictures.Jpeg(i % 2 == 0 ? "ab/x/left.png" : "ab/x/right.png", width).ok() ? 1 : 0;
      }
    });
  }
  for (std::thread& one : crowd) one.join();
  EXPECT_EQ(got, 16 * (kWidth - 8));
}

TEST_F(PicturesTest, WithoutAStoreNothingIsShown) {
  Pictures none(nullptr);
  EXPECT_EQ(none.Jpeg("ab/x/left.png", 16).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace parallax
