// `coordinator init`: makes a farm's own certificate authority, the coordinator's certificate and
// those of workers and people. Existing files are replaced only if they are to be renewed.
//
//   DIR/ca/          ca.crt ca.key             stays with the operator
//   DIR/server/      ca.crt tls.crt tls.key http.token    coordinator serve --tls DIR/server
//   DIR/worker-farm/ ca.crt tls.crt tls.key    worker --tls, to be copied to its machines
//   DIR/submitter-ada/ ...                     parallax --tls
//
// Folders are 0700, keys and the token 0600.
#pragma once

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

struct InitOptions {
  std::string dir;
  // Names and addresses of the coordinator, beside this machine's own; with `renew` of "server",
  // beside those that its certificate has.
  std::vector<std::string> hosts;
  std::vector<std::pair<std::string, std::string>> issue;  // Roles and names of new certificates.
  // Folders of DIR ("server", "worker-pool") whose certificates are first put on the coordinator's
  // list of revoked ones (`revoke`), then replaced by new ones for the same party (`renew`).
  std::vector<std::string> revoke;
  std::vector<std::string> renew;
  double days = 398;  // Validity of certificates; the authority's is 10 years.
};

// Makes the authority and the server's folder if they are absent, and a folder for each `issue`.
// Lists on `out` what it made. A renewed folder replaces the old one as a whole. Errors:
// kAlreadyExists for a folder of `issue` that exists, and for `hosts` of a server that exists and
// is not renewed; kNotFound for a missing folder of `renew` or `revoke`, both before anything is
// written; kInvalidArgument for bad roles, names and hosts.
absl::Status InitFarm(const InitOptions& options, Clock& clock, std::ostream& out);

}  // namespace parallax
