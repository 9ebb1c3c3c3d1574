// YAML of scene configs and studies, as users write and submit them: any text ends in a message or
// an error, and what was accepted survives being written out and read again.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/config/config.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = parallax::ParseSceneConfig(text, "fuzz.yaml");
  const auto study = parallax::ParseStudy(text, "fuzz.yaml");
  (void)config;
  if (!study.ok()) return 0;
  if (const absl::Status valid = parallax::ValidateStudy(*study); !valid.ok()) {
    std::fprintf(stderr, "accepted, then not: %s\n", valid.ToString().c_str());
    std::abort();
  }
  const auto again = parallax::ParseStudy(parallax::StudyToYaml(*study), "again.yaml");
  if (!again.ok()) {
    std::fprintf(stderr, "its lock file: %s\n", again.status().ToString().c_str());
    std::abort();
  }
  return 0;
}
