// Experiments 3, 4 and 5: faults of whole daemons and of the network between them.
#include <grpcpp/grpcpp.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/queue/job_queue.h"
#include "tests/faults/farm.h"
#include "tests/faults/tcp_proxy.h"
#include "tests/job_messages.h"

namespace parallax::faults {
namespace {

using SteadyClock = std::chrono::steady_clock;

bool PairsDone(const v1::StudyStatus& status, int64_t pairs) {
  return status.variants(0).pairs_done() >= pairs;
}

int64_t JobsIn(const v1::StudyStatus& status, const std::string& state) {
  int64_t n = 0;
  for (const v1::VariantStatus& variant : status.variants()) {
    n += JobsOf(variant, "", state);
  }
  return n;
}

// These are faults of the network and the machines, so no job may be blamed for them.
void CheckNobodyBlamed(const v1::StudyStatus& status, Tally& tally) {
  for (const char* state : {"FAILED", "QUARANTINED"}) {
    const int64_t jobs = JobsIn(status, state);
    if (jobs > 0) tally.Lost(std::to_string(jobs) + " good jobs are " + state);
  }
}

}  // namespace

// ---- 3: kill -9 of the coordinator
namespace {

// Fills the database with jobs before its coordinator starts.
void MakeRows(const std::string& db, int64_t rows, Tally& tally) {
  JobQueueOptions options;
  options.db_path = db;
  options.scenes_ahead = static_cast<int>(rows);
  auto queue = JobQueue::Open(options);
  if (!queue.ok()) return tally.Lost(queue.status().ToString());
  v1::SubmitRequest request;
  v1::StudySpec& study = *request.mutable_study();
  study.set_name("bulk");
  study.set_seed(9);
  study.set_pairs(rows);
  study.set_rigs_per_scene(1);
  study.add_variants()->set_name("v");
  study.mutable_variants(0)->mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
  study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(1);
  const auto reply = (*queue)->Submit(request, "faults");
  if (!reply.ok()) return tally.Lost(reply.status().ToString());
  int64_t made = 0;
  while (made < rows) {
    Sleep(0.2);
    const auto status = (*queue)->GetStudy(StudyId{reply->study_id()});
    if (!status.ok()) return tally.Lost(status.status().ToString());
    made = JobsIn(*status, "READY");
  }
}

}  // namespace

void KillCoordinator(const ExperimentOptions& options, Tally& tally) {
  double worst_s = 0;
  double adopted = 0;
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "kill-coordinator", round);
    Farm farm({.lease_s = 8, .memory = options.rows == 0});
    if (options.rows > 0) MakeRows(farm.folder() + "/queue.db", options.rows, tally);
    farm.StartCoordinator();
    const StudyShape shape{.pairs = options.jobs > 0 ? options.jobs / 2 : 120, .priority = 5};
    const int64_t study = farm.Submit(shape);
    std::vector<std::unique_ptr<Process>> workers;
    for (int i = 0; i < 3; ++i) {
      workers.push_back(farm.StartWorker("w" + std::to_string(i), rng.UniformInt(5, 60)));
    }
    const int kills = rng.UniformInt(2, 4);
    for (int kill = 0; kill < kills; ++kill) {
      const double after_s = rng.Uniform(0.02, 0.5);
      const auto begin = SteadyClock::now();
      const int64_t goal = shape.pairs * (kill + 1) / (kills + 2);
      farm.WaitFor(study, [&](const v1::StudyStatus& status) { return PairsDone(status, goal); });
      Sleep(std::max(0.0, after_s - SecondsSince(begin)));
      farm.KillCoordinator();
      ++tally.faults;
      const auto restart = SteadyClock::now();
      farm.StartCoordinator();
      while (farm.Metric("parallax_leases_total") < 1 && SecondsSince(restart) < 30 &&
             !PairsDone(farm.Status(study), shape.pairs)) {
        Sleep(0.005);
      }
      worst_s = std::max(worst_s, SecondsSince(restart));
    }
    if (worst_s > 5) {
      tally.Lost(std::to_string(worst_s) + " s from the restart to the first lease");
    }
    if (!farm.WaitForEnd(study, 120)) tally.Lost("the study does not end");
    CheckNobodyBlamed(farm.Status(study), tally);
    for (const auto& worker : workers) {
      Drain(*worker, tally, /*may_hand_back=*/options.rows > 0);
      const std::string log = worker->Err();
      const int aborted = CountOf(log, "job ended without a report");
      if (aborted > 0) {
        tally.Lost(std::to_string(aborted) + " running jobs were stopped by a restart");
      }
      const std::string said = "adopted=";
      for (size_t at = 0; (at = log.find(said, at)) != std::string::npos;) {
        adopted += std::atoi(log.c_str() + (at += said.size()));
      }
    }
    farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
    farm.StopAndAudit(tally, "kill-coordinator, round " + std::to_string(round));
    ++tally.rounds;
  }
  tally.figures["restart_to_first_lease_s_max"] = worst_s;
  tally.figures["attempts_adopted"] = adopted;
}

