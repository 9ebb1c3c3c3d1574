#include "tests/worker/assets/own_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <vector>

namespace parallax::test {
namespace {

// Corner i has the bits x, y, z of i. Counter-clockwise from outside.
constexpr std::array<std::array<int, 3>, 12> kTriangles = {{{0, 4, 6},
                                                            {0, 6, 2},
                                                            {1, 3, 7},
                                                            {1, 7, 5},
                                                            {0, 1, 5},
                                                            {0, 5, 4},
                                                            {2, 6, 7},
                                                            {2, 7, 3},
                                                            {0, 2, 3},
                                                            {0, 3, 1},
                                                            {4, 5, 7},
                                                            {4, 7, 6}}};

std::array<double, 3> Corner(int i, double x, double y, double z) {
  return {(i & 1) ? x : 0, (i & 2) ? y : 0, (i & 4) ? z : 0};
}

template <typename T>
void Append(std::string* bytes, T value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

constexpr size_t kGlbHeaderBytes = 12, kGlbChunkBytes = 8;

// A number's bytes, the lowest first, or the highest first.
template <typename T>
void AppendInOrder(std::string* bytes, T value, bool big) {
  std::string own;
  Append(&own, value);
  if (big) std::reverse(own.begin(), own.end());
  *bytes += own;
}

}  // namespace

std::string Glb(std::string json, std::string data) {
  while (json.size() % 4 != 0) json += ' ';
  while (data.size() % 4 != 0) data += '\0';
  std::string glb = "glTF";
  Append(&glb, uint32_t{2});
  Append(&glb,
         static_cast<uint32_t>(kGlbHeaderBytes + 2 * kGlbChunkBytes + json.size() + data.size()));
  Append(&glb, static_cast<uint32_t>(json.size()));
  glb += "JSON" + json;
  Append(&glb, static_cast<uint32_t>(data.size()));
  glb += std::string("BIN\0", 4) + data;
  return glb;
}

std::string GlbBox(double x, double y, double z, int faces) {
  std::string data;
  for (int i = 0; i < 8; ++i) {
    for (const double v : Corner(i, x, y, z)) Append(&data, static_cast<float>(v));
  }
  for (int t = 0; t < faces; ++t) {
    for (const int corner : kTriangles[static_cast<size_t>(t)]) {
      Append(&data, static_cast<uint16_t>(corner));
    }
  }
  std::ostringstream json;
  json
      << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      << R"("materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.8,0.2,0.1,1],)"
      << R"("metallicFactor":0.25,"roughnessFactor":0.5}}],)"
      << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
      << R"("buffers":[{"byteLength":)" << data.size() << R"(}],"bufferViews":[)"
      << R"({"buffer":0,"byteOffset":0,"byteLength":96},)"
      << R"({"buffer":0,"byteOffset":96,"byteLength":)" << 6 * faces << R"(}],"accessors":[)"
      << R"({"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[)"
      << x << "," << y << "," << z << "]},"
      << R"({"bufferView":1,"componentType":5123,"count":)" << 3 * faces
      << R"(,"type":"SCALAR"}]})";
  return Glb(json.str(), data);
}

std::string GlbWith(const std::string& glb, const std::string& from, const std::string& to) {
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + kGlbHeaderBytes, sizeof(length));
  const size_t begin = kGlbHeaderBytes + kGlbChunkBytes;
  std::string json = glb.substr(begin, length);
  json.replace(json.find(from), from.size(), to);
  return Glb(json, glb.substr(begin + length + kGlbChunkBytes));
}

std::string ObjBox(double x, double y, double z, const std::string& material) {
  std::ostringstream obj;
  if (!material.empty()) obj << "mtllib box.mtl\n";
  for (int i = 0; i < 8; ++i) {
    const auto corner = Corner(i, x, y, z);
    obj << "v " << corner[0] << " " << corner[1] << " " << corner[2] << "\n";
  }
  if (!material.empty()) {
    for (int i = 0; i < 8; ++i) obj << "vt " << (i & 1) << " " << (i >> 1 & 1) << "\n";
    obj << "usemtl " << material << "\n";
  }
  for (const auto& t : kTriangles) {
    obj << "f";
    for (const int corner : t) {
      obj << " " << corner + 1;
      if (!material.empty()) obj << "/" << corner + 1;
    }
    obj << "\n";
  }
  return obj.str();
}

// The same box with z up: the others' (x, y, z) is (x, -z, y) here.
std::string PlyBox(double x, double y, double z) {
  std::ostringstream ply;
  ply << "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      << "property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) {
    const auto corner = Corner(i, x, y, z);
    ply << corner[0] << " " << -corner[2] << " " << corner[1] << "\n";
  }
  for (const auto& t : kTriangles) ply << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
  return ply.str();
}

std::string BinaryPlyBox(double x, double y, double z, bool big) {
  std::string ply = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                    "property float z\nelement face 12\n"
                    "property list uint int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) {
    const auto corner = Corner(i, x, y, z);
    for (const double v : {corner[0], -corner[2], corner[1]}) {
      AppendInOrder(&ply, static_cast<float>(v), big);
    }
  }
  for (const auto& t : kTriangles) {
    AppendInOrder(&ply, uint32_t{3}, big);
    for (const int corner : t) AppendInOrder(&ply, int32_t{corner}, big);
  }
  return ply;
}

std::string Mtl(const std::string& material, const std::string& picture) {
  return "newmtl " + material + "\nKd 1 1 1\nmap_Kd " + picture + "\n";
}

}  // namespace parallax::test
