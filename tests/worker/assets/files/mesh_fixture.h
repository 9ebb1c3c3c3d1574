// Files of meshes made for tests of their readers.
#pragma once

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/assets/own_files.h"
#include "worker/assets/files/mesh_file.h"
#include "worker/materials/pictures/pbr_material.h"

namespace parallax::test {

// A picture whose colour tells its pixel: red left, green right, blue on top of both.
inline std::string Quarters() {
  ImageRgb8 image(64, 64, 0);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      image(x, y, x < 32 ? 0 : 1) = 200;
      image(x, y, 2) = y < 32 ? 200 : 0;
    }
  }
  return *EncodePng(image);
}

// Builds .glb files of one mesh.
class GlbMaker {
 public:
  // Adds numbers as an accessor and returns its place. `more`: of its JSON.
  template <typename T>
  int Add(const std::vector<T>& numbers, int type, const std::string& shape,
          const std::string& more = "") {
    const int components = shape == "SCALAR" ? 1 : shape == "MAT4" ? 16 : shape.back() - '0';
    const int view = AddView(
        std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)));
    accessors_ +=
        fmt::format(R"({}{{"bufferView":{},"componentType":{},"count":{},"type":"{}"{}}})",
                    count_ == 0 ? "" : ",", view, type,
                    numbers.size() / static_cast<size_t>(components), shape, more);
    return count_++;
  }
  int AddView(const std::string& bytes) {
    while (data_.size() % 4 != 0) data_ += '\0';
    views_json_ += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})",
                               views_ == 0 ? "" : ",", data_.size(), bytes.size());
    data_ += bytes;
    return views_++;
  }
  // `part`: the JSON of the mesh's parts; `rest`: more of the file's, with a comma at its end.
  std::string Make(const std::string& parts, const std::string& rest = "",
                   const std::string& nodes = R"({"mesh":0})") {
    return Glb(
        fmt::format(R"({{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],)"
                    R"("nodes":[{}],{}"meshes":[{{"primitives":[{}]}}],)"
                    R"("buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]}})",
                    nodes, rest, parts, data_.size(), views_json_, accessors_),
        data_);
  }

 private:
  std::string data_, views_json_, accessors_;
  int views_ = 0, count_ = 0;
};

inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                     kFloat = 5126;
inline const std::vector<float> kQuad = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
inline const std::vector<float> kQuadUv = {0, 1, 1, 1, 1, 0, 0, 0};  // v goes down.
inline const std::vector<uint16_t> kQuadCorners = {0, 1, 2, 0, 2, 3};

class MeshReadersTest : public FolderTest {
 protected:
  std::string Write(const std::string& name, const std::string& bytes) const {
    const std::string path = dir_ + "/" + name;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    EXPECT_TRUE(WriteFile(path, bytes).ok());
    return path;
  }
  MeshFile Read(const std::string& name, const std::string& bytes) const {
    const absl::StatusOr<MeshFile> file = ReadMeshFile(Write(name, bytes));
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() ? *file : MeshFile();
  }
  std::string Refusal(const std::string& name, const std::string& bytes) const {
    return std::string(ReadMeshFile(Write(name, bytes)).status().message());
  }
  // A quad with the picture, whose colour map has `info` too.
  std::string TexturedQuad(const std::string& info, const std::string& rest = "",
                           const std::string& texture = "") const {
    GlbMaker maker;
    const int at = maker.Add(kQuad, kFloat, "VEC3"), uv = maker.Add(kQuadUv, kFloat, "VEC2");
    const std::vector<float> other(8, 0.5f);
    const int uv1 = maker.Add(other, kFloat, "VEC2");
    const int corners = maker.Add(kQuadCorners, kUnsignedShort, "SCALAR");
    const int view = maker.AddView(Quarters());
    return maker.Make(
        fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{},"TEXCOORD_1":{}}},)"
                    R"("indices":{},"material":0}})",
                    at, uv, uv1, corners),
        fmt::format(R"("images":[{{"bufferView":{},"mimeType":"image/png"}}],)"
                    R"("textures":[{{"source":0{}}}],{}"materials":[{{"name":"DefaultMaterial",)"
                    R"("pbrMetallicRoughness":{{"baseColorTexture":{{"index":0{}}}}}}}],)",
                    view, texture, rest, info));
  }
};

// The colour at (u, v) of the first material: "r" left, "g" right, with "b" on top.
inline std::string ColorAt(const MeshFile& file, float u, float v) {
  SurfacePoint point;
  point.uv = {u, v};
  point.footprint_uv = 1e-4f;
  if (file.materials.empty() || !file.materials[0].looks) return "none";
  const Vec3f color =
      MakePbrMaterial(*file.materials[0].looks, PbrMapping::kUv)->Evaluate(point).base_color;
  return std::string(color.x() > color.y() ? "r" : "g") + (color.z() > 0.3f ? "b" : "");
}

}  // namespace parallax::test
