#include "no_op.h"

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
  if (lease.kind() == v1::JOB_KIND_SOLVE) {
    v1::Scene* scene = request.mutable_solve()->mutable_scene();
    scene->set_scene_seed(lease.solve().scene_seed());
    scene->add_rigs();
    request.mutable_solve()->mutable_layout()->mutable_room()->set_width_m(3);
    return request;
  }
  for (const uint32_t rig : lease.render().rigs()) {
    v1::FrameResult* frame = request.mutable_render()->add_frames();
    frame->set_rig(rig);
    frame->set_path(lease.render().store_prefix() + "/.attempt-" +
                    std::to_string(lease.attempt().fence()) + "/000");
  }
  return request;
}

}  // namespace parallax
