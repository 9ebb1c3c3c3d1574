// Reads the credentials in a request's headers. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <string>

namespace parallax {

// Returns the token of the header "Authorization": of "Bearer TOKEN", or the password of "Basic
// ...". Empty for anything else.
std::string TokenIn(const std::string& authorization);

// Returns the value of one cookie in the header "Cookie" ("a=1; b=2"); empty if it is absent.
std::string CookieIn(const std::string& header, const std::string& name);

// Returns the host of the header "Host", without port and brackets; nothing if the header is no
// "HOST" or "HOST:PORT".
std::optional<std::string> HostIn(const std::string& header);

// Returns whether no other site's owner can have pointed this name at this machine: the machine's
// own name, or one without a dot, as only the local network has them.
bool IsOwnName(const std::string& host);

}  // namespace parallax
