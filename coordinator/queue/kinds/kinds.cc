#include "coordinator/queue/kinds/kinds.h"

namespace parallax {

const KindRegistry& KindRegistry::Builtin() {
  // In the order in which work flows. Never freed: others hold references.
  static const KindRegistry* registry = new KindRegistry({
      MakeSolveKind().release(),
      MakeRenderKind().release(),
      MakeTrainKind().release(),
      MakeEvaluateKind().release(),
  });
  return *registry;
}

}  // namespace parallax
