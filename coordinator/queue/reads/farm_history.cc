// The farm's figures in the database: one small row a minute, at most two days of them.
#include "coordinator/queue/reads/farm_history.h"

#include "coordinator/queue/reads/readers.h"

namespace parallax {
namespace {

constexpr double kKeptFor_s = 2 * 86400;
constexpr double kClockSetBack_s = 3600;

}  // namespace

absl::Status KeepSampleIn(SqliteConnection& db, const HistorySample& sample) {
  RETURN_IF_ERROR(
      db.Run("INSERT INTO farm_history(unix_s, pairs_per_hour, ready, running, waiting, workers,"
             " slots, busy) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8) ON CONFLICT DO NOTHING",
             sample.unix_s, sample.pairs_per_hour, sample.ready, sample.running, sample.waiting,
             sample.workers, sample.slots, sample.busy));
  return db.Run("DELETE FROM farm_history WHERE unix_s < ?1 OR unix_s > ?2",
                sample.unix_s - kKeptFor_s, sample.unix_s + kClockSetBack_s);
}

absl::StatusOr<std::vector<HistorySample>> Readers::ListSamples(double since_unix_s) {
  return Get(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT unix_s, pairs_per_hour, ready, running, waiting, workers, slots, busy"
                      " FROM farm_history WHERE unix_s >= ?1 ORDER BY unix_s",
                      since_unix_s);
    return query.Rows([&] {
      return HistorySample{query.Real(0), query.Real(1), query.Int(2), query.Int(3),
                           query.Int(4),  query.Int(5),  query.Int(6), query.Int(7)};
    });
  });
}

}  // namespace parallax
