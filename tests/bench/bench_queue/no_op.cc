#include "no_op.h"

#include <cstdio>

#include "common/config/frame_files.h"
#include "tests/job_messages.h"

namespace parallax {

v1::SubmitRequest NoOpStudy(const std::string& name, uint64_t seed, int64_t scenes, int rigs) {
  v1::SubmitRequest request;
  v1::StudySpec* spec = request.mutable_study();
  spec->set_name(name);
  spec->set_seed(seed);
  spec->set_pairs(scenes * rigs);
  spec->set_rigs_per_scene(rigs);
  v1::VariantSpec* variant = spec->add_variants();
  variant->set_name("only");
  variant->mutable_config()->mutable_rigs()->set_count(rigs);
  return request;
}

v1::CompleteRequest NoOpAnswer(const v1::Lease& lease, const std::string& worker) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  if (lease.kind() == "solve") {
    v1::SolveResult result;
    result.mutable_scene()->set_scene_seed(SolveOf(lease).scene_seed());
    const int rigs = SolveOf(lease).config().rigs().count();
    for (int rig = 0; rig < rigs; ++rig) {
      result.mutable_scene()->add_rigs()->set_index(static_cast<uint32_t>(rig));
    }
    result.mutable_layout()->mutable_place()->mutable_house()->add_rooms()->set_width_m(3);
    SetResult(result, request);
    return request;
  }
  v1::RenderResult result;
  const v1::RenderJob job = RenderOf(lease);
  const std::string folder =
      lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence());
  for (const uint32_t rig : job.rigs()) *result.add_frames() = NoOpFrame(job, rig, folder);
  SetResult(result, request);
  return request;
}

v1::FrameResult NoOpFrame(const v1::RenderJob& job, uint32_t rig, const std::string& folder) {
  v1::FrameResult frame;
  frame.set_rig(rig);
  char name[16];
  std::snprintf(name, sizeof name, "/%03u", rig);
  frame.set_path(folder + name);
  for (const std::string& file_name : FrameFileNames(job.render())) {
    v1::FileEntry* file = frame.add_files();
    file->set_name(file_name);
    file->set_sha256(std::string(64, 'a'));
  }
  return frame;
}

}  // namespace parallax
