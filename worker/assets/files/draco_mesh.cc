#include "worker/assets/files/draco_mesh.h"

#include <draco/compression/decode.h>

#include <utility>

#include "worker/assets/files/mesh_parts.h"

namespace parallax {

absl::StatusOr<DracoMesh> DracoMesh::Decode(std::string_view bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) {
    return InvalidArgument("its Draco data can't be decoded ({})", result.status().error_msg());
  }
  std::shared_ptr<const draco::Mesh> mesh = std::move(result).value();
  if (mesh->num_faces() > kMostTrianglesOfAFile || mesh->num_points() > 3 * kMostTrianglesOfAFile) {
    return InvalidArgument("{} triangles in its Draco data, wanted at most {}", mesh->num_faces(),
                           kMostTrianglesOfAFile);
  }
  for (uint32_t i = 0; i < mesh->num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(i))) {
      if (corner.value() >= mesh->num_points()) {
        return InvalidArgument("its Draco data name a corner that is not there");
      }
    }
  }
  return DracoMesh(std::move(mesh));
}

uint64_t DracoMesh::vertices() const { return mesh_->num_points(); }

std::vector<std::array<uint32_t, 3>> DracoMesh::Triangles() const {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < mesh_->num_faces(); ++i) {
    const draco::Mesh::Face& face = mesh_->face(draco::FaceIndex(i));
    triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return triangles;
}

absl::StatusOr<std::vector<double>> DracoMesh::Numbers(uint64_t id, uint64_t components) const {
  const draco::PointAttribute* attribute = mesh_->GetAttributeByUniqueId(static_cast<uint32_t>(id));
  if (attribute == nullptr || attribute->num_components() != static_cast<int>(components)) {
    return InvalidArgument("attribute {} of its Draco data is not there with {} numbers", id,
                           components);
  }
  std::vector<double> numbers(vertices() * components);
  for (uint32_t i = 0; i < vertices(); ++i) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute->size() ||
        !attribute->ConvertValue<double>(value, static_cast<int8_t>(components),
                                         &numbers[i * components])) {
      return InvalidArgument("attribute {} of its Draco data lacks vertex {}", id, i);
    }
  }
  return numbers;
}

}  // namespace parallax
