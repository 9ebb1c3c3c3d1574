// The kinds of jobs of this release. To add one: a file here with its class and its Make function,
// two lines below, and its handler in worker/jobs; see ../README.md.
#include <memory>

#include "coordinator/queue/job_kind.h"

namespace parallax {

std::unique_ptr<JobKind> MakeSolveKind();     // A scene's recipe from a seed and a config.
std::unique_ptr<JobKind> MakeRenderKind();    // A scene's stereo pairs.
std::unique_ptr<JobKind> MakeTrainKind();     // A network, from a training set.
std::unique_ptr<JobKind> MakeEvaluateKind();  // A network's or baseline's scores on a benchmark.

const KindRegistry& KindRegistry::Builtin() {
  // The kinds in the order in which work flows. Never freed, because others hold references.
  static const KindRegistry* registry = new KindRegistry({
      MakeSolveKind().release(),
      MakeRenderKind().release(),
      MakeTrainKind().release(),
      MakeEvaluateKind().release(),
  });
  return *registry;
}

}  // namespace parallax
