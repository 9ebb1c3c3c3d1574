#include "common/base/shell_word.h"

#include <algorithm>
#include <cctype>

#include "common/base/names.h"

namespace parallax {

std::string ShellWord(std::string_view text) {
  constexpr std::string_view kPlain = "@%+=:,./_-";
  const std::string shown = Printable(text);
  const bool plain = std::all_of(shown.begin(), shown.end(), [&](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalnum(byte) != 0 || kPlain.find(c) != kPlain.npos;
  });
  if (plain && !shown.empty()) return shown;
  std::string word = "'";
  for (const char c : shown) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace parallax
