#include "no_op.h"

#include "common/config/frame_files.h"
#include "tests/job_messages.h"

namespace parallax {

v1::SubmitRequest NoOpStudy(const std::string& name, uint64_t seed, int64_t scenes) {
  v1::SubmitRequest request;
  v1::StudySpec* spec = request.mutable_study();
  spec->set_name(name);
  spec->set_seed(seed);
  spec->set_pairs(scenes);
  spec->set_rigs_per_scene(1);
  v1::VariantSpec* variant = spec->add_variants();
  variant->set_name("only");
  variant->mutable_config()->mutable_rigs()->set_count(1);
  return request;
}

v1::CompleteRequest NoOpAnswer(const v1::Lease& lease, const std::string& worker) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  if (lease.kind() == "solve") {
    v1::SolveResult result;
    result.mutable_scene()->set_scene_seed(SolveOf(lease).scene_seed());
    result.mutable_scene()->add_rigs();
    result.mutable_layout()->mutable_place()->mutable_house()->add_rooms()->set_width_m(3);
    SetResult(result, request);
    return request;
  }
  v1::RenderResult result;
  const v1::RenderJob job = RenderOf(lease);
  for (const uint32_t rig : job.rigs()) {
    v1::FrameResult* frame = result.add_frames();
    frame->set_rig(rig);
    frame->set_path(lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence()) +
                    "/000");
    for (const std::string& name : FrameFileNames(job.render())) {
      v1::FileEntry* file = frame->add_files();
      file->set_name(name);
      file->set_sha256(std::string(64, 'a'));
    }
  }
  SetResult(result, request);
  return request;
}

}  // namespace parallax
