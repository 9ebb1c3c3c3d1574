// Jobs that cost nothing but their transitions: a study of scenes with one rig, and what a worker
// answers without working.
#pragma once

#include <cstdint>
#include <string>

#include "parallax/v1/service.pb.h"

namespace parallax {

// Two jobs a scene: one solve, one render.
v1::SubmitRequest NoOpStudy(const std::string& name, uint64_t seed, int64_t scenes);
v1::CompleteRequest NoOpAnswer(const v1::Lease& lease, const std::string& worker);

}  // namespace parallax
