// The program `worker`: the agent with the real stages.
#include <tbb/global_control.h>

#include "worker/agent/worker_program.h"
#include "worker/jobs/jobs.h"
#include "worker/materials/user_picture.h"

int main(int argc, char** argv) {
  std::unique_ptr<tbb::global_control> threads;  // Of all jobs together.
  return parallax::RunWorkerProgram(
      argc, argv, parallax::MakeJobHandlers(), [&](const parallax::WorkerSettings& settings) {
        threads = std::make_unique<tbb::global_control>(
            tbb::global_control::max_allowed_parallelism, static_cast<size_t>(settings.threads));
        parallax::SetPictureRoot(settings.picture_root);
      });
}
