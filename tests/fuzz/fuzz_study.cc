// A submitted study, as the coordinator gets it from a client: refused with a reason, or taken in,
// planned, and leased, without anything in the database being out of order.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/validation.h"
#include "tests/fuzz/proto_mutator.h"

namespace {

parallax::JobQueue& Queue() {
  static std::unique_ptr<parallax::JobQueue> queue;
  static int uses = 0;
  if (queue == nullptr || ++uses > 200) {
    queue.reset();
    uses = 0;
    std::filesystem::path path = access("/dev/shm", 2) == 0 ? "/dev/shm" : "/tmp";
    path /= "parallax-fuzz-" + std::to_string(getpid()) + ".db";
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::filesystem::remove(path.string() + suffix);
    }
    parallax::JobQueueOptions options;
    options.db_path = path;
    options.scenes_ahead = 4;
    options.own_timer = false;
    options.readers = 1;
    options.linger_s = 0;
    queue = *parallax::JobQueue::Open(options);
    // Closes the queue in order when the process ends.
    static const bool registered = std::atexit([] { queue.reset(); }) == 0;
    (void)registered;
  }
  return *queue;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  parallax::v1::SubmitRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  if (!parallax::CheckSubmit(request).ok()) return 0;
  request.clear_idempotency_key();
  parallax::JobQueue& queue = Queue();
  const auto reply = queue.Submit(request, "fuzz");
  if (!reply.ok()) return 0;
  const parallax::StudyId id{reply->study_id()};
  const auto leases =
      queue.Lease({.name = "w", .kinds = {"solve", "render"}, .memory_mb = int64_t{1} << 40}, 2);
  const auto status = queue.GetStudy(id);
  if (!leases.ok() || !status.ok()) {
    std::fprintf(stderr, "%s\n%s\n", leases.status().ToString().c_str(),
                 status.status().ToString().c_str());
    std::abort();
  }
  (void)queue.Cancel(id, "fuzz", "fuzz");
  if (id.value % 50 == 0) {
    const auto violations = queue.Check();
    if (!violations.ok() || !violations->empty()) {
      std::fprintf(stderr, "%s\n", violations.ok() ? violations->front().c_str() : "no check");
      std::abort();
    }
  }
  return 0;
}

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  parallax::v1::SubmitRequest request;
  if (seed % 8 == 0 || !request.ParseFromArray(data, static_cast<int>(size))) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  parallax::fuzz::ProtoMutator mutator(seed);
  for (unsigned int i = 0; i <= seed % 3; ++i) mutator.Mutate(request);
  const std::string bytes = request.SerializeAsString();
  if (bytes.empty() || bytes.size() > max_size) return size;
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}
