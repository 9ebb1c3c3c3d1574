// Experiment 9: a farm whose parts are of two releases. The older one is there as what it left and
// said - a database in the middle of a study, the messages of its worker - and, with `--old`, as
// its programs.
#include <grpcpp/grpcpp.h>
#include <signal.h>
#include <sqlite3.h>

#include <thread>

#include "common/base/system/file.h"
#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "tests/faults/farm.h"
#include "tests/worker/agent/noop_runner.h"

namespace parallax::faults {
namespace {

v1::Hello HelloOf(const std::string& name) {
  v1::Hello hello;
  hello.set_name(name);
  hello.add_kinds("solve");
  hello.add_kinds("render");
  hello.set_protocol(kWorkProtocol);
  hello.set_slots(1);
  hello.set_version("0.0.1");
  return hello;
}

// Says hello and expects to be refused with a message that names `why`.
void ExpectRefused(Farm& farm, const v1::Hello& hello, const std::string& why, Tally& tally) {
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::seconds(10));
  const auto stream = farm.stub().Work(&context);
  v1::WorkerMessage message;
  *message.mutable_hello() = hello;
  stream->Write(message);
  v1::CoordinatorMessage answer;
  if (stream->Read(&answer)) tally.Doubled("worker " + hello.name() + " is let in");
  const absl::Status status = FromGrpc(stream->Finish());
  if (status.code() != absl::StatusCode::kFailedPrecondition ||
      status.message().find(why) == absl::string_view::npos) {
    tally.Lost("worker " + hello.name() + " is told: " + status.ToString());
  }
}

// The Hello of release 0.1: kinds by number (field 2, "solve" and "render"), no protocol.
v1::Hello OldHello(const std::string& name) {
  v1::Hello hello = HelloOf(name);
  hello.clear_kinds();
  hello.clear_protocol();
  hello.MergeFromString(std::string("\x12\x02\x01\x02", 4));
  return hello;
}

// And what it reported: the result in field 4, "render".
v1::CompleteRequest OldReport(const v1::AttemptId& attempt, const std::string& worker) {
  v1::CompleteRequest report;
  *report.mutable_attempt() = attempt;
  report.set_worker(worker);
  report.MergeFromString(std::string("\x22\x00", 2));
  return report;
}

// A worker of another generator would publish its own bytes under this one's keys; one of another
// protocol would not understand its jobs.
void OthersAreRefused(Farm& farm, Tally& tally) {
  v1::Hello stranger = HelloOf("stranger");
  stranger.set_build_id("generator-0");
  ExpectRefused(farm, stranger, "generator-0", tally);
  ExpectRefused(farm, OldHello("old"), "work protocol 0", tally);
}

// Loads a database that the older release wrote, from `sqlite3 queue.db .dump`.
void LoadDump(const std::string& dump, const std::string& path, Tally& tally) {
  const auto sql = ReadFile(dump);
  if (!sql.ok()) return tally.Lost(sql.status().ToString());
  sqlite3* db = nullptr;
  char* error = nullptr;
  if (sqlite3_open(path.c_str(), &db) != SQLITE_OK ||
      sqlite3_exec(db, sql->c_str(), nullptr, nullptr, &error) != SQLITE_OK) {
    tally.Lost(dump + ": " + (error != nullptr ? error : sqlite3_errmsg(db)));
  }
  sqlite3_free(error);
  sqlite3_close(db);
}

// The store of that release: its marker, and files of the sizes that the database knows.
void MakeOldStore(const std::string& db, const std::string& folder, Tally& tally) {
  JobQueueOptions options;
  options.db_path = db;
  const auto queue = JobQueue::Open(options);
  if (!queue.ok()) return tally.Lost(queue.status().ToString());
  v1::ListFramesRequest request;
  request.set_study_id(1);
  const auto frames = (*queue)->ListFrames(request);
  const auto store = OpenStore(folder);
  if (!frames.ok() || !store.ok()) return tally.Lost("the older release's store");
  for (const v1::PublishedFrame& frame : *frames) {
    for (const v1::FileEntry& file : frame.frame().files()) {
      const std::string bytes(static_cast<size_t>(file.size()), 'x');
      const absl::Status put = (*store)->Put(frame.frame().path() + "/" + file.name(), bytes);
      if (!put.ok()) tally.Lost(put.ToString());
    }
  }
}

// The database of a study that was under way: its jobs done before count, the others are done.
void OldDatabase(const std::string& dump, Tally& tally) {
  // Never read, because nobody knows any more what was in the files.
  Farm farm({.lease_s = 1, .reconnect_s = 0.2, .coordinator_arguments = {"--scrub-mb-s", "0"}});
  LoadDump(dump, farm.folder() + "/copy.db", tally);
  MakeOldStore(farm.folder() + "/copy.db", farm.store(), tally);
  LoadDump(dump, farm.folder() + "/queue.db", tally);
  farm.StartCoordinator();
  const v1::StudyStatus before = farm.Status(1);
  const int64_t wanted = before.variants(0).pairs_wanted();
  const int64_t had = before.variants(0).pairs_done();
  if (had == 0 || had >= wanted) tally.Lost("the old study is not under way");
  const auto old_frames = farm.Frames(1, tally);
  const auto worker = farm.StartWorker("new", 1);
  if (!farm.WaitForEnd(1)) {
    tally.Lost("the old study does not end: " + farm.Status(1).ShortDebugString());
  }
  const auto frames = farm.Frames(1, tally);
  if (static_cast<int64_t>(frames.size()) != wanted) {
    tally.Lost(std::to_string(frames.size()) + " of " + std::to_string(wanted) + " pairs");
  }
  for (const auto& [key, frame] : old_frames) {
    const auto found = frames.find(key);
    if (found == frames.end() || found->second.path != frame.path) {
      tally.Lost("what the older release published: " + frame.path);
    }
  }
  tally.jobs += wanted;
  tally.figures["pairs_kept_from_old_database"] += static_cast<double>(had);
  Drain(*worker, tally);
  farm.StopAndAudit(tally, "a database of the older release");
}

// An old worker and its late report, while a study runs: they are refused and change nothing.
void OldMessages(Rng rng, Tally& tally) {
  Farm farm({.lease_s = 3, .reconnect_s = 0.5});
  farm.StartCoordinator();
  const StudyShape shape{.pairs = 80};
  const int64_t study = farm.Submit(shape);
  const auto worker = farm.StartWorker("new", 5);
  for (int kill = 1; kill <= 2; ++kill) {
    farm.WaitFor(study, [&](const v1::StudyStatus& status) {
      return status.variants(0).pairs_done() >= kill * rng.UniformInt(10, 25);
    });
    OthersAreRefused(farm, tally);
    v1::AttemptId attempt;
    attempt.set_job_id(1);
    attempt.set_fence(1);
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(10));
    v1::ReportReply reply;
    const absl::Status status =
        FromGrpc(farm.stub().Complete(&context, OldReport(attempt, "old"), &reply));
    if (status.code() != absl::StatusCode::kInvalidArgument) {
      tally.Lost("an old report is answered " + status.ToString());
    }
    farm.KillCoordinator();
    ++tally.faults;
    farm.StartCoordinator();
  }
  if (!farm.WaitForEnd(study)) tally.Lost("the study does not end beside old workers");
  Drain(*worker, tally);
  farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
  farm.StopAndAudit(tally, "old messages");
}

