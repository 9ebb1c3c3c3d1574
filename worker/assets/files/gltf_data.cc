#include "worker/assets/files/gltf_data.h"

#include <fmt/core.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "worker/assets/files/mesh_file.h"

namespace parallax {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMostNumber = std::numeric_limits<int32_t>::max();
constexpr uint64_t kMostElements = 3 * uint64_t{kMostTrianglesOfAFile};

// The types of components by glTF's numbers.
enum ComponentType : uint64_t {
  kByte = 5120,
  kUnsignedByte,
  kShort,
  kUnsignedShort,
  kUnsignedInt = 5125,
  kFloat
};

uint64_t BytesOf(uint64_t type) {
  return type <= kUnsignedByte ? 1 : type <= kUnsignedShort ? 2 : 4;
}

absl::StatusOr<uint64_t> TypeOf(const GltfEntry& entry) {
  ASSIGN_OR_RETURN(const uint64_t type, entry.Whole("componentType"));
  if (type >= kByte && type <= kFloat && type != 5124) return type;
  return InvalidArgument("{}: componentType {}, wanted one of 5120 to 5126", entry.name, type);
}

absl::StatusOr<uint64_t> ComponentsOf(const GltfEntry& entry) {
  const std::pair<const char*, uint64_t> types[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  for (const auto& [name, count] : types) {
    if (entry.TextOr("type", "") == name) return count;
  }
  return InvalidArgument("{}: type is none of SCALAR, VEC2 to VEC4 and MAT2 to MAT4", entry.name);
}

template <typename T>
double NumberAt(const char* at, bool normalized) {
  T number;
  std::memcpy(&number, at, sizeof(number));
  if (!normalized) return static_cast<double>(number);
  return std::max(static_cast<double>(number) / std::numeric_limits<T>::max(), -1.0);
}

double NumberOf(const char* at, uint64_t type, bool normalized) {
  switch (type) {
    case kByte:
      return NumberAt<int8_t>(at, normalized);
    case kUnsignedByte:
      return NumberAt<uint8_t>(at, normalized);
    case kShort:
      return NumberAt<int16_t>(at, normalized);
    case kUnsignedShort:
      return NumberAt<uint16_t>(at, normalized);
    case kUnsignedInt:
      return NumberAt<uint32_t>(at, normalized);
    default:
      return NumberAt<float>(at, false);
  }
}

}  // namespace

// ---- Entries

absl::StatusOr<GltfEntry> GltfEntry::Object(const char* key) const {
  static const auto& empty = *new Json(Json::object());
  const auto found = json.find(key);
  GltfEntry entry{found == json.end() ? empty : *found, name + (name.empty() ? "" : " ") + key};
  if (entry.json.is_object()) return entry;
  return InvalidArgument("{} is no object", entry.name);
}

absl::StatusOr<std::vector<GltfEntry>> GltfEntry::List(const char* key,
                                                       const std::string& entry_name) const {
  std::vector<GltfEntry> entries;
  const auto found = json.find(key);
  if (found == json.end()) return entries;
  const std::string before = name + (name.empty() ? "" : " ");
  if (!found->is_array()) return InvalidArgument("{}{} is no list", before, key);
  for (const Json& entry : *found) {
    entries.push_back({entry, fmt::format("{}{} {}", before, entry_name, entries.size())});
    if (!entry.is_object()) return InvalidArgument("{} is no object", entries.back().name);
  }
  return entries;
}

absl::StatusOr<uint64_t> GltfEntry::Whole(const char* key) const {
  const auto found = json.find(key);
  if (found != json.end() && found->is_number_unsigned() && found->get<uint64_t>() <= kMostNumber) {
    return found->get<uint64_t>();
  }
  return InvalidArgument("{}: {} is {}, wanted a whole number from 0 to {}", name, key,
                         found == json.end() ? "missing" : "something else", kMostNumber);
}

absl::StatusOr<uint64_t> GltfEntry::WholeOr(const char* key, uint64_t otherwise) const {
  if (!Has(key)) return otherwise;
  return Whole(key);
}

absl::StatusOr<std::vector<size_t>> GltfEntry::Places(const char* key, size_t end) const {
  std::vector<size_t> places;
  const auto found = json.find(key);
  if (found == json.end()) return places;
  for (const Json& place : *found) {
    if (!place.is_number_unsigned() || place.get<uint64_t>() >= end) {
      return InvalidArgument("{}: {} names something that is not there", name, key);
    }
    places.push_back(place.get<size_t>());
  }
  return places;
}

absl::StatusOr<std::vector<double>> GltfEntry::NumbersOr(const char* key,
                                                         std::vector<double> otherwise) const {
  const auto found = json.find(key);
  if (found == json.end()) return otherwise;
  std::vector<double> numbers;
  for (const Json& number : *found) {
    if (number.is_number()) numbers.push_back(number.get<double>());
    if (!number.is_number() || !std::isfinite(numbers.back())) numbers.clear();
  }
  if (found->is_array() && numbers.size() == otherwise.size()) return numbers;
  return InvalidArgument("{}: {} is something else, wanted {} numbers", name, key,
                         otherwise.size());
}

absl::StatusOr<double> GltfEntry::NumberOr(const char* key, double otherwise) const {
  const auto found = json.find(key);
  if (found == json.end()) return otherwise;
  if (found->is_number() && std::isfinite(found->get<double>())) return found->get<double>();
  return InvalidArgument("{}: {} is something else, wanted a number", name, key);
}

std::string GltfEntry::TextOr(const char* key, const std::string& otherwise) const {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : otherwise;
}

// ---- Data

absl::StatusOr<GltfData> GltfData::Open(const Json& json, std::string_view body) {
  GltfData data(json, body);
  RETURN_IF_ERROR(data.ReadViews());
  RETURN_IF_ERROR(data.ReadAccessors());
  return data;
}

absl::Status GltfData::ReadViews() {
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> buffers, root().List("buffers", "buffer"));
  if (buffers.size() > 1 || (!buffers.empty() && buffers[0].Has("uri"))) {
    return InvalidArgument("its data lie in {}, wanted one buffer inside of the .glb",
                           buffers.size() > 1 ? "several buffers" : "another file");
  }
  uint64_t buffer_bytes = 0;
  if (!buffers.empty()) {
    ASSIGN_OR_RETURN(buffer_bytes, buffers[0].Whole("byteLength"));
  }
  if (buffer_bytes > body_.size()) {
    return InvalidArgument("buffer 0 has {} bytes, its binary chunk {}", buffer_bytes,
                           body_.size());
  }
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> views, root().List("bufferViews", "view"));
  for (const GltfEntry& entry : views) {
    View view;
    ASSIGN_OR_RETURN(const uint64_t buffer, entry.Whole("buffer"));
    ASSIGN_OR_RETURN(view.begin, entry.WholeOr("byteOffset", 0));
    ASSIGN_OR_RETURN(view.bytes, entry.Whole("byteLength"));
    ASSIGN_OR_RETURN(view.stride, entry.WholeOr("byteStride", 0));
    if (buffer != 0 || view.begin > buffer_bytes || view.bytes > buffer_bytes - view.begin) {
      return InvalidArgument("{}: {} bytes from byte {} of buffer {}, which has {}", entry.name,
                             view.bytes, view.begin, buffer, buffer == 0 ? buffer_bytes : 0);
    }
    views_.push_back(view);
  }
  return absl::OkStatus();
}

