// The program `worker`: the agent with the real stages.
#include <tbb/global_control.h>

#include "common/base/system/file.h"
#include "common/base/system/memory_end.h"
#include "worker/agent/worker_program.h"
#include "worker/jobs/jobs.h"
#include "worker/jobs/offered_tags.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/user_picture.h"

int main(int argc, char** argv) {
  parallax::HoldStandardStreams();
  parallax::NameUncaughtExceptions("worker");
  std::unique_ptr<tbb::global_control> threads;  // One limit for all jobs together.
  const auto options = std::make_shared<parallax::JobOptions>();
  return parallax::RunWorkerProgram(
      argc, argv, parallax::MakeJobHandlers(options),
      [&](const parallax::WorkerSettings& settings) -> absl::StatusOr<std::vector<std::string>> {
        threads = std::make_unique<tbb::global_control>(
            tbb::global_control::max_allowed_parallelism, static_cast<size_t>(settings.threads));
        parallax::SetPictureRoot(settings.picture_root);
        parallax::SetFollowLinks(settings.follow_links);
        options->cores =
            std::make_unique<parallax::CoreShare>(settings.cores_dir, settings.threads);
        options->SetCaches(settings.cache_dir, settings.cache_bytes);
        parallax::SetContentRoot(options->content_cache.dir);
        options->benchmarks_dir = settings.benchmarks_dir;
        ASSIGN_OR_RETURN(options->trainers, parallax::InstalledTrainers::Load(
                                                settings.allowed_trainers, settings.trainers_dir));
        return parallax::AbilityTagsOf(*options);
      });
}
