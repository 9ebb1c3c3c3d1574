// Limits of the process: its threads, and how connections, store and database share its file
// descriptors.
#pragma once

#include "common/base/status.h"
#include "common/rpc/listener.h"

namespace parallax {

// Bounds on the connections of gRPC and of HTTP that leave descriptors for files.
struct DescriptorBudget {
  size_t descriptors = 0;  // The number that the process may have.
  ListenerLimits rpc;
  ListenerLimits http;
};

// Splits `descriptors`: files of store, database and logs have the first part, gRPC's callers most
// of the rest. Errors: kResourceExhausted for too few to serve at all.
absl::StatusOr<DescriptorBudget> SplitDescriptors(size_t descriptors);

// Raises the soft limit of this process to its hard limit, or to what is enough for any farm, and
// splits it. Errors: those of SplitDescriptors, and of the system.
absl::StatusOr<DescriptorBudget> RaiseDescriptors();

// Makes as many threads as `serve` needs at least, and ends them again: libraries end the process
// without a word where they get none. Errors: kResourceExhausted that says how many there are.
absl::Status CheckThreads();

}  // namespace parallax
