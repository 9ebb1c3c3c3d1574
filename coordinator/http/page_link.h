// A person's way from a certificate to the page: a browser has no certificate, but opens a link.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/rpc/certificate.h"

namespace parallax {

// Asks the coordinator's page at "HOST:PORT" for a link that opens one session of whom `identity`
// names, with its role, once, within ten minutes. Errors: kInvalidArgument for a bad address;
// kUnavailable when nobody answers there or the certificates don't fit; what the page says.
absl::StatusOr<std::string> AskForPageLink(const std::string& address, const TlsIdentity& identity);

}  // namespace parallax
