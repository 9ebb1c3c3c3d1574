#include "common/store/s3_text.h"

#include <cctype>
#include <charconv>
#include <ctime>
#include <utility>

namespace parallax {
namespace {

bool IsUnreserved(unsigned char c) {
  return std::isalnum(c) || c == '-' || c == '.' || c == '_' || c == '~';
}

bool IsHexDigit(char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }

// Returns the character of an entity's name; NUL if it is none of ASCII.
char CharacterOf(std::string_view name) {
  constexpr std::pair<std::string_view, char> kNamed[] = {
      {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
  for (const auto& [known, character] : kNamed) {
    if (name == known) return character;
  }
  if (name.substr(0, 1) != "#") return '\0';
  const bool is_hex = name.substr(1, 1) == "x";
  name.remove_prefix(is_hex ? 2 : 1);
  int code = 0;
  const char* const end = name.data() + name.size();
  const auto [at, error] = std::from_chars(name.data(), end, code, is_hex ? 16 : 10);
  const bool is_ascii = error == std::errc() && at == end && code > 0 && code < 128;
  return is_ascii ? static_cast<char>(code) : '\0';
}

}  // namespace

std::string PercentEncode(std::string_view text, bool keep_slash) {
  std::string encoded;
  for (const unsigned char c : text) {
    if (IsUnreserved(c) || (keep_slash && c == '/')) {
      encoded += static_cast<char>(c);
    } else {
      encoded += '%';
      encoded += "0123456789ABCDEF"[c >> 4];
      encoded += "0123456789ABCDEF"[c & 15];
    }
  }
  return encoded;
}

std::string PercentDecode(std::string_view text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    int value = 0;
    const bool is_code =
        text[i] == '%' && i + 2 < text.size() && IsHexDigit(text[i + 1]) && IsHexDigit(text[i + 2]);
    if (is_code) {
      std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
      decoded += static_cast<char>(value);
      i += 2;
    } else {
      decoded += text[i] == '+' ? ' ' : text[i];
    }
  }
  return decoded;
}

std::string_view Element(std::string_view xml, const std::string& name) {
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  const size_t begin = xml.find(open);
  const size_t end = begin == std::string_view::npos ? begin : xml.find(close, begin);
  if (end == std::string_view::npos) return "";
  return xml.substr(begin + open.size(), end - begin - open.size());
}

double UnixSecondsOf(std::string_view time) {
  std::tm parts{};
  const std::string text(time);
  if (strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts) == nullptr) return 0;
  return static_cast<double>(timegm(&parts));
}

std::string EscapeXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&'   ? "&amp;"
               : c == '<' ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
  }
  return escaped;
}

std::string UnescapeXml(std::string_view text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    const size_t end = text[i] == '&' ? text.find(';', i) : std::string_view::npos;
    const bool is_entity = end != std::string_view::npos;
    const char character = is_entity ? CharacterOf(text.substr(i + 1, end - i - 1)) : '\0';
    plain += character == '\0' ? text[i] : character;
    if (character != '\0') i = end;
  }
  return plain;
}

}  // namespace parallax
