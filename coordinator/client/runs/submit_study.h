// Gives a study to a coordinator, with the user's own content that it names.
#pragma once

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/content/ship_content.h"
#include "parallax/v1/service.pb.h"

namespace parallax::client {

struct SubmitOrder {
  v1::StudySpec study;       // After HashContent.
  int max_running = 0;       // 0: no limit.
  bool again = false;        // Although the same study is there already.
  bool ship_content = true;  // Else each worker has its copy of the content.
};

struct Submitted {
  v1::SubmitReply reply;
  ShippedContent shipped;
};

// Brings the study's own content into the coordinator's store and submits the study. Errors: those
// of ShipContent and of the connection.
absl::StatusOr<Submitted> SubmitStudy(SubmitOrder order, Connection& connection, Clock& clock);

}  // namespace parallax::client
