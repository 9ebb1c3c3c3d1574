#include "coordinator/queue/reads/user_limits.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>

#include "coordinator/queue/reads/readers.h"
#include "coordinator/study/job_counts.h"

namespace parallax {
namespace {

// `user_room`: what is left of the user's own, for this study and those after it.
void HoldBack(const UserLimits& limits, int64_t& user_room, v1::StudyStatus& study) {
  if (study.state() != v1::STUDY_STATE_RUNNING) return;
  const int64_t ready = JobsInState(study, "READY");
  const int64_t waiting = ready + JobsInState(study, "RETRY_WAIT");
  const int64_t own_room = RoomUnder(study.max_running(), JobsInState(study, "LEASED"));
  const int64_t may_start = std::min({waiting, own_room, user_room});
  study.set_held_jobs(waiting - may_start);
  if (ready > 0 && own_room == 0) {
    study.set_at_limit(fmt::format("max_running {}", study.max_running()));
  } else if (ready > 0 && user_room == 0) {
    study.set_at_limit(fmt::format("max_running {} of {}", limits.max_running, study.user()));
  }
  if (limits.max_running > 0) user_room -= may_start;
}

void SetLimits(const UserLimits& limits, v1::UserStatus& user) {
  user.set_max_running(limits.max_running);
  user.set_max_studies(limits.max_studies);
  user.set_max_waiting_pairs(limits.max_waiting_pairs);
  user.set_rule(limits.rule);
  user.set_priority(static_cast<int32_t>(limits.priority));
}

}  // namespace

absl::StatusOr<std::vector<v1::UserStatus>> Readers::ListUsers() {
  return Get(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db, R"sql(
SELECT s.user, count(*),
  sum((SELECT coalesce(sum(v.pairs_wanted - v.pairs_done), 0) FROM variants AS v
       WHERE v.study_id = s.id AND v.problem = '')),
  sum((SELECT coalesce(sum(c.jobs), 0) FROM variants AS v JOIN job_counts AS c
       ON c.variant_id = v.id AND c.state = 'LEASED' WHERE v.study_id = s.id))
FROM studies AS s WHERE s.finished_unix_s IS NULL AND s.cancelled = 0
GROUP BY s.user ORDER BY s.user)sql");
    return query.Rows([&] {
      v1::UserStatus user;
      user.set_user(std::string(query.Text(0)));
      user.set_studies(query.Int(1));
      user.set_waiting_pairs(query.Int(2));
      user.set_running(query.Int(3));
      return user;
    });
  });
}

absl::Status AddLimits(Readers& readers, const LimitRules& limits,
                       std::span<v1::StudyStatus> studies) {
  std::map<std::string, UserLimits> of_user;
  bool any = false;
  for (const v1::StudyStatus& study : studies) {
    if (study.finished_unix_s() > 0) continue;
    const UserLimits user = limits.Of(study.user());
    of_user[study.user()] = user;
    any |= user.max_running > 0;
  }
  std::map<std::string, int64_t> rooms;
  for (const auto& [user, its] : of_user) rooms[user] = RoomUnder(its.max_running, 0);
  if (any) {
    ASSIGN_OR_RETURN(const std::vector<v1::UserStatus> users, readers.ListUsers());
    for (const v1::UserStatus& user : users) {
      rooms[user.user()] = RoomUnder(of_user[user.user()].max_running, user.running());
    }
  }
  for (v1::StudyStatus& study : studies) {
    if (study.finished_unix_s() == 0) {
      HoldBack(of_user[study.user()], rooms[study.user()], study);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<v1::UserStatus>> UsersWithLimits(Readers& readers,
                                                            const LimitRules& limits) {
  ASSIGN_OR_RETURN(std::vector<v1::UserStatus> active, readers.ListUsers());
  std::map<std::string, v1::UserStatus> users;
  for (const std::string& user : limits.NamedUsers()) users[user].set_user(user);
  for (v1::UserStatus& user : active) {
    const std::string name = user.user();
    users[name] = std::move(user);
  }
  std::vector<v1::UserStatus> all;
  for (auto& [name, user] : users) {
    SetLimits(limits.Of(name), user);
    all.push_back(std::move(user));
  }
  return all;
}

}  // namespace parallax
