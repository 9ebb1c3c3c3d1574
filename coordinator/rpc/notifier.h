// Tells the farm's operator, and the receivers that studies name, when a study ends, stalls, has
// failed jobs or jobs that wait for a person: by an HTTP POST of a small JSON document, to the
// operator by a command as well.
//
// The queue keeps a row for each notice until its receiver has it (HTTP status 2xx, exit status 0),
// so a notice arrives at least once, also over restarts of the coordinator; after a restart a study
// that is still stalled or waits is told of again. A delivery that failed is repeated after 10 s,
// 20 s... up to an hour, for a week. The queue never waits for a receiver.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/store/http_client.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/study/notify_hosts.h"

namespace parallax {

class WaitReasons;

struct NotifierOptions {
  std::string url;        // Gets the POST; empty: none. Only its host is logged.
  std::string command;    // Program whose one argument is the document; empty: none.
  NotifyHosts hosts;      // Hosts of studies' own receivers; empty: these are told nothing.
  double stall_s = 1800;  // Time without a running job after which a study is stalled; 0: never.
  double waits_s = 300;  // Time for which a reason has held jobs back until it is told; 0: at once.
  double every_s = 5;    // Time between looks for notices that are due; 0: only calls of Look().
  double retry_s = 10;   // Wait after the first failed delivery; doubles with each.
  double most_s = 20;    // Longest time of one delivery.
  Clock* clock = &Clock::System();  // Must outlive the notifier.

  // Returns the receivers, for JobQueueOptions::notice_targets.
  std::vector<std::string> Targets() const;
};

// Checks the receivers. Errors: kInvalidArgument for a URL that is not http:// or https://;
// kNotFound for a command that is no program.
absl::Status CheckNotifierOptions(const NotifierOptions& options);

// Returns the document for a notice, in one line: {"event", "text", "unix_s", "study": {...}}, the
// study as `parallax status --json` lists it.
std::string NoticeJson(const Notice& notice, const v1::StudyStatus& study, double stall_s);

// Thread-safe, but Look() is for one thread. Has one thread.
class Notifier {
 public:
  // Both must outlive the notifier.
  Notifier(JobQueue& queue, const WaitReasons& waits, const NotifierOptions& options);
  ~Notifier();  // Gives up a delivery in progress; it is repeated at the next start.
  // Ends the thread, and delivers once more what is due. The object does nothing afterwards.
  void Finish();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;

  // Looks for studies that are stalled or wait, and delivers what is due. Returns the number of
  // notices delivered. Errors: the queue's.
  absl::StatusOr<int> Look();

 private:
  void Loop();
  void StopThread();
  bool IsStopping() const;
  absl::Status LookAtStudies();
  absl::Status LookForStall(const v1::StudyStatus& study, double now_s);
  absl::Status LookForNeeds(v1::StudyStatus study, double now_s);
  // Delivers one notice, or drops one that nobody wants. Errors: the receiver's.
  absl::Status Deliver(const Notice& notice) const;
  absl::Status Post(const std::string& url, const std::string& json) const;
  absl::Status RunCommand(const std::string& json) const;

  JobQueue& queue_;
  const WaitReasons& waits_;
  const NotifierOptions options_;
  const HttpClient http_;

  // A study stalls or waits: since when (steady time), and whether a notice has told it.
  struct Finding {
    double since_s = 0;
    bool told = false;
    int64_t seen = 0;  // The last look that found it.
  };
  // Notes what this look finds. Returns whether it has held for `least_s` and is to be told now;
  // the caller sets `told` once the database keeps the notice.
  static bool IsNews(Finding& finding, double now_s, double least_s, int64_t look);

  // ---- Used by Look only
  int64_t look_ = 0;
  std::map<int64_t, Finding> stalls_;                         // By study.
  std::map<std::pair<int64_t, std::string>, Finding> needs_;  // By study and reason.

  mutable std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.
  std::thread thread_;
};

}  // namespace parallax
