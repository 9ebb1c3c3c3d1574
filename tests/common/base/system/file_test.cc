#include "common/base/system/file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

namespace parallax {
namespace {

TEST(File, BytesRoundTrip) {
  const std::string path = ::testing::TempDir() + "file_test.bin";
  std::string bytes(200000, '\0');
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31 >> 3);
  ASSERT_TRUE(WriteFile(path, bytes, /*sync=*/true).ok());
  EXPECT_EQ(*ReadFile(path), bytes);
  ASSERT_TRUE(WriteFile(path, "short").ok());
  EXPECT_EQ(*ReadFile(path), "short");
  EXPECT_EQ(ReadFile(path, 4).status().code(), absl::StatusCode::kResourceExhausted);
  std::filesystem::remove(path);
}

TEST(File, ErrorsNameThePathAndTheCause) {
  EXPECT_EQ(std::string(ReadFile("/no/such").status().message()),
            "open /no/such: No such file or directory");
  EXPECT_EQ(ReadFile("/no/such").status().code(), absl::StatusCode::kNotFound);
  const absl::Status full = WriteFile("/dev/full", "x");
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(std::string(full.message()), "write /dev/full: No space left on device");
}

TEST(File, NoneIsOpenedAsAStandardStreamThatIsClosed) {
  const auto open_next = [] {
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::close(fd);
    HoldStandardStreams();
    const bool is_another = ::open("/dev/null", O_WRONLY) > STDERR_FILENO;
    ::_exit(is_another && ::write(STDOUT_FILENO, "x", 1) < 0 ? 0 : 1);
  };
  EXPECT_EXIT(open_next(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace parallax
