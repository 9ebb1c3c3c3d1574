#include "common/base/names.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

namespace parallax {
namespace {

constexpr size_t kShownBytes = 60;

bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsAlnum(char c) { return IsLower(c) || IsDigit(c) || (c >= 'A' && c <= 'Z'); }

// One character of UTF-8, or one byte that is none.
struct Character {
  uint32_t code = 0;
  size_t bytes = 1;
  bool valid = false;
};

// Source: RFC 3629, section 4 (no overlong forms, no surrogates, at most U+10FFFF).
Character CharacterAt(std::string_view text, size_t at) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[at + i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() - at < bytes) return {lead, 1, false};
  uint32_t code = lead & (0xff >> (bytes + 1));
  for (size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {lead, 1, false};
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kLeast[bytes] || code > 0x10ffff || surrogate) return {lead, 1, false};
  return {code, bytes, true};
}

// Characters that end a line, move the cursor, turn the direction of writing, or can't be seen.
// Source: Unicode 15, general categories Cc, Zl and Zp, property Bidi_Control; and U+200B, U+FEFF
// and the tag characters.
bool IsUnprintable(uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code <= 0x9f) || code == 0x061c || code == 0x200b ||
         code == 0x200e || code == 0x200f || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069) || code == 0xfeff ||
         (code >= 0xe0000 && code <= 0xe007f);
}

std::string Hex(uint32_t value, size_t least_digits) {
  std::string digits;
  for (; value > 0 || digits.size() < least_digits; value >>= 4) {
    digits += "0123456789abcdef"[value & 15];
  }
  return {digits.rbegin(), digits.rend()};
}

std::string Escaped(const Character& character) {
  if (character.valid && character.code == '\n') return "\\n";
  if (character.valid && character.code == '\t') return "\\t";
  if (!character.valid || character.code < 0x80) return "\\x" + Hex(character.code, 2);
  return "\\u{" + Hex(character.code, 4) + "}";
}

template <typename Predicate>
bool AllCharacters(std::string_view text, Predicate predicate) {
  for (size_t at = 0; at < text.size();) {
    const Character character = CharacterAt(text, at);
    if (!predicate(character)) return false;
    at += character.bytes;
  }
  return true;
}

// The longest beginning of at most `most` bytes that ends between two characters.
std::string_view Beginning(std::string_view text, size_t most) {
  size_t end = 0;
  while (end < text.size()) {
    const size_t next = end + CharacterAt(text, end).bytes;
    if (next > most) break;
    end = next;
  }
  return text.substr(0, end);
}

}  // namespace

bool IsName(std::string_view text) {
  return !text.empty() && text.size() <= kMaxNameBytes && IsAlnum(text.front()) &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return IsAlnum(c) || c == '.' || c == '_' || c == '-'; });
}

bool IsFolderName(std::string_view text) {
  return !text.empty() && text.size() <= kMaxFolderNameBytes &&
         (IsLower(text.front()) || IsDigit(text.front())) &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return IsLower(c) || IsDigit(c) || c == '_' || c == '-'; });
}

bool IsUtf8(std::string_view text) {
  return AllCharacters(text, [](const Character& character) { return character.valid; });
}

bool IsPlainText(std::string_view text) {
  return AllCharacters(text, [](const Character& character) {
    return character.valid && !IsUnprintable(character.code);
  });
}

absl::Status CheckName(std::string_view what, std::string_view text) {
  if (IsName(text)) return absl::OkStatus();
  return InvalidArgument("{} {}", what, WhyNotName(text));
}

absl::Status CheckPlainText(std::string_view what, std::string_view text, size_t most) {
  if (text.size() > most) {
    return InvalidArgument("{} has {} bytes, allowed are at most {}", what, text.size(), most);
  }
  if (IsPlainText(text)) return absl::OkStatus();
  return InvalidArgument(
      "{} {} is not plain text, allowed is one line of UTF-8 without control characters and "
      "direction marks",
      what, Quoted(text));
}

std::string WhyNotName(std::string_view text) {
  return fmt::format(
      "{} is not a name, allowed are letters, digits, '.', '_' and '-', first a letter or digit, "
      "at most {}",
      Quoted(text), kMaxNameBytes);
}

std::string WhyNotFolderName(std::string_view text) {
  return fmt::format(
      "{} can't be a folder's name, allowed are a-z, 0-9, _ and -, first a letter or digit, at "
      "most {}",
      Quoted(text), kMaxFolderNameBytes);
}

std::string Printable(std::string_view text) {
  std::string shown;
  for (size_t at = 0; at < text.size();) {
    const Character character = CharacterAt(text, at);
    if (character.valid && !IsUnprintable(character.code)) {
      shown += text.substr(at, character.bytes);
    } else {
      shown += Escaped(character);
    }
    at += character.bytes;
  }
  return shown;
}

std::string Quoted(std::string_view text) {
  const std::string_view beginning = Beginning(text, kShownBytes);
  return "\"" + Printable(beginning) + (beginning.size() < text.size() ? "...\"" : "\"");
}

std::string CutText(std::string_view text, size_t most) {
  if (text.size() <= most) return std::string(text);
  if (most < 3) return std::string(most, '.');
  return std::string(Beginning(text, most - 3)) + "...";
}

}  // namespace parallax
