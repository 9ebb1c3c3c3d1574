#include "coordinator/rpc/reply_size.h"

#include <functional>

#include "common/base/names.h"
#include "common/rpc/message_texts.h"

namespace parallax {
namespace {

constexpr int kProblemsKept = 3;

}  // namespace

void CutTexts(google::protobuf::Message* message, size_t most) {
  ChangeTexts(message, [most](const std::string&, std::string* text) {
    if (text->size() > most) *text = CutText(*text, most);
  });
}

void FitStudy(v1::StudyStatus* study) {
  // A config whose texts are cut would be another config.
  v1::StudySpec spec;
  const bool has_spec = study->has_spec();
  if (has_spec) study->mutable_spec()->Swap(&spec);
  CutTexts(study, kMaxReasonBytes);
  if (has_spec) study->mutable_spec()->Swap(&spec);
  const std::function<void()> steps[] = {
      [&] {
        for (v1::VariantStatus& variant : *study->mutable_variants()) {
          while (variant.problems_size() > kProblemsKept) {
            variant.mutable_problems()->RemoveLast();
          }
        }
      },
      [&] { study->mutable_spec()->clear_source_yaml(); },
      [&] { study->clear_spec(); },
      [&] { study->clear_variants(); },
  };
  for (const auto& step : steps) {
    if (study->ByteSizeLong() <= kMaxReplyBytes) return;
    step();
  }
}

}  // namespace parallax
