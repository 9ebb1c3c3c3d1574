// Reads the credentials in a request's headers. Pure functions; thread-safe.
#pragma once

#include <string>

namespace parallax {

// Returns the token of the header "Authorization": of "Bearer TOKEN", or the password of "Basic
// ...". Empty for anything else.
std::string TokenIn(const std::string& authorization);

// Returns the value of one cookie in the header "Cookie" ("a=1; b=2"); empty if it is absent.
std::string CookieIn(const std::string& header, const std::string& name);

// Returns whether the header "Host" is a loopback name or address. Another name may be a trick (DNS
// rebinding) by which a foreign page makes the browser take it for ours.
bool IsLoopbackHost(std::string host);

}  // namespace parallax
