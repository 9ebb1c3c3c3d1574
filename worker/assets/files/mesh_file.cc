#include "worker/assets/files/mesh_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>

#include "common/base/system/file.h"
#include "common/base/system/memory_budget.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

std::string EndingOf(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

// Makes the asset of a file's parts.
class Assembler {
 public:
  Assembler(MeshParts parts, bool z_up) : read_(std::move(parts)), z_up_(z_up) {}

  absl::StatusOr<MeshFile> Assemble() {
    RETURN_IF_ERROR(Count());
    for (const MeshPart& part : read_.parts) RETURN_IF_ERROR(Measure(part));
    RETURN_IF_ERROR(CheckExtent());
    for (MeshPart& part : read_.parts) {
      // Scanners leave vertices of no triangle without a place; PlacesOf sorts them all.
      for (Vec3d& at : part.positions) {
        if (!at.allFinite()) at.setZero();
      }
      AddNormals(part, read_.crease_deg);
      Add(part);
      part = MeshPart();
    }
    file_.mesh.texture = file_.mesh.positions;
    for (const FileMaterial& material : read_.materials) {
      MaterialSlot slot;
      slot.name = std::to_string(file_.mesh.slots.size());
      slot.families = {"plastic", "ceramic", "wood", "metal"};
      file_.mesh.slots.push_back(std::move(slot));
      file_.materials.push_back(material);
    }
    if (!IsClosed()) MakeSheets();
    file_.left_out = std::move(read_.left_out);
    RETURN_IF_ERROR(ValidateMesh(file_.mesh));
    return std::move(file_);
  }

 private:
  absl::Status Count() const {
    int64_t triangles = 0;
    for (const MeshPart& part : read_.parts) {
      triangles += static_cast<int64_t>(part.triangles.size());
    }
    if (triangles < 1 || triangles > kMostTrianglesOfAFile) {
      return InvalidArgument("{} triangles, wanted 1 to {}", triangles, kMostTrianglesOfAFile);
    }
    // Three corners of their own with all attributes, twice while they are brought together.
    constexpr int64_t kTriangleBytes = 2 * 3 * (sizeof(Vec3f) * 3 + sizeof(uint32_t));
    RETURN_IF_ERROR(
        CheckMemory(fmt::format("a mesh of {} triangles", triangles), triangles * kTriangleBytes));
    const size_t most = std::numeric_limits<uint16_t>::max();
    if (read_.materials.size() <= most) return absl::OkStatus();
    return InvalidArgument("{} materials, wanted at most {}", read_.materials.size(), most);
  }

  // Extends the box by the part's corners.
  absl::Status Measure(const MeshPart& part) {
    const size_t vertices = part.positions.size();
    for (const size_t count : {part.normals.size(), part.uv.size()}) {
      if (count == 0 || count == vertices) continue;
      return InvalidArgument("{} normals or texture coordinates of {} vertices", count, vertices);
    }
    for (const auto& t : part.triangles) {
      for (const uint32_t corner : t) {
        const Vec3d& at = part.positions[corner];
        if (!at.allFinite()) {
          return InvalidArgument("corner {} of part {} is not finite", corner,
                                 &part - read_.parts.data());
        }
        box_.extend(Turned(at));
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckExtent() {
    const double side = box_.sizes().maxCoeff();
    if (!(side > 1e-6) || !(side < std::numeric_limits<float>::max())) {
      return InvalidArgument("its longest side is {:f}, wanted more than 0", side);
    }
    double step = 0;
    for (const MeshPart& part : read_.parts) step = std::max(step, part.step);
    if (step > 1e-4 * side) {
      read_.left_out.push_back(
          fmt::format("digits of its positions below {:.2g}, for they lie far from its origin and "
                      "have 32 bits (move it to the origin before it is saved)",
                      step));
    }
    return absl::OkStatus();
  }

  // Converts from the file's axes to the asset frame's.
  template <typename Vector>
  Vector Turned(const Vector& v) const {
    return z_up_ ? Vector(-v.x(), -v.y(), v.z()) : Vector(-v.x(), v.z(), v.y());
  }

  // Adds the part's triangles with the vertices that they use, on the floor and about the origin.
  void Add(const MeshPart& part) {
    const Vec3d origin(box_.center().x(), box_.center().y(), box_.min().z());
    constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
    std::vector<uint32_t> numbers(part.positions.size(), kUnused);
    Mesh& mesh = file_.mesh;
    const auto vertex = [&](uint32_t i) {
      if (numbers[i] != kUnused) return numbers[i];
      numbers[i] = static_cast<uint32_t>(mesh.positions.size());
      const Vec3d at = Turned(part.positions[i]) - origin;
      mesh.positions.push_back(at.cast<float>() + Vec3f::Zero());  // -0 becomes 0.
      const Vec3f normal = Turned(part.normals[i]);
      const float length = normal.norm();
      mesh.normals.push_back(length > 1e-12f && std::isfinite(length) ? Vec3f(normal / length)
                                                                      : Vec3f::UnitZ());
      const bool has_uv = !part.uv.empty() && part.uv[i].allFinite();
      mesh.uv.push_back(has_uv ? part.uv[i] : Vec2f::Zero());
      return numbers[i];
    };
    for (const auto& t : part.triangles) {
      const auto slot = static_cast<uint16_t>(part.material);
      const Triangle triangle{vertex(t[0]), vertex(t[1]), vertex(t[2]), slot};
      const Vec3f &a = mesh.positions[triangle.a], &b = mesh.positions[triangle.b],
                  &c = mesh.positions[triangle.c];
      if (a != b && b != c && c != a) mesh.triangles.push_back(triangle);
    }
  }

  std::vector<uint32_t> Places() const {
    std::vector<Vec3d> positions;
    for (const Vec3f& at : file_.mesh.positions) positions.push_back(at.cast<double>());
    return PlacesOf(positions);
  }

  // Every edge is passed as often in one direction as in the other: a surface without a rim.
  bool IsClosed() const {
    const std::vector<uint32_t> places = Places();
    std::vector<std::pair<std::pair<uint32_t, uint32_t>, int>> edges;
    for (const Triangle& t : file_.mesh.triangles) {
      const uint32_t corners[3] = {places[t.a], places[t.b], places[t.c]};
      for (int k = 0; k < 3; ++k) {
        const uint32_t from = corners[k], to = corners[(k + 1) % 3];
        edges.push_back({std::minmax(from, to), from < to ? 1 : from > to ? -1 : 0});
      }
    }
    std::sort(edges.begin(), edges.end());
    int open = 0;
    for (size_t i = 0; i < edges.size(); ++i) {
      open = (i > 0 && edges[i].first == edges[i - 1].first ? open : 0) + edges[i].second;
      const bool last = i + 1 == edges.size() || edges[i + 1].first != edges[i].first;
      if (last && open != 0) return false;
    }
    return true;
  }

  // Drops all but one of the triangles with the same corners: rays must meet one only.
  void MakeSheets() {
    Mesh& mesh = file_.mesh;
    for (MaterialSlot& slot : mesh.slots) slot.sheet = true;
    const std::vector<uint32_t> places = Places();
    std::set<std::array<uint32_t, 3>> seen;
    std::erase_if(mesh.triangles, [&](const Triangle& t) {
      std::array<uint32_t, 3> corners = {places[t.a], places[t.b], places[t.c]};
      std::sort(corners.begin(), corners.end());
      return !seen.insert(corners).second;
    });
  }

  MeshParts read_;
  const bool z_up_;
  Eigen::AlignedBox3d box_;
  MeshFile file_;
};

absl::StatusOr<MeshFile> ReadAny(const std::string& bytes, const std::string& path) {
  const std::string ending = EndingOf(path);
  absl::StatusOr<MeshParts> parts = ending == ".glb"   ? ReadGlb(bytes, path)
                                    : ending == ".ply" ? ReadPly(bytes, path)
                                                       : ReadObj(bytes, path);
  RETURN_IF_ERROR(parts.status());
  return Assembler(*std::move(parts), ending == ".ply").Assemble();
}

}  // namespace

absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<MeshFile> file = ReadAny(bytes, path);
  if (file.ok()) return file;
  if (absl::IsResourceExhausted(file.status())) return WithContext(file.status(), "mesh " + path);
  return InvalidArgument("mesh {}: {}", path, ToStd(file.status().message()));
}

}  // namespace parallax
