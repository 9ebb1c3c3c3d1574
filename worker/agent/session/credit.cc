#include "worker/agent/session/credit.h"

#include <algorithm>

namespace parallax {

std::optional<v1::Credit> CreditFor(const WorkLoad& load) {
  const int free = std::max(0, load.slots - load.taken);
  // Work whose reports can't be delivered is likely in vain.
  const int room = load.slots + load.max_pending_reports - load.taken - load.pending_reports;
  const int more = std::min(load.slots + load.ending_soon - load.taken, room);
  if (more <= 0) return std::nullopt;
  v1::Credit credit;
  credit.set_jobs(more);
  credit.set_ahead(std::max(0, more - free));
  return credit;
}

}  // namespace parallax
