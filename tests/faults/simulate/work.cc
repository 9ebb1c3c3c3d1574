#include "tests/faults/simulate/work.h"

#include "tests/coordinator/queue/train_fixture.h"
#include "tests/noop/noop_kind.h"

namespace parallax::faults {

const KindRegistry& Kinds() {
  static const NoopKind* noop = new NoopKind(NoopKind::AfterPairs);
  static const KindRegistry* kinds = new KindRegistry(KindRegistry::Builtin().With(*noop));
  return *kinds;
}

WorkerFacts LivingWorker(const std::string& name) {
  WorkerFacts worker = Everyman(name);
  worker.kinds.push_back("noop");
  return worker;
}

v1::CompleteRequest AnswerOf(const v1::Lease& lease, const std::string& worker) {
  if (lease.kind() != "noop") return AnyAnswer(lease, worker);
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  request.set_kind("noop");
  request.set_result("done");
  return request;
}

}  // namespace parallax::faults
