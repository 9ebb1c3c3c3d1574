// Parts that every server of a web page shares: headers of all replies, and the page's own files.
// Thread-safe.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/http/server/web_server.h"

namespace parallax {

// Returns the headers that every reply has. The content policy runs no scripts but the server's own
// files.
std::vector<std::pair<std::string, std::string>> PageHeaders();

// Returns the reply for one of the page's own files, whoever asks (page_files.h); nothing for other
// paths and methods.
std::optional<ServerReply> PageFileReply(const ServerRequest& request);

}  // namespace parallax
