// A glTF model that is being put together: buffers, meshes and nodes of our plain data. What they
// mean is up to the caller (gltf_export).
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "worker/geometry/mesh.h"
#include "worker/geometry/scene_geometry.h"

namespace parallax {

class GltfModel {
 public:
  // Begins with the node "z_up", which turns z up into glTF's y up.
  GltfModel();

  // Adds a node below "z_up".
  void AddNode(tinygltf::Node node);
  // Adds a mesh whose slot i has materials[material_of_slot[i]], where there is one. Equal `mesh`
  // pointers share their vertices. Returns its index.
  int AddMesh(const std::string& name, const Mesh& mesh,
              const std::vector<uint32_t>& material_of_slot,
              const std::map<uint32_t, int>& materials);
  // Sets linear RGB colours of a mesh's vertices, by which its materials' colours are multiplied.
  void SetColors(int mesh, const std::vector<Vec3f>& colors);
  // Adds a node that draws a mesh at each of the instances (EXT_mesh_gpu_instancing). The custom
  // attribute _OBJECT_INDEX has their object indices. The instances must be turned, equally scaled
  // and moved.
  void AddInstances(const std::string& name, int mesh,
                    const std::vector<const Instance*>& instances);
  // Notes that the model uses an extension; `required`: it is wrong without.
  void Use(const std::string& extension, bool required = false);

  tinygltf::Model& model() { return model_; }
  int64_t triangles() const { return triangles_; }  // Different ones.

 private:
  // The accessors of a mesh.
  struct Vertices {
    int positions = -1, normals = -1;
    std::map<uint16_t, int> indices;  // By slot.
  };
  const Vertices& VerticesOf(const Mesh& mesh);
  // Appends `count` elements of `bytes_each` bytes to the buffer. Returns their accessor.
  // `component`, `type` and `target` are glTF's; target 0 is none.
  int AddAccessor(const void* data, size_t count, size_t bytes_each, int component, int type,
                  int target);
  // Appends one vector for each vertex of a mesh.
  int AddVertexVectors(const std::vector<Vec3f>& vectors);
  int AddFloats(const float* data, size_t count, size_t floats_each, int target);

  tinygltf::Model model_;
  int64_t triangles_ = 0;
  std::map<const Mesh*, Vertices> vertices_;
};

}  // namespace parallax
