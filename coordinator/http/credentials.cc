#include "coordinator/http/credentials.h"

#include <algorithm>

namespace parallax {
namespace {

// Decodes up to the first character that is not a Base64 digit, such as the padding.
std::string DecodeBase64(const std::string& text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return bytes;
}

}  // namespace

std::string TokenIn(const std::string& authorization) {
  if (authorization.rfind("Bearer ", 0) == 0) return authorization.substr(7);
  if (authorization.rfind("Basic ", 0) != 0) return "";
  const std::string pair = DecodeBase64(authorization.substr(6));
  return pair.substr(std::min(pair.size(), pair.find(':') + 1));
}

std::string CookieIn(const std::string& header, const std::string& name) {
  for (size_t at = 0; at < header.size();) {
    const size_t end = std::min(header.find(';', at), header.size());
    const size_t begin = header.find_first_not_of(' ', at);
    if (begin == std::string::npos) break;
    if (header.compare(begin, name.size() + 1, name + "=") == 0) {
      return header.substr(begin + name.size() + 1, end - begin - name.size() - 1);
    }
    at = end + 1;
  }
  return "";
}

bool IsLoopbackHost(std::string host) {
  if (!host.empty() && host[0] == '[') return host.rfind("[::1]", 0) == 0;
  host = host.substr(0, host.find(':'));
  return host == "localhost" || host.rfind("127.", 0) == 0;
}

}  // namespace parallax
