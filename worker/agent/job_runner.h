// What the agent knows of the work itself: two calls that worker/main.cc fills with the real stages
// and tests with fakes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {

class Store;

// Fraction in [0, 1] and the stage at hand. May be called from any thread, as often as one likes.
using JobProgressFn = std::function<void(double fraction, std::string_view stage)>;

// Where an attempt to render writes.
struct AttemptFolder {
  std::string dir;   // Absolute local folder, not yet made.
  std::string path;  // The same in the store: "<store_prefix>/.attempt-<fence>".
  // Null: `dir` is in the store. Else `dir` is a staging folder, and the agent sends what is in it.
  std::shared_ptr<Store> send_to = nullptr;
};

// Called from as many threads at a time as the worker has slots. Both return soon after `cancel`
// (with any error).
class JobRunner {
 public:
  virtual ~JobRunner() = default;
  virtual absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                                const JobProgressFn& progress) = 0;
  // What it returns is durable in `folder`.
  virtual absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job,
                                                  const AttemptFolder& folder,
                                                  const CancelToken& cancel,
                                                  const JobProgressFn& progress) = 0;
};

}  // namespace parallax
