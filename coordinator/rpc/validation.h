// What a stranger's message must look like before anything acts on it.
//
// Errors: kInvalidArgument naming the field, what was seen and what is allowed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/base/version.h"
#include "coordinator/queue/job_kind.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// More credit than this at a time is a mistake.
inline constexpr int kMaxCredit = 4096;

absl::Status CheckHello(const v1::Hello& hello, const KindRegistry& kinds);
absl::Status CheckCredit(const v1::Credit& credit);
absl::Status CheckHeartbeat(const v1::Heartbeat& heartbeat);
absl::Status CheckAttempt(const v1::AttemptId& attempt);
absl::Status CheckComplete(const v1::CompleteRequest& request);
absl::Status CheckFail(const v1::FailRequest& request);
// The study is refused in the words of ValidateStudy (common/config), as the client would.
absl::Status CheckSubmit(const v1::SubmitRequest& request);
absl::Status CheckStudyId(int64_t study_id);
// A pause, cancel, resume or retry: id and reason.
absl::Status CheckStudyChange(const v1::StudyRequest& request);
absl::Status CheckSetMaxRunning(const v1::SetMaxRunningRequest& request);
absl::Status CheckJobId(int64_t job_id);
// A worker's name in which * stands for any characters and ? for one, and the reason.
absl::Status CheckDrain(const v1::DrainWorkersRequest& request);
absl::Status CheckJobState(const std::string& state);  // Empty: any.
absl::Status CheckPutHeader(const v1::PutFileHeader& header);
absl::Status CheckLimit(int32_t limit, int32_t most);  // [0, most]

// Removes from `hello` the kinds of jobs of which the worker has a stage in another version than
// `ours`, and with them what it holds, which may be of such a kind. Returns a line for each removed
// kind. Errors: kFailedPrecondition with one line when no kind is left.
absl::StatusOr<std::vector<std::string>> DropKindsOfOtherVersions(const StageVersions& ours,
                                                                  const KindRegistry& registry,
                                                                  v1::Hello& hello);
// What a worker says of a failure or a job that it gives back is a program's text. It is kept in a
// printable form of at most kMaxErrorBytes and never refused: a report must not be lost over its
// words.
std::string CleanText(std::string_view text);
v1::FailRequest CleanFail(const v1::FailRequest& request);

}  // namespace parallax
