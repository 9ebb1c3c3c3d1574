#include "coordinator/http/sessions.h"

#include <algorithm>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/secret.h"

namespace parallax {
namespace {

constexpr double kSession_s = 12 * 3600;
constexpr size_t kMostEntries = 1000;
constexpr size_t kMostOfACaller = 100;

// Callers without a certificate are one: this machine.
std::string_view KeyOf(const RpcCaller& caller) {
  return caller.name.empty() ? "this machine" : std::string_view(caller.name);
}

}  // namespace

double Sessions::Now() const { return SecondsBetween(SteadyTime{}, clock_.Steady()); }

void Sessions::Add(Entries& entries, const std::string& secret, Entry entry, double now_s) {
  std::erase_if(entries, [now_s](const auto& one) { return one.second.until_s <= now_s; });
  // Who has most makes room, and the caller itself when it has its share: nobody ends another's.
  std::map<std::string_view, size_t> by_caller;
  for (const auto& [key, one] : entries) ++by_caller[KeyOf(one.caller)];
  std::string from;
  if (by_caller[KeyOf(entry.caller)] >= kMostOfACaller) {
    from = KeyOf(entry.caller);
  } else if (entries.size() >= kMostEntries) {
    from = std::max_element(by_caller.begin(), by_caller.end(), [](const auto& a, const auto& b) {
             return a.second < b.second;
           })->first;
  }
  auto oldest = entries.end();
  for (auto at = entries.begin(); !from.empty() && at != entries.end(); ++at) {
    const bool is_older = oldest == entries.end() || at->second.until_s < oldest->second.until_s;
    if (KeyOf(at->second.caller) == from && is_older) oldest = at;
  }
  if (oldest != entries.end()) entries.erase(oldest);
  entries[Sha256Hex(secret)] = std::move(entry);
}

absl::StatusOr<std::string> Sessions::NewCode(const RpcCaller& caller, double valid_s) {
  ASSIGN_OR_RETURN(std::string code, NewSecret());
  std::lock_guard lock(mu_);
  Add(codes_, code, {caller, Now() + valid_s}, Now());
  return code;
}

absl::StatusOr<std::string> Sessions::Redeem(const std::string& code) {
  RpcCaller caller;
  {
    std::lock_guard lock(mu_);
    const auto found = codes_.find(Sha256Hex(code));
    if (found == codes_.end() || found->second.until_s <= Now()) {
      return Unauthenticated("this link was used already, or is too old: ask for another");
    }
    caller = found->second.caller;
    codes_.erase(found);
  }
  return Open(caller);
}

absl::StatusOr<std::string> Sessions::Open(const RpcCaller& caller) {
  ASSIGN_OR_RETURN(std::string name, NewSecret());
  std::lock_guard lock(mu_);
  Add(sessions_, name, {caller, Now() + kSession_s}, Now());
  return name;
}

std::optional<RpcCaller> Sessions::Find(const std::string& name) {
  std::lock_guard lock(mu_);
  const auto found = sessions_.find(Sha256Hex(name));
  if (found == sessions_.end() || found->second.until_s <= Now()) return std::nullopt;
  return found->second.caller;
}

void Sessions::End(const std::string& name) {
  std::lock_guard lock(mu_);
  sessions_.erase(Sha256Hex(name));
}

}  // namespace parallax
