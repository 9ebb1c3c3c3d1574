#include "worker/assets/files/glb_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/assets/files/glb_chunks.h"
#include "worker/assets/files/mesh_file.h"

namespace parallax {
namespace {

using Json = nlohmann::json;

constexpr int kDeepestNode = 256;
constexpr uint64_t kMostNumber = std::numeric_limits<int32_t>::max();
constexpr uint64_t kMostTriangles = kMostTrianglesOfAFile;
constexpr uint64_t kMostCorners = 3 * kMostTriangles;

// ---- Entries of its lists

// An object of the JSON, with its name for messages: "accessor 3".
struct Entry {
  const Json& json;
  std::string name;

  bool Has(const char* key) const { return json.contains(key); }
  absl::StatusOr<uint64_t> Whole(const char* key) const {
    const auto found = json.find(key);
    if (found != json.end() && found->is_number_unsigned() &&
        found->get<uint64_t>() <= kMostNumber) {
      return found->get<uint64_t>();
    }
    return InvalidArgument("{}: {} is {}, wanted a whole number from 0 to {}", name, key,
                           found == json.end() ? "missing" : "something else", kMostNumber);
  }
  absl::StatusOr<uint64_t> WholeOr(const char* key, uint64_t otherwise) const {
    if (!Has(key)) return otherwise;
    return Whole(key);
  }
};

// Returns the objects in the list `key` of `parent`; none where it has no such list.
absl::StatusOr<std::vector<Entry>> EntriesOf(const Entry& parent, const char* key,
                                             const std::string& name) {
  std::vector<Entry> entries;
  const auto found = parent.json.find(key);
  if (found == parent.json.end()) return entries;
  if (!found->is_array()) return InvalidArgument("{}{} is no list", parent.name, key);
  for (const Json& json : *found) {
    entries.push_back({json, fmt::format("{}{} {}", parent.name, name, entries.size())});
    if (!json.is_object()) return InvalidArgument("{} is no object", entries.back().name);
  }
  return entries;
}

// Returns the whole numbers below `end` in the list `key`; none where the entry has no such list.
absl::StatusOr<std::vector<size_t>> PlacesOf(const Entry& entry, const char* key, size_t end) {
  std::vector<size_t> places;
  const auto found = entry.json.find(key);
  if (found == entry.json.end()) return places;
  for (const Json& place : *found) {
    if (!place.is_number_unsigned() || place.get<uint64_t>() >= end) {
      return InvalidArgument("{}: {} names something that is not there", entry.name, key);
    }
    places.push_back(place.get<size_t>());
  }
  return places;
}

// ---- Data

struct View {
  uint64_t begin = 0, bytes = 0;  // In the buffer.
  uint64_t stride = 0;            // 0: as the elements are large.
};

struct Accessor {
  std::optional<size_t> view;  // Empty: zeros, or compressed data.
  uint64_t offset = 0, count = 0;
  uint64_t component_bytes = 0, element_bytes = 0, stride = 0;
  bool is_index = false;  // One unsigned integer each.
};

absl::StatusOr<uint64_t> ComponentBytes(const Entry& entry) {
  ASSIGN_OR_RETURN(const uint64_t type, entry.Whole("componentType"));
  if (type == 5120 || type == 5121) return 1;
  if (type == 5122 || type == 5123) return 2;
  if (type == 5125 || type == 5126) return 4;
  return InvalidArgument("{}: componentType {}, wanted one of 5120 to 5126", entry.name, type);
}

absl::StatusOr<uint64_t> Components(const Entry& entry) {
  const std::pair<const char*, uint64_t> types[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  for (const auto& [name, count] : types) {
    if (entry.Has("type") && entry.json["type"] == name) return count;
  }
  return InvalidArgument("{}: type is none of SCALAR, VEC2 to VEC4 and MAT2 to MAT4", entry.name);
}

// Triangles and corners of a mesh, or of many.
struct Amount {
  uint64_t triangles = 0, corners = 0;

  // Adds `more`. Errors: kInvalidArgument if it is too much.
  absl::Status Add(const Amount& more) {
    triangles += more.triangles;
    corners += more.corners;
    if (triangles <= kMostTriangles && corners <= kMostCorners) return absl::OkStatus();
    return InvalidArgument("{} triangles with {} corners or more, wanted at most {} with {}",
                           triangles, corners, kMostTriangles, kMostCorners);
  }
};

class Checker {
 public:
  Checker(const Json& json, std::string_view body) : root_{json, ""}, body_(body) {}

  absl::Status Check() {
    RETURN_IF_ERROR(CheckBuffers());
    RETURN_IF_ERROR(CheckViews());
    RETURN_IF_ERROR(CheckAccessors());
    RETURN_IF_ERROR(CheckMeshes());
    RETURN_IF_ERROR(CheckNodes());
    RETURN_IF_ERROR(CheckSkins());
    return CheckAnimations();
  }

 private:
  absl::Status CheckBuffers() {
    ASSIGN_OR_RETURN(const std::vector<Entry> buffers, EntriesOf(root_, "buffers", "buffer"));
    if (buffers.empty()) return absl::OkStatus();
    if (buffers.size() > 1 || buffers[0].Has("uri")) {
      return InvalidArgument("its data lie in {}, wanted one buffer inside of the .glb",
                             buffers.size() > 1 ? "several buffers" : "another file");
    }
    ASSIGN_OR_RETURN(buffer_bytes_, buffers[0].Whole("byteLength"));
    if (buffer_bytes_ <= body_.size()) return absl::OkStatus();
    return InvalidArgument("buffer 0 has {} bytes, its binary chunk {}", buffer_bytes_,
                           body_.size());
  }

  absl::Status CheckViews() {
    ASSIGN_OR_RETURN(const std::vector<Entry> views, EntriesOf(root_, "bufferViews", "view"));
    for (const Entry& entry : views) {
      View view;
      ASSIGN_OR_RETURN(const uint64_t buffer, entry.Whole("buffer"));
      ASSIGN_OR_RETURN(view.begin, entry.WholeOr("byteOffset", 0));
      ASSIGN_OR_RETURN(view.bytes, entry.Whole("byteLength"));
      ASSIGN_OR_RETURN(view.stride, entry.WholeOr("byteStride", 0));
      if (buffer != 0 || view.begin > buffer_bytes_ || view.bytes > buffer_bytes_ - view.begin) {
        return InvalidArgument("{}: {} bytes from byte {} of buffer {}, which has {}", entry.name,
                               view.bytes, view.begin, buffer, buffer == 0 ? buffer_bytes_ : 0);
      }
      views_.push_back(view);
    }
    return absl::OkStatus();
  }

  // Places `accessor` in the view that `entry` names. Errors: kInvalidArgument if it does not fit.
  absl::Status Locate(const Entry& entry, Accessor& accessor) const {
    ASSIGN_OR_RETURN(const uint64_t place, entry.Whole("bufferView"));
    if (place >= views_.size()) {
      return InvalidArgument("{}: view {} of {}", entry.name, place, views_.size());
    }
    const View& view = views_[place];
    ASSIGN_OR_RETURN(accessor.offset, entry.WholeOr("byteOffset", 0));
    accessor.view = place;
    accessor.stride = view.stride > 0 ? view.stride : accessor.element_bytes;
    // Neither wraps around: a count is at most kMostCorners, a stride kMostNumber.
    const uint64_t bytes =
        accessor.count == 0 ? 0 : (accessor.count - 1) * accessor.stride + accessor.element_bytes;
    if (accessor.offset <= view.bytes && bytes <= view.bytes - accessor.offset) {
      return absl::OkStatus();
    }
    return InvalidArgument("{}: {} bytes from byte {} of view {}, which has {}", entry.name, bytes,
                           accessor.offset, place, view.bytes);
  }

  absl::Status CheckAccessors() {
    ASSIGN_OR_RETURN(const std::vector<Entry> entries, EntriesOf(root_, "accessors", "accessor"));
    for (const Entry& entry : entries) {
      Accessor accessor;
      ASSIGN_OR_RETURN(accessor.count, entry.Whole("count"));
      ASSIGN_OR_RETURN(accessor.component_bytes, ComponentBytes(entry));
      ASSIGN_OR_RETURN(const uint64_t components, Components(entry));
      accessor.element_bytes = components * accessor.component_bytes;
      accessor.is_index = components == 1 && IsUnsigned(entry);
      if (accessor.count > kMostCorners) {
        return InvalidArgument("{}: {} elements, wanted at most {}", entry.name, accessor.count,
                               kMostCorners);
      }
      if (entry.Has("bufferView")) RETURN_IF_ERROR(Locate(entry, accessor));
      if (entry.Has("sparse")) RETURN_IF_ERROR(CheckSparse(entry, accessor));
      accessors_.push_back(accessor);
    }
    return absl::OkStatus();
  }

  static bool IsUnsigned(const Entry& entry) {
    const Json& type = entry.json["componentType"];
    return type == 5121 || type == 5123 || type == 5125;
  }

  // Elements that replace some of an accessor's.
  absl::Status CheckSparse(const Entry& parent, const Accessor& accessor) const {
    const Entry entry{parent.json["sparse"], parent.name + " sparse"};
    if (!entry.json.is_object() || !entry.Has("indices") || !entry.Has("values")) {
      return InvalidArgument("{}: wanted indices and values", entry.name);
    }
    const Entry places{entry.json["indices"], entry.name + " indices"};
    const Entry values{entry.json["values"], entry.name + " values"};
    Accessor index, value = accessor;
    ASSIGN_OR_RETURN(index.count, entry.Whole("count"));
    if (index.count > accessor.count) {
      return InvalidArgument("{}: {} elements of {}", entry.name, index.count, accessor.count);
    }
    value.count = index.count;
    RETURN_IF_ERROR(Locate(values, value));
    ASSIGN_OR_RETURN(index.component_bytes, ComponentBytes(places));
    index.element_bytes = index.component_bytes;
    RETURN_IF_ERROR(Locate(places, index));
    return CheckIndices(places.name, index, accessor.count);
  }

  // Checks that all indices are below `end`.
  absl::Status CheckIndices(const std::string& name, const Accessor& indices, uint64_t end) const {
    const char* at = body_.data() + views_[*indices.view].begin + indices.offset;
    for (uint64_t i = 0; i < indices.count; ++i) {
      uint32_t index = 0;
      std::memcpy(&index, at + i * indices.stride, indices.component_bytes);
      if (index >= end) {
        return InvalidArgument("{}: index {} is {}, wanted less than {}", name, i, index, end);
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<const Accessor*> AccessorOf(const Entry& entry, const char* key) const {
    ASSIGN_OR_RETURN(const uint64_t place, entry.Whole(key));
    if (place < accessors_.size()) return &accessors_[place];
    return InvalidArgument("{}: {} is accessor {} of {}", entry.name, key, place,
                           accessors_.size());
  }

  absl::Status CheckMeshes() {
    ASSIGN_OR_RETURN(const std::vector<Entry> meshes, EntriesOf(root_, "meshes", "mesh"));
    Amount all;
    for (const Entry& mesh : meshes) {
      Amount amount;
      const Entry named{mesh.json, mesh.name + " "};
      ASSIGN_OR_RETURN(const std::vector<Entry> parts, EntriesOf(named, "primitives", "part"));
      for (const Entry& part : parts) {
        ASSIGN_OR_RETURN(const Amount more, CheckPart(part));
        RETURN_IF_ERROR(amount.Add(more));
      }
      RETURN_IF_ERROR(all.Add(amount));
      meshes_.push_back(amount);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Amount> CheckPart(const Entry& part) const {
    if (!part.Has("attributes") || !part.json["attributes"].contains("POSITION")) {
      return InvalidArgument("{} has no attribute POSITION", part.name);
    }
    const Entry attributes{part.json["attributes"], part.name};
    ASSIGN_OR_RETURN(const Accessor* position, AccessorOf(attributes, "POSITION"));
    RETURN_IF_ERROR(CheckCounts(attributes, position->count));
    const Entry named{part.json, part.name + " "};
    ASSIGN_OR_RETURN(const std::vector<Entry> targets, EntriesOf(named, "targets", "target"));
    for (const Entry& target : targets) RETURN_IF_ERROR(CheckCounts(target, position->count));
    uint64_t corners = position->count;
    if (part.Has("indices")) {
      ASSIGN_OR_RETURN(const Accessor* indices, AccessorOf(part, "indices"));
      if (!indices->is_index) {
        return InvalidArgument("{}: its indices are no unsigned numbers", part.name);
      }
      if (indices->view) RETURN_IF_ERROR(CheckIndices(part.name, *indices, position->count));
      corners = indices->count;
    }
    ASSIGN_OR_RETURN(const uint64_t mode, part.WholeOr("mode", 4));
    const uint64_t triangles = mode == 4 ? corners / 3 : mode > 4 && corners > 2 ? corners - 2 : 0;
    return Amount{triangles, position->count};
  }

  // All attributes have as many elements as there are corners.
  absl::Status CheckCounts(const Entry& attributes, uint64_t corners) const {
    for (const auto& [name, place] : attributes.json.items()) {
      ASSIGN_OR_RETURN(const Accessor* accessor, AccessorOf(attributes, name.c_str()));
      if (accessor->count != corners) {
        return InvalidArgument("{}: {} has {} elements, wanted {}, as POSITION", attributes.name,
                               name, accessor->count, corners);
      }
    }
    return absl::OkStatus();
  }

  // Nodes form trees below the scene's, and each places its mesh anew.
  absl::Status CheckNodes() const {
    ASSIGN_OR_RETURN(const std::vector<Entry> nodes, EntriesOf(root_, "nodes", "node"));
    ASSIGN_OR_RETURN(const std::vector<Entry> scenes, EntriesOf(root_, "scenes", "scene"));
    std::vector<int> depth(nodes.size(), 0);  // 0: not reached.
    std::vector<size_t> reached;
    const auto reach = [&](const std::vector<size_t>& places, int at) -> absl::Status {
      for (const size_t place : places) {
        if (depth[place] != 0) return InvalidArgument("node {} stands in two places", place);
        depth[place] = at;
        reached.push_back(place);
      }
      return absl::OkStatus();
    };
    ASSIGN_OR_RETURN(const uint64_t shown, root_.WholeOr("scene", 0));
    if (shown >= scenes.size()) return InvalidArgument("scene {} of {}", shown, scenes.size());
    ASSIGN_OR_RETURN(const std::vector<size_t> roots,
                     PlacesOf(scenes[shown], "nodes", nodes.size()));
    RETURN_IF_ERROR(reach(roots, 1));
    Amount all;
    for (size_t i = 0; i < reached.size(); ++i) {
      const Entry& node = nodes[reached[i]];
      const int below = depth[reached[i]] + 1;
      if (below > kDeepestNode) return InvalidArgument("{} is too deep", node.name);
      ASSIGN_OR_RETURN(const std::vector<size_t> children,
                       PlacesOf(node, "children", nodes.size()));
      RETURN_IF_ERROR(reach(children, below));
      if (!node.Has("mesh")) continue;
      ASSIGN_OR_RETURN(const uint64_t mesh, node.Whole("mesh"));
      if (mesh >= meshes_.size()) {
        return InvalidArgument("{}: mesh {} of {}", node.name, mesh, meshes_.size());
      }
      RETURN_IF_ERROR(all.Add(meshes_[mesh]));
    }
    return absl::OkStatus();
  }

  // Skins and animations are not shown, but the importer reads them.
  absl::Status CheckSkins() const {
    ASSIGN_OR_RETURN(const std::vector<Entry> skins, EntriesOf(root_, "skins", "skin"));
    for (const Entry& skin : skins) {
      ASSIGN_OR_RETURN(const std::vector<size_t> joints, PlacesOf(skin, "joints", kMostNumber));
      if (!skin.Has("inverseBindMatrices")) continue;
      ASSIGN_OR_RETURN(const Accessor* matrices, AccessorOf(skin, "inverseBindMatrices"));
      if (matrices->count < joints.size()) {
        return InvalidArgument("{}: {} matrices, wanted {}, as joints", skin.name, matrices->count,
                               joints.size());
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckAnimations() const {
    ASSIGN_OR_RETURN(const std::vector<Entry> animations,
                     EntriesOf(root_, "animations", "animation"));
    for (const Entry& animation : animations) {
      const Entry named{animation.json, animation.name + " "};
      ASSIGN_OR_RETURN(const std::vector<Entry> samplers, EntriesOf(named, "samplers", "sampler"));
      for (const Entry& sampler : samplers) {
        ASSIGN_OR_RETURN(const Accessor* times, AccessorOf(sampler, "input"));
        ASSIGN_OR_RETURN(const Accessor* values, AccessorOf(sampler, "output"));
        const bool cubic =
            sampler.Has("interpolation") && sampler.json["interpolation"] == "CUBICSPLINE";
        const uint64_t wanted = times->count * (cubic ? 3 : 1);
        if (values->count >= wanted) continue;
        return InvalidArgument("{}: {} values, wanted {}", sampler.name, values->count, wanted);
      }
    }
    return absl::OkStatus();
  }

  const Entry root_;
  const std::string_view body_;
  uint64_t buffer_bytes_ = 0;
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
  std::vector<Amount> meshes_;
};

}  // namespace

absl::Status CheckGlb(std::string_view bytes) {
  ASSIGN_OR_RETURN(const GlbChunks chunks, ReadGlb(bytes));
  return Checker(chunks.json, chunks.body).Check();
}

}  // namespace parallax