// ---- 3b: finished, and nobody to tell
namespace {

// Jobs whose reports wait in any outbox of the farm: <coordinator>-<job>-<fence>.complete
std::set<int64_t> JobsInOutboxes(const Farm& farm) {
  std::set<int64_t> jobs;
  std::error_code error;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(farm.folder() + "/outbox", error)) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".complete") continue;
    jobs.insert(std::atoll(name.c_str() + name.find('-') + 1));
  }
  return jobs;
}

}  // namespace

void Outboxes(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "outbox", round);
    Farm farm({.lease_s = 10, .reconnect_s = 5});
    farm.StartCoordinator();
    const StudyShape shape{.pairs = 12};
    const int64_t study = farm.Submit(shape);
    auto first = farm.StartWorker("first", 150, "", {}, 3);
    farm.WaitFor(study, [&](const v1::StudyStatus& status) { return PairsDone(status, 4); });
    Sleep(rng.Uniform(0, 0.15));
    farm.KillCoordinator();
    std::set<int64_t> finished;
    for (int i = 0; finished.empty() && i < 500; ++i) {
      Sleep(0.01);
      finished = JobsInOutboxes(farm);
    }
    if (finished.empty()) tally.Lost("nothing was finished while the coordinator was away");
    first->Signal(SIGKILL);
    first->Wait();
    finished = JobsInOutboxes(farm);
    tally.faults += 2;
    farm.StartCoordinator();
    const auto second = farm.StartWorker("second", 3);
    if (!farm.WaitForEnd(study)) tally.Lost("the study does not end");
    v1::ListJobsRequest request;
    request.set_study_id(study);
    request.set_state("SUCCEEDED");
    for (const v1::JobStatus& job : farm.Jobs(request)) {
      if (finished.count(job.job_id()) != 0 && job.attempts() != 1) {
        tally.Lost("finished work of job " + std::to_string(job.job_id()) + ", which was done " +
                   std::to_string(job.attempts()) + " times");
      }
    }
    tally.figures["reports_that_outlived_their_worker"] += static_cast<double>(finished.size());
    Drain(*second, tally);
    farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
    farm.StopAndAudit(tally, "outbox, round " + std::to_string(round));
    ++tally.rounds;
  }
}

