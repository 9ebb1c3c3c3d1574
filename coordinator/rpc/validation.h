// What a stranger's message must look like before anything acts on it. Each error is
// kInvalidArgument and names the field, what was seen and what is allowed.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/version.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// More credit than this at a time is a mistake.
inline constexpr int kMaxCredit = 4096;

absl::Status CheckHello(const v1::Hello& hello);
absl::Status CheckCredit(const v1::Credit& credit);
absl::Status CheckHeartbeat(const v1::Heartbeat& heartbeat);
absl::Status CheckAttempt(const v1::AttemptId& attempt);
absl::Status CheckComplete(const v1::CompleteRequest& request);
absl::Status CheckFail(const v1::FailRequest& request);
absl::Status CheckSubmit(const v1::SubmitRequest& request);
absl::Status CheckStudyId(int64_t study_id);
absl::Status CheckLimit(int32_t limit, int32_t most);  // [0, most]

// Removes from `hello` the kinds of jobs of which the worker has a stage in another version than
// `ours`, and with them what it holds, which may be of such a kind. Returns a line for each removed
// kind. Errors: kFailedPrecondition with one line when no kind is left.
absl::StatusOr<std::vector<std::string>> DropKindsOfOtherVersions(const StageVersions& ours,
                                                                  v1::Hello& hello);

}  // namespace parallax
