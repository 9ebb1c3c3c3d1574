// Checks `stream` of an endless study: its numbers, and the shares of its variants.
#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"

namespace parallax::config_internal {
namespace {

constexpr size_t kMostNameBytes = 50;

// Returns whether some share above 0 holds at the pair.
bool IsFed(const v1::StreamSpec& stream, int64_t pair) {
  return std::any_of(stream.mix().begin(), stream.mix().end(), [&](const v1::StreamShare& share) {
    return (!share.has_weight() || share.weight() > 0) && pair >= share.from_pair() &&
           (!share.has_until_pair() || pair < share.until_pair());
  });
}

}  // namespace

void CheckStream(const v1::StudySpec& study, Findings* findings) {
  if (!study.has_stream()) return;
  const v1::StreamSpec& stream = study.stream();
  if (study.name().size() > kMostNameBytes) {
    findings->push_back({"study", fmt::format("{} letters, allowed in an endless study are at most "
                                              "{}: its chunks have the name and a number",
                                              study.name().size(), kMostNameBytes)});
  }
  if (study.has_train() || study.has_evaluate()) {
    findings->push_back({study.has_train() ? "train" : "evaluate",
                         "beside `pairs: endless`, allowed is one of them: a stream's pairs go to "
                         "a training of your own, as they are made"});
  }
  CheckFields(stream, "stream", findings);
  std::vector<std::string> names;
  for (int i = 0; i < study.variants_size(); ++i) {
    names.push_back(study.variants(i).name());
    if (study.variants(i).pairs() == 0) continue;
    findings->push_back({fmt::format("variants[{}].pairs", i),
                         fmt::format("{}, allowed in an endless study is none: stream.mix says how "
                                     "many of its pairs are of which variant",
                                     study.variants(i).pairs())});
  }
  if (stream.mix().empty()) return;
  std::set<int64_t> starts = {0};
  for (int i = 0; i < stream.mix_size(); ++i) {
    const v1::StreamShare& share = stream.mix(i);
    const std::string path = fmt::format("stream.mix[{}]", i);
    std::string why = WhyNotKnown(share.variant(), names, "one of the study's variants");
    if (!why.empty()) findings->push_back({path + ".variant", std::move(why)});
    if (share.has_until_pair() && share.until_pair() <= share.from_pair()) {
      findings->push_back(
          {path + ".until_pair", fmt::format("{} is not after from_pair, allowed is more than {}",
                                             share.until_pair(), share.from_pair())});
    }
    if (share.has_until_pair()) starts.insert(share.until_pair());
  }
  for (const int64_t pair : starts) {
    if (IsFed(stream, pair)) continue;
    findings->push_back(
        {"stream.mix", fmt::format("no variant has a share from pair {} on, allowed is a list in "
                                   "which one has at each pair",
                                   pair)});
    return;
  }
}

}  // namespace parallax::config_internal