// Places elements in the view that `entry` names.
absl::Status GltfData::Locate(const GltfEntry& entry, Elements& elements) const {
  ASSIGN_OR_RETURN(const uint64_t place, entry.Whole("bufferView"));
  if (place >= views_.size()) {
    return InvalidArgument("{}: view {} of {}", entry.name, place, views_.size());
  }
  const View& view = views_[place];
  const uint64_t element_bytes = elements.components * BytesOf(elements.type);
  ASSIGN_OR_RETURN(elements.offset, entry.WholeOr("byteOffset", 0));
  elements.view = place;
  elements.stride = view.stride > 0 ? view.stride : element_bytes;
  // Neither wraps around: a count is at most kMostElements, a stride kMostNumber.
  const uint64_t bytes =
      elements.count == 0 ? 0 : (elements.count - 1) * elements.stride + element_bytes;
  if (elements.offset <= view.bytes && bytes <= view.bytes - elements.offset) {
    return absl::OkStatus();
  }
  return InvalidArgument("{}: {} bytes from byte {} of view {}, which has {}", entry.name, bytes,
                         elements.offset, place, view.bytes);
}

absl::Status GltfData::ReadAccessors() {
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> entries, root().List("accessors", "accessor"));
  for (const GltfEntry& entry : entries) {
    Accessor accessor;
    accessor.name = entry.name;
    ASSIGN_OR_RETURN(accessor.count, entry.Whole("count"));
    ASSIGN_OR_RETURN(accessor.type, TypeOf(entry));
    ASSIGN_OR_RETURN(accessor.components, ComponentsOf(entry));
    accessor.normalized = entry.Has("normalized") && entry.json["normalized"] == true;
    if (accessor.count > kMostElements) {
      return InvalidArgument("{}: {} elements, wanted at most {}", entry.name, accessor.count,
                             kMostElements);
    }
    if (entry.Has("bufferView")) RETURN_IF_ERROR(Locate(entry, accessor));
    if (entry.Has("sparse")) RETURN_IF_ERROR(ReadSparse(entry, accessor));
    accessors_.push_back(std::move(accessor));
  }
  return absl::OkStatus();
}

