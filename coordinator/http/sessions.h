// Browsers that have shown once who they are. A one-time code, or the farm's token, becomes a
// session, whose random name the browser keeps in a cookie that no script can read.
//
// In memory: a restart ends all sessions. Bounded: the oldest make place for new ones. Thread-safe.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class Sessions {
 public:
  // `clock` outlives it.
  explicit Sessions(Clock& clock) : clock_(clock) {}

  // A code that opens one session of `caller`, once, within `valid_s`. Errors: NewSecret's.
  absl::StatusOr<std::string> NewCode(const RpcCaller& caller, double valid_s);
  // The name of a new session. Errors: kUnauthenticated for a code that there is not (any more);
  // NewSecret's.
  absl::StatusOr<std::string> Redeem(const std::string& code);
  // Errors: NewSecret's.
  absl::StatusOr<std::string> Open(const RpcCaller& caller);
  // Whose session it is; nothing for one that has ended.
  std::optional<RpcCaller> Find(const std::string& name);
  void End(const std::string& name);

 private:
  struct Entry {
    RpcCaller caller;
    double until_s = 0;  // On the steady clock.
  };
  using Entries = std::map<std::string, Entry>;  // By the SHA-256 of the secret.
  double Now() const;
  // Requires mu_.
  static void Add(Entries& entries, const std::string& secret, Entry entry, double now_s);

  Clock& clock_;
  std::mutex mu_;
  Entries codes_;     // Guarded by mu_.
  Entries sessions_;  // Guarded by mu_.
};

}  // namespace parallax
