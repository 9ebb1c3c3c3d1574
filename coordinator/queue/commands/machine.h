// The state machine of jobs: carries out each command as changes of the tables, inside the writer's
// transaction. The commands are in families, each a class of its own; a method there is one
// command. It does the whole command, or returns an error and the writer undoes it. This is the
// frame of all commands: their beginning, end and undoing.
//
// Used by the writing thread only. Errors of all functions: those of the database, and those of
// JobMoves for what the end of a command brings about.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "coordinator/queue/commands/forgetting.h"
#include "coordinator/queue/commands/repair.h"
#include "coordinator/queue/commands/reports.h"
#include "coordinator/queue/commands/retries.h"
#include "coordinator/queue/commands/studies.h"
#include "coordinator/queue/commands/work_limits.h"
#include "coordinator/queue/moves/expander.h"
#include "coordinator/queue/moves/scheduler.h"
#include "coordinator/queue/moves/waiters.h"

namespace parallax {

class Machine {
 public:
  // `options` and `db` must outlive the machine.
  Machine(SqliteConnection& db, const JobQueueOptions& options, uint64_t epoch)
      : tables_(db, options, epoch) {}

  // Reads all unfinished studies. Call it first.
  absl::Status Load();

  // Every command runs between BeginCommand and either EndCommand or UndoCommand.
  void BeginCommand();
  // Takes results back that were found without files, settles waiters and writes delayed changes.
  // Not after an error.
  absl::Status EndCommand();
  void UndoCommand();
  // Marks changed studies as finished or not. Call it once for each group, before Ledger::Flush.
  absl::Status Settle();
  // Returns the effects of the commands since the last call.
  Effects TakeEffects();
  // Reads everything again, after the group was rolled back.
  absl::Status Reload();

  Tables& tables() { return tables_; }
  Scheduler& scheduler() { return scheduler_; }
  Expander& expander() { return expander_; }
  Reports& reports() { return reports_; }
  WorkLimits& limits() { return limits_; }
  Studies& studies() { return studies_; }
  Retries& retries() { return retries_; }
  Forgetting& forgetting() { return forgetting_; }
  Repair& repair() { return repair_; }

 private:
  Tables tables_;
  Waiters waiters_{tables_};
  JobMoves jobs_{tables_, waiters_};
  Scheduler scheduler_{tables_, jobs_, waiters_};
  Expander expander_{tables_, jobs_};
  Reports reports_{tables_, jobs_, waiters_, scheduler_};
  WorkLimits limits_{tables_};
  Studies studies_{tables_, jobs_, limits_};
  Retries retries_{tables_, jobs_, waiters_, limits_};
  Forgetting forgetting_{tables_};
  Repair repair_{tables_, jobs_, waiters_};
  // The effects before the current command.
  size_t granted_mark_ = 0, ended_mark_ = 0;
  EffectCounts counts_mark_;
};

}  // namespace parallax
