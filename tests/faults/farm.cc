#include "tests/faults/farm.h"

#include <grpcpp/grpcpp.h>
#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/store/http_client.h"
#include "tests/job_messages.h"

namespace parallax::faults {
namespace {

using Clock = std::chrono::steady_clock;

// Time in which all of us were frozen (a suspended machine) counts as one look.
constexpr double kLongestLook_s = 6;

[[noreturn]] void Abandon(const std::string& why) {
  std::fprintf(stderr, "the experiment can't go on: %s\n", why.c_str());
  std::exit(3);
}

// Calls until it is answered.
template <typename Call>
void Insist(const char* what, const Call& call) {
  double waited_s = 0;
  absl::Status status;
  do {
    const auto begin = Clock::now();
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(5));
    context.set_wait_for_ready(true);
    status = FromGrpc(call(context));
    if (status.ok()) return;
    Sleep(0.01);
    waited_s += std::min(SecondsSince(begin), kLongestLook_s);
  } while (waited_s < 60);
  Abandon(std::string(what) + ": " + status.ToString());
}

}  // namespace

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}
void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }
int CountOf(const std::string& text, const std::string& what) {
  int count = 0;
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++count;
  return count;
}

void Drain(Process& worker, Tally& tally, bool may_hand_back) {
  worker.Signal(SIGTERM);
  const int end = worker.Wait(Process::Seconds(20));
  if (end != 0 && !(may_hand_back && end == 4)) {
    tally.Lost("a worker ended with " + std::to_string(end) + ": " + worker.Err().substr(0, 4000));
  }
}

Farm::Farm(const FarmOptions& options) : options_(options), folder_(options.memory) {}

const std::string& Farm::StartCoordinator(const std::vector<std::string>& environment) {
  const std::string listen = address_.empty() ? "127.0.0.1:0" : address_;
  const std::string http = http_.empty() ? "127.0.0.1:0" : http_;
  std::string line;
  // Its port may still be in the hands of the one just killed.
  for (starts_ = 1; starts_ <= 50; ++starts_) {
    std::vector<std::string> command = {program_.empty() ? PARALLAX_COORDINATOR_PROGRAM : program_,
                                        "serve",
                                        "--db",
                                        folder() + "/queue.db",
                                        "--store",
                                        store(),
                                        "--listen",
                                        listen,
                                        "--http",
                                        http,
                                        "--lease-s",
                                        std::to_string(options_.lease_s),
                                        "--reconnect-s",
                                        std::to_string(options_.reconnect_s)};
    if (options_.backoff_s > 0) {
      command.insert(command.end(), {"--backoff-s", std::to_string(options_.backoff_s)});
    }
    command.insert(command.end(), options_.coordinator_arguments.begin(),
                   options_.coordinator_arguments.end());
    std::vector<std::string> variables = options_.coordinator_environment;
    if (starts_ == 1) variables.insert(variables.end(), environment.begin(), environment.end());
    coordinator_ = std::make_unique<Process>(command, variables);
    const std::string said = "listening on ";
    if (coordinator_->ReadLine(&line) && line.rfind(said, 0) == 0) {
      address_ = line.substr(said.size());
      if (coordinator_->ReadLine(&line) && line.rfind("http on http://", 0) == 0) {
        http_ = line.substr(15, line.size() - 16);
        if (stub_ == nullptr) {
          stub_ = v1::Coordinator::NewStub(*ConnectRpc(*ParseRpcAddress(address_), {}));
        }
        return address_;
      }
    }
    Sleep(0.05);
  }
  Abandon("the coordinator does not start: " + coordinator_->Err());
}

void Farm::KillCoordinator() {
  coordinator_->Signal(SIGKILL);
  coordinator_->Wait();
}

std::unique_ptr<Process> Farm::StartWorker(const std::string& name, int job_ms,
                                           const std::string& address,
                                           std::vector<std::string> environment, int slots,
                                           const std::string& program,
                                           const std::vector<std::string>& more) {
  environment.push_back("PARALLAX_NOOP_MS=" + std::to_string(job_ms));
  std::vector<std::string> command = {program.empty() ? PARALLAX_NOOP_WORKER_PROGRAM : program,
                                      "--role",
                                      "all",
                                      "--coordinator",
                                      address.empty() ? address_ : address,
                                      "--slots",
                                      std::to_string(slots),
                                      "--name",
                                      name,
                                      "--outbox",
                                      folder() + "/outbox"};
  command.insert(command.end(), more.begin(), more.end());
  return std::make_unique<Process>(command, environment);
}

std::vector<v1::JobStatus> Farm::Jobs(const v1::ListJobsRequest& request) {
  v1::ListJobsReply reply;
  Insist("jobs",
         [&](grpc::ClientContext& context) { return stub_->ListJobs(&context, request, &reply); });
  return {reply.jobs().begin(), reply.jobs().end()};
}

