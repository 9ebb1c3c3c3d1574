// Checks messages from workers and clients before anything acts on them.
//
// Errors: kInvalidArgument that names the field, the value and what is allowed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/base/version.h"
#include "coordinator/queue/job_kind.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// Largest credit in one message.
inline constexpr int kMaxCredit = 4096;

absl::Status CheckHello(const v1::Hello& hello, const KindRegistry& kinds);
absl::Status CheckCredit(const v1::Credit& credit);
absl::Status CheckHeartbeat(const v1::Heartbeat& heartbeat);
absl::Status CheckAttempt(const v1::AttemptId& attempt);
absl::Status CheckComplete(const v1::CompleteRequest& request);
absl::Status CheckFail(const v1::FailRequest& request);
// Refuses a study in the words of ValidateStudy (common/config), as the client does.
absl::Status CheckSubmit(const v1::SubmitRequest& request);
absl::Status CheckStudyId(int64_t study_id);
// Checks a pause, cancel, resume or retry: id and reason.
absl::Status CheckStudyChange(const v1::StudyRequest& request);
absl::Status CheckSetMaxRunning(const v1::SetMaxRunningRequest& request);
absl::Status CheckSetPriority(const v1::SetPriorityRequest& request);
absl::Status CheckRetryJob(const v1::RetryJobRequest& request);
absl::Status CheckJobId(int64_t job_id);
// Checks the pattern of workers' names, in which * stands for any characters and ? for one, and the
// reason.
absl::Status CheckDrain(const v1::DrainWorkersRequest& request);
absl::Status CheckJobState(const std::string& state);  // Empty: any.
absl::Status CheckPutHeader(const v1::PutFileHeader& header);
absl::Status CheckNextPairs(const v1::NextPairsRequest& request);
absl::Status CheckLimit(int32_t limit, int32_t most);  // [0, most]

// Removes from `hello` the kinds of jobs for which the worker has another version of a stage than
// `ours`. If there are any, also clears `holding`, because its attempts may be of such a kind.
// Returns a line for each removed kind. Errors: kFailedPrecondition with one line if no kind is
// left.
absl::StatusOr<std::vector<std::string>> DropKindsOfOtherVersions(const StageVersions& ours,
                                                                  const KindRegistry& registry,
                                                                  v1::Hello& hello);
// Makes a worker's text about a failure, or a job that it hands back, printable and at most
// kMaxErrorBytes long. Such texts are never refused: a report must not be lost because of its
// words.
std::string CleanText(std::string_view text);
v1::FailRequest CleanFail(const v1::FailRequest& request);

}  // namespace parallax
