// Jobs that cost nothing but their transitions: a study, and the answers of a worker that does not
// work.
#pragma once

#include <cstdint>
#include <string>

#include "parallax/v1/service.pb.h"

namespace parallax {

// Two jobs a scene: one solve, one render of all `rigs`, which publishes as many pairs.
v1::SubmitRequest NoOpStudy(const std::string& name, uint64_t seed, int64_t scenes, int rigs = 1);
v1::CompleteRequest NoOpAnswer(const v1::Lease& lease, const std::string& worker);
// The frame of one rig in an attempt's folder, with all the files that the job wants.
v1::FrameResult NoOpFrame(const v1::RenderJob& job, uint32_t rig, const std::string& folder);

}  // namespace parallax
