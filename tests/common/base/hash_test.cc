#include "common/base/hash.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"

namespace parallax {
namespace {

// Source: NIST, "Secure Hash Standard" example values (SHA256.pdf) and the million-a vector of FIPS
// 180-2.
TEST(Sha256, MatchesPublishedVectors) {
  const struct {
    std::string bytes;
    const char* hex;
  } rows[] = {
      {"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
      {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
      {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
       "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
      {std::string(1000000, 'a'),
       "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"},
  };
  for (const auto& row : rows) EXPECT_EQ(Sha256Hex(row.bytes), row.hex);
}

TEST(Sha256, PiecesHashAsTheWhole) {
  const std::string bytes(100000, 'x');
  Sha256 pieces;
  for (size_t i = 0; i < bytes.size(); i += 777)
    pieces.Update(std::string_view(bytes).substr(i, 777));
  EXPECT_EQ(HexOf(pieces.Finish()), Sha256Hex(bytes));
}

TEST(Sha256, FileHashesAsItsBytes) {
  const std::string path = ::testing::TempDir() + "hash_test.bin";
  const std::string bytes(150001, 'y');
  ASSERT_TRUE(WriteFile(path, bytes).ok());
  EXPECT_EQ(*Sha256HexOfFile(path), Sha256Hex(bytes));
  std::filesystem::remove(path);
  EXPECT_EQ(Sha256HexOfFile(path).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace parallax