// ---- 4: lost replies
void LostReplies(const ExperimentOptions& options, Tally& tally) {
  double replies = 0;
  double lost = 0;
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "lost-replies", round);
    Farm farm({.lease_s = 3, .reconnect_s = 1});
    farm.StartCoordinator();
    TcpProxy proxy(farm.address(), {.unary = 0.2, .stream = 0.05}, rng.Bits64());
    const auto stub = v1::Coordinator::NewStub(*ConnectRpc(*ParseRpcAddress(proxy.address()), {}));
    // A client's calls through the same bad weather.
    const auto insist = [&](auto call) {
      const auto begin = SteadyClock::now();
      while (SecondsSince(begin) < 60) {
        grpc::ClientContext context;
        SetRpcTimeout(context, std::chrono::seconds(5));
        context.set_wait_for_ready(true);
        if (call(context).ok()) return;
        Sleep(0.005);
      }
      tally.Lost("a call was never answered");
    };
    const StudyShape shape{.pairs = options.jobs > 0 ? options.jobs / 2 : 120};
    const int64_t study = farm.Submit(shape);
    std::vector<std::unique_ptr<Process>> workers;
    for (int i = 0; i < 3; ++i) {
      workers.push_back(
          farm.StartWorker("w" + std::to_string(i), rng.UniformInt(1, 15), proxy.address()));
    }
    for (int i = 0; i < 20; ++i) {
      v1::SubmitRequest submit;
      submit.set_idempotency_key("side" + std::to_string(i));
      submit.mutable_study()->set_name("side");
      submit.mutable_study()->set_seed(77);
      submit.mutable_study()->set_pairs(2);
      submit.mutable_study()->set_rigs_per_scene(1);
      submit.mutable_study()->add_variants()->set_name("v");
      submit.mutable_study()->mutable_variants(0)->mutable_config()->set_type(
          v1::SCENE_TYPE_INDOOR);
      v1::SubmitReply submitted;
      insist([&](auto& context) { return stub->Submit(&context, submit, &submitted); });
      v1::StudyRequest request;
      request.set_study_id(submitted.study_id());
      v1::StudyStatus status;
      insist([&](auto& context) { return stub->Pause(&context, request, &status); });
      insist([&](auto& context) { return stub->Resume(&context, request, &status); });
      v1::RetryReply retried;
      insist([&](auto& context) { return stub->Retry(&context, request, &retried); });
      if (i % 2 == 0) {
        insist([&](auto& context) {
          const grpc::Status answer = stub->Cancel(&context, request, &status);
          const bool ended = answer.error_code() == grpc::StatusCode::FAILED_PRECONDITION;
          return ended ? grpc::Status::OK : answer;
        });
      }
    }
    if (!farm.WaitForEnd(study, 90)) tally.Lost("the study does not end");
    CheckNobodyBlamed(farm.Status(study), tally);
    v1::ListStudiesReply all;
    insist([&](auto& context) {
      v1::ListStudiesRequest request;
      request.set_limit(100);
      return stub->ListStudies(&context, request, &all);
    });
    if (all.studies_size() != 21) {
      tally.Doubled(std::to_string(all.studies_size()) + " studies of 21 submitted");
    }
    for (const auto& worker : workers) Drain(*worker, tally);
    farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
    farm.StopAndAudit(tally, "lost-replies, round " + std::to_string(round));
    const TcpProxy::Counts counts = proxy.counts();
    replies += static_cast<double>(counts.replies);
    lost += static_cast<double>(counts.lost);
    tally.faults += counts.lost;
    if (counts.lost == 0) tally.Lost("no reply was lost: the experiment shows nothing");
    ++tally.rounds;
  }
  tally.figures["replies"] = replies;
  tally.figures["replies_lost"] = lost;
}

// ---- 5: bad networks
void Partitions(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "partitions", round);
    Farm farm({.lease_s = 1, .reconnect_s = 0.3});
    farm.StartCoordinator();
    const StudyShape shape{.pairs = options.jobs > 0 ? options.jobs / 2 : 100};
    const int64_t study = farm.Submit(shape);
    std::vector<std::unique_ptr<TcpProxy>> proxies;
    std::vector<std::unique_ptr<Process>> workers;
    for (int i = 0; i < 3; ++i) {
      proxies.push_back(std::make_unique<TcpProxy>(farm.address(), LossRates{}, rng.Bits64()));
      workers.push_back(farm.StartWorker("w" + std::to_string(i), rng.UniformInt(5, 60),
                                         proxies.back()->address()));
    }
    const auto begin = SteadyClock::now();
    while (SecondsSince(begin) < 5) {
      TcpProxy& proxy = *proxies[static_cast<size_t>(rng.UniformInt(0, 2))];
      switch (rng.UniformInt(0, 5)) {
        case 0:
          proxy.Set(Weather::kStall);
          break;
        case 1:
          proxy.Set(Weather::kDeafUp);
          break;
        case 2:
          proxy.Set(Weather::kDeafDown);
          break;
        case 3:
          proxy.Set(Weather::kPartition);
          break;
        case 4:
          proxy.CutAll();
          break;
        default:
          proxy.Set(Weather::kClear);
          break;
      }
      ++tally.faults;
      Sleep(rng.Uniform(0.02, 0.6));
    }
    for (const auto& proxy : proxies) proxy->Set(Weather::kClear);
    if (!farm.WaitForEnd(study, 60)) tally.Lost("the study does not end");
    // A worker that finishes under a lease that it lost is answered STALE_FENCE: nobody's failure.
    if (const int64_t failed = JobsIn(farm.Status(study), "FAILED"); failed > 0) {
      tally.Lost(std::to_string(failed) + " good jobs are FAILED");
    }
    for (const auto& worker : workers) Drain(*worker, tally);
    farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
    farm.StopAndAudit(tally, "partitions, round " + std::to_string(round));
    for (const auto& proxy : proxies) {
      tally.figures["connections_cut"] += static_cast<double>(proxy->counts().cut);
    }
    ++tally.rounds;
  }
}

}  // namespace parallax::faults
