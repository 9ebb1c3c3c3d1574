// What the agent knows of the work itself: one handler for each kind of job. worker/jobs has the
// real ones, tests have others.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

class Store;

// Fraction in [0, 1] and the stage at hand. May be called from any thread, as often as one likes.
using JobProgressFn = std::function<void(double fraction, std::string_view stage)>;

// Where an attempt writes.
struct AttemptFolder {
  std::string dir;   // Absolute local folder, not yet made. Empty: of a kind that writes nothing.
  std::string path;  // The same in the store: "<store_prefix>/.attempt-<fence>".
  // Null: `dir` is in the store. Else `dir` is a staging folder, and the agent sends what is in it.
  std::shared_ptr<Store> send_to = nullptr;
};

// A file that an attempt has written.
struct OutputFile {
  std::string name;    // Below the attempt's folder: "003/left.png".
  int64_t size = 0;    // Bytes.
  std::string sha256;  // Lower-case hex.
};

struct JobOutcome {
  std::string result;             // The kind's own message, as its coordinator side parses it.
  std::vector<OutputFile> files;  // All that is to be kept of the folder. Durable.
};

class JobHandler {
 public:
  // `kind` is the coordinator's name of it.
  JobHandler(std::string kind, bool writes_output)
      : kind_(std::move(kind)), writes_output_(writes_output) {}
  virtual ~JobHandler() = default;

  const std::string& kind() const { return kind_; }
  // Whether attempts write files; without, the worker needs no store.
  bool writes_output() const { return writes_output_; }

  // Does the job that `spec` describes, the message of the kind's coordinator side. Called from as
  // many threads at a time as the worker has slots. Returns soon after `cancel`, with any error.
  // Errors: kInvalidArgument for a spec that is none; the work's own.
  virtual absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                         const CancelToken& cancel,
                                         const JobProgressFn& progress) = 0;

 private:
  const std::string kind_;
  const bool writes_output_;
};

// One handler a kind.
using JobHandlers = std::vector<std::unique_ptr<JobHandler>>;
// Null if there is none.
inline JobHandler* FindHandler(const JobHandlers& handlers, std::string_view kind) {
  for (const auto& handler : handlers) {
    if (handler->kind() == kind) return handler.get();
  }
  return nullptr;
}

}  // namespace parallax
