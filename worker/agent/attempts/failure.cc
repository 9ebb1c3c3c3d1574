#include "worker/agent/attempts/failure.h"

#include <algorithm>

#include "absl/strings/cord.h"
#include "common/base/names.h"

namespace parallax {
namespace {

constexpr size_t kMostErrorBytes = 1000;
constexpr size_t kMostFingerprintBytes = 200;
constexpr size_t kTailLines = 200;
constexpr size_t kMaxTailBytes = 16 << 10;
constexpr char kLogTail[] = "parallax/log-tail";  // Key of a status's payload.

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Messages must be UTF-8, and texts may be those of other programs.
std::string OneLine(std::string_view text, size_t most) {
  std::string line = CutText(text, most);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return CutText(Printable(line), most);
}

// Replaces numbers by '#', keeping signs, points and exponents: seeds, sizes and paths of attempts
// differ between workers, their cause does not.
std::string WithoutNumbers(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (!IsDigit(text[i])) {
      out += text[i];
    } else if (i == 0 || !IsDigit(text[i - 1])) {
      out += '#';
    }
  }
  return out;
}

}  // namespace

std::string EndOfLog(std::string_view log, size_t most_bytes) {
  while (!log.empty() && log.back() == '\n') log.remove_suffix(1);
  size_t from = log.size();
  for (size_t lines = 0; from > 0 && log.size() - from < most_bytes; --from) {
    if (log[from - 1] == '\n' && ++lines == kTailLines) break;
  }
  std::string tail(log.substr(from));
  // Messages must be UTF-8, and programs may print anything.
  for (char& c : tail) {
    if (static_cast<unsigned char>(c) >= 0x80 || (c < ' ' && c != '\n' && c != '\t')) c = '?';
  }
  return tail;
}

absl::Status WithLogTail(absl::Status status, std::string_view log) {
  const std::string tail = EndOfLog(log, kMaxTailBytes);
  if (!tail.empty()) status.SetPayload(kLogTail, absl::Cord(ToAbsl(tail)));
  return status;
}

std::string LogTailOf(const absl::Status& status) {
  const absl::optional<absl::Cord> tail = status.GetPayload(kLogTail);
  return tail.has_value() ? std::string(*tail) : "";
}

bool IsRetryable(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kFailedPrecondition:
      return false;  // The job itself is wrong: it fails everywhere alike.
    default:
      return true;  // This machine (disk, memory, permissions) or a fault that may not come again.
  }
}

Failure DescribeFailure(const absl::Status& status, std::string_view place) {
  const std::string code = absl::StatusCodeToString(status.code());
  Failure failure;
  const std::string message(ToStd(status.message()));
  failure.error = OneLine(code + ": " + message, kMostErrorBytes);
  failure.fingerprint = CutText(
      WithoutNumbers(code + "@" + std::string(place) + ": " + OneLine(message, kMostErrorBytes)),
      kMostFingerprintBytes);
  failure.retryable = IsRetryable(status.code());
  return failure;
}

}  // namespace parallax
