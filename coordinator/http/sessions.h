// Sessions of browsers. A one-time code or the farm's token opens a session, whose random name the
// browser keeps in a cookie that no script can read.
//
// Sessions are kept in memory, so a restart ends them. Their number is bounded, in total and for
// each caller: a caller's oldest session makes room for its new one, and no other caller's.
// Thread-safe.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class Sessions {
 public:
  // `clock` must outlive the object.
  explicit Sessions(Clock& clock) : clock_(clock) {}

  // Returns a code that opens one session of `caller`. It works once, within `valid_s` seconds.
  // Errors: those of NewSecret.
  absl::StatusOr<std::string> NewCode(const RpcCaller& caller, double valid_s);
  // Opens a session by a code and returns its name. Errors: kUnauthenticated for a code that is
  // unknown, used or too old; those of NewSecret.
  absl::StatusOr<std::string> Redeem(const std::string& code);
  // Opens a session of `caller` and returns its name. Errors: those of NewSecret.
  absl::StatusOr<std::string> Open(const RpcCaller& caller);
  // Returns the session's caller; nothing if the session has ended.
  std::optional<RpcCaller> Find(const std::string& name);
  // Ends a session; does nothing if none exists of this name.
  void End(const std::string& name);

 private:
  struct Entry {
    RpcCaller caller;
    double until_s = 0;  // End of validity on the steady clock.
  };
  using Entries = std::map<std::string, Entry>;  // Keys are SHA-256 of the secrets.
  double Now() const;
  // Requires mu_.
  static void Add(Entries& entries, const std::string& secret, Entry entry, double now_s);

  Clock& clock_;
  std::mutex mu_;
  Entries codes_;     // Guarded by mu_.
  Entries sessions_;  // Guarded by mu_.
};

}  // namespace parallax
