// Addresses of web servers that one program accepts from another. Pure; thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace parallax {

// Returns an empty text if `url` is http://HOST[:PORT][/...] or https://..., else why not, without
// the address itself: its path may be a secret.
std::string WhyNotHttpUrl(std::string_view url);

// Returns the host of such an address in lower case, with its port unless that is the scheme's own,
// and without name and password: "hooks.example.com", "127.0.0.1:8080". Of another text: "".
std::string HostOfUrl(std::string_view url);

}  // namespace parallax
