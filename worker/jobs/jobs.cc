#include "worker/jobs/jobs.h"

namespace parallax {

JobHandlers MakeJobHandlers() {
  JobHandlers handlers;
  handlers.push_back(MakeSolveHandler());
  handlers.push_back(MakeRenderHandler());
  return handlers;
}

}  // namespace parallax
