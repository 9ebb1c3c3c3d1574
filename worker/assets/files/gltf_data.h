// The data of a .glb (binary glTF 2.0): its JSON with checked look-ups, and the numbers behind its
// accessors. Constant; thread-safe.   Source: Khronos, "glTF 2.0 specification", chapters 3 and 4;
// KHR_mesh_quantization.
//
// Errors of all functions: kInvalidArgument saying what is wrong and what is wanted, without the
// file's name.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// The chunks of a .glb.
struct GlbChunks {
  nlohmann::json json;    // An object, at most 64 levels deep, no key twice in an object.
  std::string_view body;  // The binary chunk in the file's bytes; empty where none exists.
};

// Takes a file's bytes apart, which must outlive the result.
absl::StatusOr<GlbChunks> ReadGlbChunks(std::string_view bytes);

// Returns the names of pictures that lie beside the file, as its JSON has them. Empty for a file
// that is none: ReadGlb says what is wrong with it.
std::vector<std::string> PicturesBesideGlb(const std::string& path);

// An object of the JSON, with its name for messages: "accessor 3".
struct GltfEntry {
  const nlohmann::json& json;
  std::string name;

  bool Has(const char* key) const { return json.contains(key); }
  // The object under a key, which is empty where none exists.
  absl::StatusOr<GltfEntry> Object(const char* key) const;
  // The objects in a list; none where there is no such list. They are named like "accessor 3".
  absl::StatusOr<std::vector<GltfEntry>> List(const char* key, const std::string& name) const;
  // A whole number from 0 to 2^31 - 1.
  absl::StatusOr<uint64_t> Whole(const char* key) const;
  absl::StatusOr<uint64_t> WholeOr(const char* key, uint64_t otherwise) const;
  // Whole numbers below `end`; none where there is no such list.
  absl::StatusOr<std::vector<size_t>> Places(const char* key, size_t end) const;
  // A finite number, or a list of as many as `otherwise` has.
  absl::StatusOr<double> NumberOr(const char* key, double otherwise) const;
  absl::StatusOr<std::vector<double>> NumbersOr(const char* key,
                                                std::vector<double> otherwise) const;
  std::string TextOr(const char* key, const std::string& otherwise) const;
};

class GltfData {
 public:
  // Checks that the buffer lies in `body`, views in the buffer and accessors in their views. Both
  // arguments must outlive the result.
  static absl::StatusOr<GltfData> Open(const nlohmann::json& json, std::string_view body);

  GltfEntry root() const { return {*json_, ""}; }
  absl::StatusOr<std::string_view> BytesOfView(uint64_t view) const;
  // The number of an accessor that `entry` names under `key`, which is there.
  absl::StatusOr<uint64_t> AccessorOf(const GltfEntry& entry, const char* key) const;
  uint64_t CountOf(uint64_t accessor) const { return accessors_[accessor].count; }
  // Whether its data are in the file as they are.
  bool HasData(uint64_t accessor) const;
  // All numbers of an accessor, `components` an element; integers that count as fractions are
  // converted.
  absl::StatusOr<std::vector<double>> Numbers(uint64_t accessor, uint64_t components) const;
  // The numbers of an accessor of indices, all below `end`. `name` is whose they are.
  absl::StatusOr<std::vector<uint32_t>> Indices(uint64_t accessor, uint64_t end,
                                                const std::string& name) const;

 private:
  struct View {
    uint64_t begin = 0, bytes = 0;  // In the buffer.
    uint64_t stride = 0;            // 0: as the elements are large.
  };
  // Elements in a view.
  struct Elements {
    std::optional<size_t> view;  // Empty: zeros, or compressed data.
    uint64_t offset = 0, count = 0, stride = 0;
    uint64_t type = 0, components = 1;  // glTF's number of the components' type.
    bool normalized = false;
  };
  struct Accessor : Elements {
    std::string name;
    Elements sparse_indices, sparse_values;  // Elements that replace some; none if empty.
  };

  GltfData(const nlohmann::json& json, std::string_view body) : json_(&json), body_(body) {}
  absl::Status ReadViews();
  absl::Status ReadAccessors();
  absl::Status ReadSparse(const GltfEntry& entry, Accessor& accessor) const;
  absl::Status Locate(const GltfEntry& entry, Elements& elements) const;
  const char* At(const Elements& elements, uint64_t i) const;

  const nlohmann::json* json_;
  std::string_view body_;
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
};

}  // namespace parallax
