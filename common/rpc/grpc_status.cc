#include "common/rpc/grpc_status.h"

#include <grpcpp/support/status.h>

namespace parallax {
namespace {
constexpr size_t kMaxMessageBytes = 2000;
}

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  return absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
}

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()),
                      std::string(ToStd(status.message()).substr(0, kMaxMessageBytes)));
}

}  // namespace parallax
