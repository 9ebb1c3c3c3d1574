#include "common/base/http_url.h"

#include <algorithm>
#include <cctype>

namespace parallax {
namespace {

constexpr size_t kMostUrlBytes = 2048;

bool IsIn(char c, std::string_view chars) { return chars.find(c) != std::string_view::npos; }
bool IsAsciiAlnum(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }
bool AreDigits(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Programs read characters outside of these differently, and then reach another host.
bool IsUrlChar(char c) { return IsAsciiAlnum(c) || IsIn(c, "-._~:/?#[]@!$&'()*+,;=%"); }

bool IsHost(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    return std::all_of(host.begin() + 1, host.end() - 1, [](char c) {
      return std::isxdigit(static_cast<unsigned char>(c)) != 0 || IsIn(c, ":.");
    });
  }
  return !host.empty() && std::all_of(host.begin(), host.end(),
                                      [](char c) { return IsAsciiAlnum(c) || IsIn(c, "-._"); });
}

}  // namespace

std::string HostOfUrl(std::string_view url) {
  const bool plain = url.starts_with("http://");
  if (url.size() > kMostUrlBytes || (!plain && !url.starts_with("https://"))) return "";
  if (!std::all_of(url.begin(), url.end(), IsUrlChar)) return "";
  url.remove_prefix(url.find("://") + 3);
  url = url.substr(0, url.find_first_of("/?#"));
  if (std::count(url.begin(), url.end(), '@') > 1) return "";
  url.remove_prefix(url.find('@') + 1);  // npos + 1 is 0.
  const size_t colon = url.find(':', url.starts_with('[') ? url.find(']') : 0);
  const std::string_view host = url.substr(0, colon);
  const std::string_view port = colon == std::string_view::npos ? "" : url.substr(colon + 1);
  if (!IsHost(host) || !AreDigits(port) || port.size() > 5) return "";
  std::string text(host);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!port.empty() && port != (plain ? "80" : "443")) text += ":" + std::string(port);
  return text;
}

std::string WhyNotHttpUrl(std::string_view url) {
  return HostOfUrl(url).empty() ? "is no address, allowed is http://HOST/... or https://HOST/..."
                                : "";
}

}  // namespace parallax
