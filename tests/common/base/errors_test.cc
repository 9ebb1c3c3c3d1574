#include "common/base/errors.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <string>

#include "common/base/status.h"

namespace parallax {
namespace {

std::string TextOf(const absl::Status& status) { return std::string(ToStd(status.message())); }

TEST(Errors, EachFunctionMakesTheCodeOfItsName) {
  const struct {
    absl::Status made, wanted;
  } rows[] = {
      {Aborted("x {}", 1), absl::AbortedError("x 1")},
      {AlreadyExists("x {}", 1), absl::AlreadyExistsError("x 1")},
      {Cancelled("x {}", 1), absl::CancelledError("x 1")},
      {DataLoss("x {}", 1), absl::DataLossError("x 1")},
      {DeadlineExceeded("x {}", 1), absl::DeadlineExceededError("x 1")},
      {FailedPrecondition("x {}", 1), absl::FailedPreconditionError("x 1")},
      {Internal("x {}", 1), absl::InternalError("x 1")},
      {InvalidArgument("x {}", 1), absl::InvalidArgumentError("x 1")},
      {NotFound("x {}", 1), absl::NotFoundError("x 1")},
      {OutOfRange("x {}", 1), absl::OutOfRangeError("x 1")},
      {PermissionDenied("x {}", 1), absl::PermissionDeniedError("x 1")},
      {ResourceExhausted("x {}", 1), absl::ResourceExhaustedError("x 1")},
      {Unauthenticated("x {}", 1), absl::UnauthenticatedError("x 1")},
      {Unavailable("x {}", 1), absl::UnavailableError("x 1")},
      {Unimplemented("x {}", 1), absl::UnimplementedError("x 1")},
      {Unknown("x {}", 1), absl::UnknownError("x 1")},
  };
  for (const auto& row : rows) EXPECT_EQ(row.made, row.wanted);
}

TEST(Errors, ATextOfAnotherErrorIsAnArgument) {
  const absl::Status cause = absl::NotFoundError("no {} here");
  EXPECT_EQ(TextOf(Internal("rig {}: {}", 3, cause.message())), "rig 3: no {} here");
  EXPECT_EQ(TextOf(Internal("{}", cause.message())), "no {} here");
  EXPECT_EQ(TextOf(Internal("put {{list}} there")), "put {list} there");
}

// Messages and stored bytes were once made by std::to_string and printf: {fmt} writes the same.
TEST(Errors, NumbersAreWrittenAsPrintfWritesThem) {
  const double numbers[] = {0,    -0.0, 0.1,      1.0 / 3,  1e-7,  123456.7, 1e20,
                            -2.5, 0.5,  999.9995, 0.000045, 1e300, 5e-324};
  for (const double number : numbers) {
    char text[400];
    EXPECT_EQ(TextOf(Internal("{:f}", number)), std::to_string(number));
    std::snprintf(text, sizeof text, "%g", number);
    EXPECT_EQ(TextOf(Internal("{:g}", number)), text);
    std::snprintf(text, sizeof text, "%.9g", number);
    EXPECT_EQ(TextOf(Internal("{:.9g}", number)), text);
    std::snprintf(text, sizeof text, "%8.0f", number);
    EXPECT_EQ(TextOf(Internal("{:8.0f}", number)), text);
  }
  EXPECT_EQ(TextOf(Internal("{:f}", std::numeric_limits<double>::quiet_NaN())), "nan");
  EXPECT_EQ(TextOf(Internal("{:.2f}", -std::numeric_limits<double>::infinity())), "-inf");
  EXPECT_EQ(TextOf(Internal("{:06} {:016x} {:0{}}", 42u, uint64_t{255}, 7, 3)),
            "000042 00000000000000ff 007");
  EXPECT_EQ(TextOf(Internal("{:.{}f}", 2.345, 1)), "2.3");
}

TEST(Errors, AVariableCodeIsKept) {
  const absl::Status status = MakeError(absl::StatusCode::kAborted, "why {}");
  EXPECT_EQ(status, absl::AbortedError("why {}"));
}

}  // namespace
}  // namespace parallax
