// Gets a link to the web page for a user with a certificate: the browser, which has none, opens it.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/rpc/certificate.h"

namespace parallax {

// Asks the coordinator's page at "HOST:PORT" for a link that opens one session with the name and
// role of `identity`. The link works once, within ten minutes. Errors: kInvalidArgument for a bad
// address; kUnavailable if nobody answers there or the certificates don't fit; the page's own.
absl::StatusOr<std::string> AskForPageLink(const std::string& address, const TlsIdentity& identity);

}  // namespace parallax
