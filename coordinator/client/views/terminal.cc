#include "coordinator/client/views/terminal.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <streambuf>

namespace parallax::client {
namespace {

constexpr std::string_view kReset = "\x1b[0m";

std::string_view Code(Tone tone) {
  switch (tone) {
    case Tone::kBold:
      return "\x1b[1m";
    case Tone::kDim:
      return "\x1b[2m";
    case Tone::kGood:
      return "\x1b[32m";
    case Tone::kWarning:
      return "\x1b[33m";
    case Tone::kBad:
      return "\x1b[1;31m";
    case Tone::kAccent:
      return "\x1b[36m";
    case Tone::kPlain:
      break;
  }
  return "";
}

std::string_view EnvironmentVariable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool LocaleIsUtf8() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    std::string value(EnvironmentVariable(name));
    if (value.empty()) continue;
    std::transform(value.begin(), value.end(), value.begin(), ::toupper);
    return value.find("UTF-8") != std::string::npos || value.find("UTF8") != std::string::npos;
  }
  return false;
}

// The size of the screen behind a descriptor; COLUMNS and 80x24 where none exists.
TerminalSize SizeOf(int file_descriptor) {
  TerminalSize size;
  winsize window{};
  if (ioctl(file_descriptor, TIOCGWINSZ, &window) == 0 && window.ws_col > 0) {
    size.columns = window.ws_col;
    if (window.ws_row > 0) size.rows = window.ws_row;
  } else if (int columns = std::atoi(std::string(EnvironmentVariable("COLUMNS")).c_str());
             columns > 0) {
    size.columns = columns;
  }
  return size;
}

// Length in bytes of the escape sequence at the start of `text`, else 0.
size_t EscapeLength(std::string_view text) {
  if (text.size() < 2 || text[0] != '\x1b' || text[1] != '[') return 0;
  size_t end = 2;
  while (end < text.size() && (text[end] < 0x40 || text[end] > 0x7e)) ++end;
  return std::min(end + 1, text.size());
}

// Writes to a descriptor, and remembers why that failed: std::cout forgets.
class DescriptorBuffer final : public std::streambuf {
 public:
  DescriptorBuffer(int descriptor, bool by_line) : descriptor_(descriptor), by_line_(by_line) {}
  int error() const { return error_; }  // errno of the first failed write; 0: none has.

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    const std::string_view added(text, static_cast<size_t>(size));
    waiting_.append(added);
    const bool due =
        waiting_.size() >= kMostWaiting || (by_line_ && added.find('\n') != added.npos);
    return due && sync() != 0 ? 0 : size;
  }
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char letter = traits_type::to_char_type(c);
    return xsputn(&letter, 1) == 1 ? c : traits_type::eof();
  }
  int sync() override {
    std::string_view rest = waiting_;
    while (!rest.empty() && error_ == 0) {
      const ssize_t written = write(descriptor_, rest.data(), rest.size());
      if (written >= 0) {
        rest.remove_prefix(static_cast<size_t>(written));
      } else if (errno != EINTR) {
        error_ = errno;
      }
    }
    waiting_.clear();
    return error_ == 0 ? 0 : -1;
  }

 private:
  static constexpr size_t kMostWaiting = 1 << 16;

  const int descriptor_;
  const bool by_line_;
  std::string waiting_;
  int error_ = 0;
};

bool IsContinuation(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

}  // namespace

Terminal Terminal::OnDescriptor(int file_descriptor) {
  struct Output {
    DescriptorBuffer buffer;
    std::ostream stream{&buffer};
  };
  const std::shared_ptr<Output> output(new Output{{file_descriptor, isatty(file_descriptor) != 0}});
  Terminal terminal;
  terminal.stream = &output->stream;
  terminal.write_error = [output] { return output->buffer.error(); };
  return terminal;
}

Terminal Terminal::Standard(int file_descriptor) {
  Terminal terminal;
  if (file_descriptor == STDERR_FILENO) {
    terminal.stream = &std::cerr;
  } else {
    terminal = OnDescriptor(file_descriptor);
  }
  terminal.interactive = isatty(file_descriptor) != 0 && EnvironmentVariable("TERM") != "dumb";
  terminal.colour = terminal.interactive && EnvironmentVariable("NO_COLOR").empty();
  terminal.unicode = LocaleIsUtf8();
  terminal.size = [file_descriptor] { return SizeOf(file_descriptor); };
  return terminal;
}

std::string Terminal::Paint(Tone tone, std::string_view text) const {
  if (!colour || tone == Tone::kPlain || text.empty()) return std::string(text);
  return std::string(Code(tone)).append(text).append(kReset);
}

int DisplayWidth(std::string_view text) {
  int width = 0;
  while (!text.empty()) {
    if (size_t length = EscapeLength(text); length > 0) {
      text.remove_prefix(length);
      continue;
    }
    width += IsContinuation(text[0]) ? 0 : 1;
    text.remove_prefix(1);
  }
  return width;
}

std::string Truncate(std::string_view text, int columns) {
  std::string kept;
  int width = 0;
  bool open = false;  // A tone is on.
  for (size_t i = 0; i < text.size();) {
    if (size_t length = EscapeLength(text.substr(i)); length > 0) {
      const std::string_view escape = text.substr(i, length);
      open = escape != kReset;
      kept.append(escape);
      i += length;
      continue;
    }
    size_t end = i + 1;
    while (end < text.size() && IsContinuation(text[end])) ++end;
    if (width == columns) break;
    kept.append(text.substr(i, end - i));
    ++width;
    i = end;
  }
  if (open) kept.append(kReset);
  return kept;
}

std::string Pad(std::string_view text, int columns, Align align) {
  const std::string spaces(static_cast<size_t>(std::max(0, columns - DisplayWidth(text))), ' ');
  return align == Align::kLeft ? std::string(text) + spaces : spaces + std::string(text);
}

std::string LiveBlock::EraseSequence() const {
  std::string sequence;
  if (!shown_.empty()) {
    // Moves to the first column of the block's first line and clears to the end of the screen.
    sequence += fmt::format("\r\x1b[{}A\x1b[J", shown_.size());
  }
  return sequence;
}

void LiveBlock::Update(const std::vector<std::string>& lines) {
  if (!terminal_.interactive) return;
  const TerminalSize size = terminal_.size();
  const size_t most = static_cast<size_t>(std::max(1, size.rows - 1));
  std::vector<std::string> next;
  for (const std::string& line : lines) {
    if (next.size() == most) break;
    next.push_back(Truncate(line, std::max(1, size.columns - 1)));
  }
  if (next == shown_) return;
  // One write, so that no half-drawn block is seen.
  std::string text = EraseSequence();
  for (const std::string& line : next) text += line + "\n";
  *terminal_.stream << text << std::flush;
  shown_ = std::move(next);
}

void LiveBlock::Print(std::string_view line) {
  std::string text = EraseSequence();
  text.append(line).append("\n");
  for (const std::string& shown : shown_) text += shown + "\n";
  *terminal_.stream << text << std::flush;
}

void LiveBlock::Clear() {
  *terminal_.stream << EraseSequence() << std::flush;
  shown_.clear();
}

void LiveBlock::Keep() { shown_.clear(); }

}  // namespace parallax::client
