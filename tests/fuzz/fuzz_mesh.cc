// Meshes as users bring them (.glb, .obj with its .mtl, .ply): any bytes end in a mesh that holds
// its invariants, or in an error. The first byte chooses the format; in an .obj, a 0 byte ends it
// and begins its .mtl.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/system/file.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/assets/files/mesh_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string& dir = parallax::FuzzFolder();
  if (size < 2) return 0;
  const char* const endings[] = {"glb", "obj", "ply"};
  const std::string ending = endings[data[0] % 3];
  std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (const size_t end = bytes.find('\0'); ending == "obj" && end != bytes.npos) {
    (void)parallax::WriteFile(dir + "/m.mtl", bytes.substr(end + 1));
    bytes.resize(end);
  }
  const std::string path = dir + "/mesh." + ending;
  if (!parallax::WriteFile(path, bytes).ok()) return 0;
  const auto file = parallax::ReadMeshFile(path);
  if (file.ok() && !parallax::ValidateMesh(file->mesh).ok()) {
    std::fprintf(stderr, "a mesh that is none was accepted\n");
    std::abort();
  }
  return 0;
}
