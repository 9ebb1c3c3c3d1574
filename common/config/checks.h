// Inner part of common/config: what is wrong with the values of a message, whether it came from a
// file, from options or over the network. The YAML reader tells only of text that has no value of
// the field's type; every other verdict on a config or a study is made here, in the same words.
//
// Pure and thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "parallax/v1/study.pb.h"

namespace parallax::config_internal {

// One wrong value: "variants[0].config.rigs.width_px" and "-5 is out of range, allowed ...".
struct Finding {
  std::string path;
  std::string what;
};
using Findings = std::vector<Finding>;

// The forms of a distribution, for messages.
extern const char kDistributionForms[];

// Values of a distribution field with this rule.
void CheckDistribution(const v1::Distribution& distribution, const std::string& path,
                       const v1::FieldRule& rule, Findings* findings);
// Every field of `message` by its rule, nested messages included. Fields without value pass: they
// stand for their default.
void CheckFields(const google::protobuf::Message& message, const std::string& path,
                 Findings* findings);
// The fields, and what one field allows another.
void CheckConfig(const v1::SceneConfig& config, const std::string& path, Findings* findings);
// What several baselines, ways of the rig, motion and flow allow each other.
void CheckSequences(const v1::SceneConfig& config, const std::string& path, Findings* findings);
// `train` and `evaluate` of a study, and the variant that is held out.
void CheckTraining(const v1::StudySpec& study, Findings* findings);
// The whole study. A study larger than kMaxStudyBytes has this one finding, with an empty path.
Findings CheckStudy(const v1::StudySpec& study);

}  // namespace parallax::config_internal
