// TLS of the web page: the server asks for client certificates but accepts callers without one, and
// reads the caller's name and role from a certificate.
#pragma once

#include <optional>
#include <string>

#include "common/rpc/endpoint.h"

struct ssl_st;
struct ssl_ctx_st;

namespace parallax {

// Loads certificate, key and authority from the TLS folder `dir` into `context`. Returns false if
// one of them can't be used.
bool SetUpTls(const std::string& dir, ssl_ctx_st& context);

// Returns the caller that a connection's certificate names; nothing without a certificate. A caller
// whose certificate our authority did not sign can't connect at all.
std::optional<RpcCaller> CallerOf(const ssl_st* connection);

// Returns whether a certificate, as PEM, is for this host name, which its own names may match by
// "*".
bool IsNameOf(const std::string& certificate_pem, const std::string& host);

}  // namespace parallax
