// The interface between the agent and the work itself: one handler for each kind of job. The real
// handlers are in worker/jobs; tests bring their own.
#pragma once

#include <concepts>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

class Store;

// Numbers that a long job reports: "step", "loss", "eta_s"... At most 8.
using JobFigures = std::map<std::string, double>;

// Reports a fraction in [0, 1] and the current stage, names the log of a program that the job runs,
// and says that a job that waits does not hang. May be called from any thread, at any rate.
class JobProgressFn {
 public:
  template <std::invocable<double, std::string_view, const JobFigures&> Function>
  JobProgressFn(Function tell, std::function<void(const std::string&)> follow_log = nullptr,
                std::function<void()> alive = nullptr)
      : tell_(std::move(tell)), follow_log_(std::move(follow_log)), alive_(std::move(alive)) {}
  void operator()(double fraction, std::string_view stage, const JobFigures& figures = {}) const {
    tell_(fraction, stage, figures);
  }
  // From now on, the end of this file stands for the attempt's log while it runs.
  void FollowLog(const std::string& path) const {
    if (follow_log_) follow_log_(path);
  }

  // Counts as progress; fraction, stage and figures stay.
  void Alive() const {
    if (alive_) alive_();
  }

 private:
  std::function<void(double, std::string_view, const JobFigures&)> tell_;
  std::function<void(const std::string&)> follow_log_;
  std::function<void()> alive_;
};

// The folders of one attempt.
struct AttemptFolder {
  std::string dir;   // Absolute local folder, not yet made. Empty: the kind writes nothing.
  std::string path;  // The same in the store: "<store_prefix>/.attempt-<fence>".
  // Null: `dir` is in the store. Else `dir` is a staging folder whose files the agent sends there.
  std::shared_ptr<Store> send_to = nullptr;
  // The store itself, to read from, and, of a kind that writes, to put files below `path` while the
  // job runs.
  std::shared_ptr<Store> store = nullptr;
  // A local folder of this attempt alone, not yet made; removed when the attempt has ended.
  std::string scratch = "";
};

// A file that an attempt has written.
struct OutputFile {
  std::string name;    // Below the attempt's folder: "003/left.png".
  int64_t size = 0;    // Bytes.
  std::string sha256;  // Lower-case hex.
  bool sent = false;   // In the store already, although the folder is a staging folder.
};

// The result of a successful attempt.
struct JobOutcome {
  std::string result;             // The kind's own message, as its coordinator side parses it.
  std::vector<OutputFile> files;  // All files to be kept. Durable.
  double children_cpu_s = 0;      // CPU time of programs that it ran.
};

// The worker's side of one kind of jobs.
class JobHandler {
 public:
  // `kind` is the coordinator's name of the kind. With `resumes`, files that an attempt has put
  // into the store stay there when it fails or stops, because the next attempt continues from them.
  JobHandler(std::string kind, bool writes_output, bool resumes = false)
      : kind_(std::move(kind)), writes_output_(writes_output), resumes_(resumes) {}
  virtual ~JobHandler() = default;

  const std::string& kind() const { return kind_; }
  // Returns whether attempts write files. Kinds that write none need no store.
  bool writes_output() const { return writes_output_; }
  bool resumes() const { return resumes_; }

  // Does the job that `spec` describes: a message of the kind's coordinator side. Called from as
  // many threads at a time as the worker has slots. Returns soon after `cancel`, with any error.
  // Errors: kInvalidArgument for a malformed spec; the work's own.
  virtual absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                         const CancelToken& cancel,
                                         const JobProgressFn& progress) = 0;

 private:
  const std::string kind_;
  const bool writes_output_;
  const bool resumes_;
};

// One handler a kind.
using JobHandlers = std::vector<std::unique_ptr<JobHandler>>;
// Returns the handler of a kind; null if none exists.
inline JobHandler* FindHandler(const JobHandlers& handlers, std::string_view kind) {
  for (const auto& handler : handlers) {
    if (handler->kind() == kind) return handler.get();
  }
  return nullptr;
}

}  // namespace parallax
