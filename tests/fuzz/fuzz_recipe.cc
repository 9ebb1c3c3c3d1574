// A recipe, as a worker gets it from a coordinator or a user's file: it becomes geometry or an
// error.
#include <cstring>

#include "tests/fuzz/proto_mutator.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/upgrade.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  parallax::v1::Scene scene;
  if (!scene.ParseFromArray(data, static_cast<int>(size))) return 0;
  if (!parallax::UpgradeScene(scene).ok()) return 0;
  (void)parallax::BuildSceneGeometry(scene);
  return 0;
}

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  parallax::v1::Scene scene;
  if (seed % 8 == 0 || !scene.ParseFromArray(data, static_cast<int>(size))) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  parallax::fuzz::ProtoMutator mutator(seed);
  for (unsigned int i = 0; i <= seed % 3; ++i) mutator.Mutate(scene);
  const std::string bytes = scene.SerializeAsString();
  if (bytes.empty() || bytes.size() > max_size) return size;
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}
