#include "coordinator/queue/ready_key.h"

#include <algorithm>

namespace parallax {

std::vector<std::string> TagLines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const size_t end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return lines;
}

ReadyKey ReadyKeyOf(int64_t study, const WorkNeeds& study_needs, const JobKind& kind,
                    const WorkNeeds& job_needs) {
  ReadyKey key{study, kind.name(), study_needs.memory_mb, study_needs.tags};
  const JobTraits& traits = kind.traits();
  key.memory_mb = std::max({key.memory_mb, traits.needs_memory_mb, job_needs.memory_mb});
  key.tags.insert(key.tags.end(), traits.needs_tags.begin(), traits.needs_tags.end());
  key.tags.insert(key.tags.end(), job_needs.tags.begin(), job_needs.tags.end());
  std::sort(key.tags.begin(), key.tags.end());
  key.tags.erase(std::unique(key.tags.begin(), key.tags.end()), key.tags.end());
  return key;
}

}  // namespace parallax
