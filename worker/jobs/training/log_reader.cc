#include "worker/jobs/training/log_reader.h"

#include <algorithm>
#include <utility>

namespace parallax {
namespace {

constexpr size_t kLogPiece = 1 << 16;
constexpr size_t kLongestLine = 1 << 16;  // A program that ends no line must not fill the memory.
constexpr std::streamoff kTailBytes = 16 << 10;
constexpr int kTailLines = 200;

bool EndsLine(char c) { return c == '\n' || c == '\r'; }

}  // namespace

std::vector<std::string> LogReader::NewLines(bool last) {
  std::vector<std::string> lines;
  std::ifstream file(path_, std::ios::binary);
  file.seekg(read_);
  std::string piece(kLogPiece, '\0');
  while (file && (file.read(piece.data(), kLogPiece), file.gcount() > 0)) {
    read_ += file.gcount();
    for (const char c : piece.substr(0, static_cast<size_t>(file.gcount()))) {
      if (!EndsLine(c) && open_line_.size() < kLongestLine) open_line_ += c;
      if (!EndsLine(c) || open_line_.empty()) continue;
      lines.push_back(std::move(open_line_));
      open_line_.clear();
    }
  }
  if (last && !open_line_.empty()) lines.push_back(std::exchange(open_line_, ""));
  return lines;
}

std::string LogReader::Tail() const {
  std::ifstream file(path_, std::ios::binary);
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg();
  if (size <= 0) return "";
  file.seekg(std::max<std::streamoff>(0, size - kTailBytes));
  std::string tail(static_cast<size_t>(std::min(size, kTailBytes)), '\0');
  file.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  size_t from = tail.size();
  for (int lines = 0; from > 0 && !(tail[from - 1] == '\n' && ++lines > kTailLines);) --from;
  return tail.substr(from);
}

std::string LogReader::LastLine() const {
  const std::string tail = Tail();
  size_t end = tail.find_last_not_of(" \t\r\n");
  if (end == std::string::npos) return "";
  const size_t begin = tail.find_last_of("\r\n", end);
  return tail.substr(begin == std::string::npos ? 0 : begin + 1,
                     end + 1 - (begin == std::string::npos ? 0 : begin + 1));
}

}  // namespace parallax
