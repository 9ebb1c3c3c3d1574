// What a request's headers say of its caller. Pure and thread-safe.
#pragma once

#include <string>

namespace parallax {

// Token of "Bearer TOKEN", or of the password in "Basic ..."; empty for anything else.
std::string TokenIn(const std::string& authorization);

// Value of one cookie of "a=1; b=2"; empty if it isn't there.
std::string CookieIn(const std::string& header, const std::string& name);

// Whether the header "Host" names this machine as such. A browser that was made to look up another
// name for it would take a foreign page for ours.
bool IsLoopbackHost(std::string host);

}  // namespace parallax