absl::Status GltfData::ReadSparse(const GltfEntry& parent, Accessor& accessor) const {
  ASSIGN_OR_RETURN(const GltfEntry entry, parent.Object("sparse"));
  ASSIGN_OR_RETURN(const GltfEntry places, entry.Object("indices"));
  ASSIGN_OR_RETURN(const GltfEntry values, entry.Object("values"));
  Elements& index = accessor.sparse_indices;
  ASSIGN_OR_RETURN(index.count, entry.Whole("count"));
  if (index.count > accessor.count) {
    return InvalidArgument("{}: {} elements of {}", entry.name, index.count, accessor.count);
  }
  accessor.sparse_values = accessor;
  accessor.sparse_values.count = index.count;
  RETURN_IF_ERROR(Locate(values, accessor.sparse_values));
  ASSIGN_OR_RETURN(index.type, TypeOf(places));
  RETURN_IF_ERROR(Locate(places, index));
  for (uint64_t i = 0; i < index.count; ++i) {
    const double at = NumberOf(At(index, i), index.type, false);
    if (at >= 0 && at < static_cast<double>(accessor.count)) continue;
    return InvalidArgument("{}: index {} is {}, wanted less than {}", places.name, i, at,
                           accessor.count);
  }
  return absl::OkStatus();
}

const char* GltfData::At(const Elements& elements, uint64_t i) const {
  return body_.data() + views_[*elements.view].begin + elements.offset + i * elements.stride;
}

absl::StatusOr<std::string_view> GltfData::BytesOfView(uint64_t view) const {
  if (view < views_.size()) return body_.substr(views_[view].begin, views_[view].bytes);
  return InvalidArgument("view {} of {}", view, views_.size());
}

absl::StatusOr<uint64_t> GltfData::AccessorOf(const GltfEntry& entry, const char* key) const {
  ASSIGN_OR_RETURN(const uint64_t place, entry.Whole(key));
  if (place < accessors_.size()) return place;
  return InvalidArgument("{}: {} is accessor {} of {}", entry.name, key, place, accessors_.size());
}

bool GltfData::HasData(uint64_t accessor) const {
  return accessors_[accessor].view || accessors_[accessor].sparse_indices.view;
}

absl::StatusOr<std::vector<double>> GltfData::Numbers(uint64_t place, uint64_t components) const {
  const Accessor& accessor = accessors_[place];
  if (accessor.components != components) {
    return InvalidArgument("{} has {} numbers an element, wanted {}", accessor.name,
                           accessor.components, components);
  }
  std::vector<double> numbers(accessor.count * components, 0.0);
  const auto read = [&](const Elements& from, uint64_t i, uint64_t to) {
    for (uint64_t c = 0; c < components; ++c) {
      numbers[to * components + c] =
          NumberOf(At(from, i) + c * BytesOf(from.type), from.type, accessor.normalized);
    }
  };
  for (uint64_t i = 0; accessor.view && i < accessor.count; ++i) read(accessor, i, i);
  const Elements& index = accessor.sparse_indices;
  for (uint64_t i = 0; index.view && i < index.count; ++i) {
    read(accessor.sparse_values, i,
         static_cast<uint64_t>(NumberOf(At(index, i), index.type, false)));
  }
  return numbers;
}

absl::StatusOr<std::vector<uint32_t>> GltfData::Indices(uint64_t place, uint64_t end,
                                                        const std::string& name) const {
  const Accessor& accessor = accessors_[place];
  if (accessor.components != 1 ||
      (accessor.type != kUnsignedByte && accessor.type != kUnsignedShort &&
       accessor.type != kUnsignedInt)) {
    return InvalidArgument("{}: its indices are no unsigned numbers", name);
  }
  ASSIGN_OR_RETURN(const std::vector<double> numbers, Numbers(place, 1));
  std::vector<uint32_t> indices;
  for (const double number : numbers) {
    if (number >= static_cast<double>(end)) {
      return InvalidArgument("{}: index {} is {}, wanted less than {}", name, indices.size(),
                             number, end);
    }
    indices.push_back(static_cast<uint32_t>(number));
  }
  return indices;
}

}  // namespace parallax
