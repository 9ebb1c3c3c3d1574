// Inner part of common/config: checks the values of a message, whether it came from a file, from
// options or over the network. The YAML reader only reports text that is no value of the field's
// type; every other verdict on a config or a study is made here, so that all have the same words.
//
// Each function appends its findings and goes on, so that a user sees all of them at once. `path`
// is that of the checked message and goes before the paths of its fields. Pure and thread-safe.
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

// The forms in which a distribution may be written, for messages.
extern const char kDistributionForms[];

// Returns an empty text if `text` is among `known`, else why not: "is not known, did you mean ...".
std::string WhyNotKnown(const std::string& text, const std::vector<std::string>& known,
                        const std::string& allowed);
// Checks a distribution's parameters, and all values that it can give, against the field's rule.
void CheckDistribution(const v1::Distribution& distribution, const std::string& path,
                       const v1::FieldRule& rule, Findings* findings);
// Checks every field of `message` by its rule, nested messages included. Fields that are not set
// pass: they mean their default.
void CheckFields(const google::protobuf::Message& message, const std::string& path,
                 Findings* findings);
// Checks every field of a scene config, and fields against each other.
void CheckConfig(const v1::SceneConfig& config, const std::string& path, Findings* findings);
// Checks what several baselines, ways of the rig, motion and flow allow each other.
void CheckSequences(const v1::SceneConfig& config, const std::string& path, Findings* findings);
// Checks `train` and `evaluate` of a study, and the held-out variant.
void CheckTraining(const v1::StudySpec& study, Findings* findings);
// Checks `search` of a study that has one.
void CheckSearch(const v1::StudySpec& study, Findings* findings);
// Checks `notify` of a study that has it. Findings don't quote the address.
void CheckNotify(const v1::StudySpec& study, Findings* findings);
// Checks `stream` of an endless study.
void CheckStream(const v1::StudySpec& study, Findings* findings);
// Checks a whole study. A study larger than kMaxStudyBytes has one finding only, with an empty
// path.
Findings CheckStudy(const v1::StudySpec& study);

}  // namespace parallax::config_internal
