#include "common/base/status.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <memory>

namespace parallax {
namespace {

TEST(Status, ContextKeepsTheCodeAndLeavesOkAlone) {
  EXPECT_TRUE(WithContext(absl::OkStatus(), "x").ok());
  const absl::Status status = WithContext(absl::NotFoundError("no chair"), "object Chair_3");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(std::string(status.message()), "object Chair_3: no chair");
}

TEST(Status, ErrnoBecomesTheFittingCode) {
  const struct {
    int number;
    absl::StatusCode code;
  } rows[] = {
      {ENOSPC, absl::StatusCode::kResourceExhausted},
      {EDQUOT, absl::StatusCode::kResourceExhausted},
      {ENOMEM, absl::StatusCode::kResourceExhausted},
      {ENOENT, absl::StatusCode::kNotFound},
      {EEXIST, absl::StatusCode::kAlreadyExists},
      {EROFS, absl::StatusCode::kPermissionDenied},
      {EACCES, absl::StatusCode::kPermissionDenied},
      {EIO, absl::StatusCode::kUnavailable},
      {EINVAL, absl::StatusCode::kInternal},
  };
  for (const auto& row : rows)
    EXPECT_EQ(ErrnoError(row.number, "x").code(), row.code) << row.number;
  EXPECT_EQ(std::string(ErrnoError(ENOSPC, "write /a").message()),
            "write /a: No space left on device");
}

absl::StatusOr<std::unique_ptr<int>> Boxed(int value) {
  if (value < 0) return absl::InvalidArgumentError("negative");
  return std::make_unique<int>(value);
}
absl::StatusOr<int> Twice(int value) {
  ASSIGN_OR_RETURN(const std::unique_ptr<int> box, Boxed(value));
  RETURN_IF_ERROR(*box == 7 ? absl::AbortedError("seven") : absl::OkStatus());
  return 2 * *box;
}

TEST(Status, MacrosReturnEarlyOrHandOutTheValue) {
  EXPECT_EQ(*Twice(4), 8);
  EXPECT_EQ(Twice(-1).status(), absl::InvalidArgumentError("negative"));
  EXPECT_EQ(Twice(7).status(), absl::AbortedError("seven"));
}

TEST(Status, StringViewsConvertBothWays) {
  EXPECT_EQ(ToStd(ToAbsl("a b")), "a b");
  EXPECT_EQ(MakeError(absl::StatusCode::kAborted, "why"), absl::AbortedError("why"));
}

}  // namespace
}  // namespace parallax
