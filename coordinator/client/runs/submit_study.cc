#include "coordinator/client/runs/submit_study.h"

#include <fmt/core.h>

#include "coordinator/client/content/study_options.h"

namespace parallax::client {

absl::StatusOr<Submitted> SubmitStudy(SubmitOrder order, Connection& connection, Clock& clock) {
  Submitted submitted;
  if (order.ship_content) {
    ASSIGN_OR_RETURN(submitted.shipped, ShipContent(order.study, *connection.RemoteStore()));
  } else {
    NameOwnCopies(order.study);
  }
  v1::SubmitRequest request;
  request.set_idempotency_key(IdempotencyKey(order.study));
  if (order.again) {
    // The time makes the key one of its own; what is rendered already is still reused by its
    // content.
    request.mutable_idempotency_key()->append(fmt::format(" again {:f}", clock.UnixSeconds()));
  }
  request.set_max_running(order.max_running);
  *request.mutable_study() = std::move(order.study);
  ASSIGN_OR_RETURN(submitted.reply, connection.Submit(request));
  return submitted;
}

}  // namespace parallax::client
