// The messages of jobs, in and out of the bytes in which they travel.
#pragma once

#include <cstdint>
#include <string>

#include "parallax/v1/service.pb.h"

namespace parallax {

inline v1::SolveJob SolveOf(const v1::Lease& lease) {
  v1::SolveJob job;
  job.ParseFromString(lease.spec());
  return job;
}
inline v1::RenderJob RenderOf(const v1::Lease& lease) {
  v1::RenderJob job;
  job.ParseFromString(lease.spec());
  return job;
}
inline v1::SolveResult SolveOf(const v1::CompleteRequest& request) {
  v1::SolveResult result;
  result.ParseFromString(request.result());
  return result;
}
inline v1::RenderResult RenderOf(const v1::CompleteRequest& request) {
  v1::RenderResult result;
  result.ParseFromString(request.result());
  return result;
}
inline void SetResult(const v1::SolveResult& result, v1::CompleteRequest& request) {
  request.set_kind("solve");
  request.set_result(result.SerializeAsString());
}
inline void SetResult(const v1::RenderResult& result, v1::CompleteRequest& request) {
  request.set_kind("render");
  request.set_result(result.SerializeAsString());
}
// `edit` changes the result that the request carries.
template <typename Edit>
void EditSolve(v1::CompleteRequest& request, const Edit& edit) {
  v1::SolveResult result = SolveOf(request);
  edit(result);
  SetResult(result, request);
}
template <typename Edit>
void EditRender(v1::CompleteRequest& request, const Edit& edit) {
  v1::RenderResult result = RenderOf(request);
  edit(result);
  SetResult(result, request);
}

// Number of a variant's jobs in this state; of all kinds if `kind` is empty.
inline int64_t JobsOf(const v1::VariantStatus& variant, const std::string& kind,
                      const std::string& state) {
  int64_t jobs = 0;
  for (const v1::JobCount& count : variant.jobs()) {
    if ((kind.empty() || count.kind() == kind) && count.state() == state) jobs += count.jobs();
  }
  return jobs;
}
inline void AddJobCount(v1::VariantStatus& variant, const std::string& kind,
                        const std::string& state, int64_t jobs) {
  v1::JobCount* count = variant.add_jobs();
  count->set_kind(kind);
  count->set_state(state);
  count->set_jobs(jobs);
}

}  // namespace parallax
