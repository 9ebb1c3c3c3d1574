// `coordinator init`: a farm's own certificate authority, the coordinator's certificate and those
// of workers and people. What there is already is overwritten only where it is to be renewed.
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

#include "common/base/clock.h"
#include "common/base/status.h"

namespace parallax {

struct InitOptions {
  std::string dir;
  // Names and addresses that the coordinator is reached by, beside this machine's own.
  std::vector<std::string> hosts;
  std::vector<std::pair<std::string, std::string>> issue;  // Role and name.
  // Folders of DIR ("server", "worker-pool"): their certificates are put on the coordinator's list
  // of those that it refuses (`revoke`), and replaced by ones for the same party (`renew`), in this
  // order.
  std::vector<std::string> revoke;
  std::vector<std::string> renew;
  double days = 398;  // Of certificates; the authority has 10 years.
};

// Makes the authority and the server's folder where they are absent, and a folder for each `issue`;
// says what it made. Renewed folders appear whole, in place of the old ones. Errors: kAlreadyExists
// for what is there already, kNotFound for folders to renew or revoke that are not, both before
// anything is written; kInvalidArgument for roles, names and hosts.
absl::Status InitFarm(const InitOptions& options, Clock& clock, std::ostream& out);

}  // namespace parallax