int64_t Farm::Submit(const StudyShape& shape) {
  v1::SubmitRequest request;
  request.set_idempotency_key(shape.name);
  v1::StudySpec& study = *request.mutable_study();
  study.set_name(shape.name);
  study.set_seed(shape.seed);
  study.set_pairs(shape.pairs);
  study.set_rigs_per_scene(shape.rigs_per_scene);
  study.set_priority(shape.priority);
  study.add_variants()->set_name("v");
  study.mutable_variants(0)->mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
  study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(shape.rigs_per_scene);
  v1::SubmitReply reply;
  Insist("submit",
         [&](grpc::ClientContext& context) { return stub_->Submit(&context, request, &reply); });
  return reply.study_id();
}

int64_t Farm::SubmitFile(const std::string& yaml) {
  const std::string path = folder() + "/study.yaml";
  std::ofstream(path) << yaml;
  Process client({PARALLAX_CLIENT_PROGRAM, "submit", path, "--coordinator", address_, "--json"});
  if (client.Wait() != 0) {
    std::fprintf(stderr, "parallax submit: %s\n", client.Err().c_str());
    return 0;
  }
  return nlohmann::json::parse(client.Out(), nullptr, false).value("study_id", int64_t{0});
}

v1::StudyStatus Farm::Status(int64_t study) {
  v1::GetStudyRequest request;
  request.set_study_id(study);
  v1::StudyStatus status;
  Insist("status",
         [&](grpc::ClientContext& context) { return stub_->GetStudy(&context, request, &status); });
  return status;
}

bool Farm::WaitFor(int64_t study, const std::function<bool(const v1::StudyStatus&)>& condition,
                   double limit_s) {
  double waited_s = 0;
  auto last = Clock::now();
  while (!condition(Status(study))) {
    waited_s += std::min(SecondsSince(last), kLongestLook_s);
    last = Clock::now();
    if (waited_s > limit_s) return false;
    Sleep(0.01);
  }
  return true;
}

bool Farm::WaitForEnd(int64_t study, double limit_s) {
  return WaitFor(
      study,
      [](const v1::StudyStatus& status) { return status.state() == v1::STUDY_STATE_SUCCEEDED; },
      limit_s);
}

double Farm::Metric(const std::string& name) {
  const HttpAnswer answer =
      HttpClient(HttpFarm()).Send({.method = "GET", .url = "http://" + http_ + "/metrics"});
  if (answer.code != 200) return -1;
  const size_t at = answer.body.find("\n" + name + " ");
  return at == std::string::npos ? -1 : std::atof(answer.body.c_str() + at + name.size() + 2);
}

std::map<std::tuple<std::string, uint32_t, uint32_t>, Farm::Published> Farm::Frames(int64_t study,
                                                                                    Tally& tally) {
  std::map<std::tuple<std::string, uint32_t, uint32_t>, Published> frames;
  v1::ListFramesRequest request;
  request.set_study_id(study);
  request.set_limit(1000);
  while (true) {
    v1::ListFramesReply reply;
    Insist("frames", [&](grpc::ClientContext& context) {
      return stub_->ListFrames(&context, request, &reply);
    });
    if (reply.frames().empty()) return frames;
    for (const v1::PublishedFrame& frame : reply.frames()) {
      Published published;
      published.path = frame.frame().path();
      for (const v1::FileEntry& file : frame.frame().files()) {
        published.sha256[file.name()] = file.sha256();
      }
      if (!frames
               .emplace(std::tuple(frame.variant(), frame.scene(), frame.frame().rig()), published)
               .second) {
        tally.Doubled("scene " + std::to_string(frame.scene()) + ", rig " +
                      std::to_string(frame.frame().rig()));
      }
      request.set_cursor(frame.cursor());
    }
  }
}

void Farm::CheckPairs(int64_t study, size_t pairs, Tally& tally) {
  const auto frames = Frames(study, tally);
  if (frames.size() != pairs) {
    tally.Lost(std::to_string(frames.size()) + " of " + std::to_string(pairs) + " pairs");
  }
  for (const auto& [key, frame] : frames) {
    for (const auto& [name, sha256] : frame.sha256) {
      const auto bytes = ReadFile(store() + "/" + frame.path + "/" + name);
      if (!bytes.ok() || Sha256Hex(*bytes) != sha256) {
        tally.Lost("published file " + frame.path + "/" + name);
      }
    }
  }
  const v1::StudyStatus status = Status(study);
  for (const v1::VariantStatus& variant : status.variants()) {
    tally.jobs += JobsOf(variant, "", "SUCCEEDED");
  }
}

void Farm::StopAndAudit(Tally& tally, const std::string& where) {
  coordinator_->Signal(SIGTERM);
  const int end = coordinator_->Wait(Process::Seconds(20));
  if (end != 0) {
    const std::string log = coordinator_->Err();
    tally.Lost("the coordinator ended with " + std::to_string(end) + ": " +
               log.substr(log.size() - std::min<size_t>(log.size(), 1000)));
  }
  Process check({PARALLAX_COORDINATOR_PROGRAM, "check", "--db", folder() + "/queue.db"});
  if (check.Wait() != 0) tally.Found({check.Out() + check.Err()}, where);
}

}  // namespace parallax::faults
