// Meshes that Draco has compressed. Thread-safe.   Source: KHR_draco_mesh_compression.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace draco {
class Mesh;
}

namespace parallax {

class DracoMesh {
 public:
  // Errors: kInvalidArgument saying what Draco says.
  static absl::StatusOr<DracoMesh> Decode(std::string_view bytes);

  uint64_t vertices() const;
  // All below `vertices`.
  std::vector<std::array<uint32_t, 3>> Triangles() const;
  // The attribute with this id, `components` numbers a vertex. Errors: kInvalidArgument if there is
  // none, or it has other components.
  absl::StatusOr<std::vector<double>> Numbers(uint64_t id, uint64_t components) const;

 private:
  explicit DracoMesh(std::shared_ptr<const draco::Mesh> mesh) : mesh_(std::move(mesh)) {}
  std::shared_ptr<const draco::Mesh> mesh_;
};

}  // namespace parallax