// The older release's programs: its coordinator with old workers, then this one's in its place, in
// the middle of the study. Workers of the other protocol are refused and say why.
void OldPrograms(const std::string& bin, Rng rng, Tally& tally) {
  Farm farm({.lease_s = 5, .reconnect_s = 0.5});
  farm.SetCoordinatorProgram(bin + "/coordinator");
  farm.StartCoordinator();
  const StudyShape shape{.pairs = 200};
  const int64_t study = farm.Submit(shape);
  std::vector<std::unique_ptr<Process>> workers;
  for (int i = 0; i < 2; ++i) {
    workers.push_back(farm.StartWorker("old" + std::to_string(i), rng.UniformInt(3, 25), "", {}, 2,
                                       bin + "/noop_worker"));
  }
  const auto some = [&](int64_t pairs) {
    return
        [pairs](const v1::StudyStatus& status) { return status.variants(0).pairs_done() >= pairs; };
  };
  farm.WaitFor(study, some(rng.UniformInt(30, 80)));
  farm.KillCoordinator();
  ++tally.faults;
  farm.SetCoordinatorProgram("");
  farm.StartCoordinator();
  workers.push_back(farm.StartWorker("new", rng.UniformInt(3, 25)));
  const int64_t at_upgrade = farm.Status(study).variants(0).pairs_done();
  if (!farm.WaitForEnd(study)) tally.Lost("the study does not end after the upgrade");
  for (const auto& worker : workers) {
    // One of another release is refused and has left; its message is the user's.
    if (!worker->Running() && CountOf(worker->Err(), "the same release") > 0) {
      tally.figures["old_workers_refused"] += 1;
      continue;
    }
    Drain(*worker, tally);
    if (CountOf(worker->Err(), "job ended without a report") > 0) {
      tally.Lost("a running job was stopped by the upgrade: " + worker->Err().substr(0, 2000));
    }
  }
  tally.figures["pairs_before_upgrade"] += static_cast<double>(at_upgrade);
  farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
  farm.StopAndAudit(tally, "after the upgrade");

  // Back again is refused, and changes nothing.
  Process back({bin + "/coordinator", "serve", "--db", farm.folder() + "/queue.db", "--store",
                farm.store(), "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0"});
  const int end = back.Wait(Process::Seconds(20));
  const bool told = CountOf(back.Err(), "from the future") > 0;
  tally.figures["downgrades_refused"] += told ? 1 : 0;
  if (end == 0 || end == -1) tally.Lost("the older coordinator takes a newer database");
  if (!told) tally.Lost("the older coordinator says: " + back.Err().substr(0, 500));
  Process check({PARALLAX_COORDINATOR_PROGRAM, "check", "--db", farm.folder() + "/queue.db"});
  if (check.Wait() != 0) tally.Found({check.Out() + check.Err()}, "after a refused downgrade");
}

}  // namespace

void Versions(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "versions", round);
    if (!options.old_bin.empty()) OldPrograms(options.old_bin, rng.Child("programs"), tally);
    OldDatabase(PARALLAX_FAULTS_DATA "/queue_v1.dump", tally);
    OldMessages(rng.Child("messages"), tally);
    ++tally.rounds;
  }
}

}  // namespace parallax::faults
