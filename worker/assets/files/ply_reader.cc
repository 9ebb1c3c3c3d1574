#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/names.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {
namespace {

constexpr size_t kMostHeaderBytes = 64 << 10;
// Strips of one triangle each, with what divides them.
constexpr size_t kMostListed = 4 * size_t{kMostTrianglesOfAFile};
constexpr std::string_view kBlanks = " \t\r";

struct Type {
  size_t bytes = 0;
  bool is_float = false, is_signed = false;
};

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  // Set for lists.
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Format { kAscii, kLittle, kBig };

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::vector<std::string> pictures;  // From MeshLab's comments "TextureFile".
};

void TakeBlanks(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
}

// Takes the first word off a line; empty at its end.
std::string_view TakeWord(std::string_view& line) {
  TakeBlanks(line);
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

// Takes the first line off a text.
std::string_view TakeLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

std::optional<Type> TypeOf(std::string_view name) {
  const struct {
    std::string_view name, other;
    Type type;
  } types[] = {{"char", "int8", {1, false, true}},     {"uchar", "uint8", {1, false, false}},
               {"short", "int16", {2, false, true}},   {"ushort", "uint16", {2, false, false}},
               {"int", "int32", {4, false, true}},     {"uint", "uint32", {4, false, false}},
               {"float", "float32", {4, true, true}},  {"double", "float64", {8, true, true}},
               {"double64", "double", {8, true, true}}};
  for (const auto& entry : types) {
    if (name == entry.name || name == entry.other) return entry.type;
  }
  return std::nullopt;
}

absl::Status AddElement(std::string_view line, Header& header) {
  Element element;
  element.name = TakeWord(line);
  if (std::any_of(header.elements.begin(), header.elements.end(),
                  [&](const Element& other) { return other.name == element.name; })) {
    return InvalidArgument("element {} twice", Printable(element.name));
  }
  const std::string_view number = TakeWord(line);
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), element.count);
  if (error != std::errc() || end != number.data() + number.size()) {
    return InvalidArgument("{} elements {}, wanted a whole number", Quoted(number),
                           Quoted(element.name));
  }
  const uint64_t most = (element.name == "face" ? 1 : 3) * uint64_t{kMostTrianglesOfAFile};
  if (element.count > most) {
    return InvalidArgument("{} elements {}, wanted at most {}", element.count, Quoted(element.name),
                           most);
  }
  header.elements.push_back(std::move(element));
  return absl::OkStatus();
}

absl::Status AddProperty(std::string_view line, Header& header) {
  const std::string text(line);
  if (header.elements.empty()) return InvalidArgument("a property of no element");
  Property property;
  std::string_view word = TakeWord(line);
  if (word == "list") {
    property.count = TypeOf(TakeWord(line));
    if (!property.count || property.count->is_float) {
      return InvalidArgument("property{}: wanted a list counted by whole numbers", text);
    }
    word = TakeWord(line);
  }
  const std::optional<Type> type = TypeOf(word);
  if (!type) return InvalidArgument("property{}: {} is no type", text, Quoted(word));
  property.type = *type;
  property.name = TakeWord(line);
  header.elements.back().properties.push_back(property);
  return absl::OkStatus();
}

absl::StatusOr<Format> FormatOf(std::string_view word) {
  if (word == "ascii") return Format::kAscii;
  if (word == "binary_little_endian") return Format::kLittle;
  if (word == "binary_big_endian") return Format::kBig;
  return InvalidArgument("format {}, wanted ascii, binary_little_endian or binary_big_endian",
                         Quoted(word));
}

// Takes the header off the file's bytes.
absl::StatusOr<Header> TakeHeader(std::string_view& bytes) {
  Header header;
  std::string_view head = bytes.substr(0, kMostHeaderBytes);
  const size_t all = head.size();
  if (head.substr(0, 3) != "ply" && head.substr(0, 3) != "PLY") {
    return InvalidArgument("does not begin with \"ply\"");
  }
  while (head.find('\n') != head.npos) {
    std::string_view line = TakeLine(head);
    const std::string_view word = TakeWord(line);
    if (word == "format") {
      ASSIGN_OR_RETURN(header.format, FormatOf(TakeWord(line)));
    }
    if (word == "element") RETURN_IF_ERROR(AddElement(line, header));
    if (word == "comment" && TakeWord(line) == "TextureFile") {
      TakeBlanks(line);
      header.pictures.emplace_back(line);
    }
    if (word == "property") RETURN_IF_ERROR(AddProperty(line, header));
    if (word != "end_header") continue;
    bytes.remove_prefix(all - head.size());
    return header;
  }
  return InvalidArgument("its header has no end_header in its first {} bytes", kMostHeaderBytes);
}

// The data behind the header. Each function returns false or nothing where they end.
class Body {
 public:
  Body(std::string_view bytes, Format format) : bytes_(bytes), format_(format) {}

  // Goes to the next instance of an element: a line of text.
  bool Begin() {
    if (format_ != Format::kAscii) return true;
    for (line_ = {}; line_.find_first_not_of(kBlanks) == line_.npos;) {
      if (bytes_.empty()) return false;
      line_ = TakeLine(bytes_);
    }
    return true;
  }

  // Reads a number; NaN for a word that is none.
  std::optional<double> Number(const Type& type) {
    if (format_ == Format::kAscii) {
      std::string_view word = TakeWord(line_);
      if (word.empty()) return std::nullopt;
      if (word.front() == '+') word.remove_prefix(1);
      double number = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      return error == std::errc() && end == word.data() + word.size() ? number : std::nan("");
    }
    if (bytes_.size() < type.bytes) return std::nullopt;
    const std::string_view at = bytes_.substr(0, type.bytes);
    bytes_.remove_prefix(type.bytes);
    return Decoded(at, type);
  }

 private:
  double Decoded(std::string_view at, const Type& type) const {
    uint64_t bits = 0;
    for (size_t i = 0; i < at.size(); ++i) {
      const size_t byte = format_ == Format::kBig ? at.size() - 1 - i : i;
      bits |= uint64_t{static_cast<unsigned char>(at[byte])} << 8 * i;
    }
    if (type.is_float) {
      return type.bytes == 8 ? std::bit_cast<double>(bits)
                             : double{std::bit_cast<float>(static_cast<uint32_t>(bits))};
    }
    const auto number = static_cast<double>(bits);
    const double range = std::ldexp(1.0, 8 * static_cast<int>(type.bytes));
    return type.is_signed && number >= range / 2 ? number - range : number;
  }

  std::string_view bytes_, line_;
  const Format format_;
};

// One instance of an element: each property's numbers, one unless it is a list.
using Instance = std::vector<std::vector<double>>;

// A face before it is split into triangles.
struct Face {
  std::vector<uint32_t> corners;
  std::vector<double> uv;  // Two a corner, or none.
  size_t picture = 0;
};

class PlyReader {
 public:
  PlyReader(const Header& header, std::string_view bytes, const std::string& path)
      : header_(header), body_(bytes, header.format), path_(path) {}

  absl::StatusOr<MeshParts> Read() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex") vertices_ += element.count;
    }
    for (const Element& element : header_.elements) {
      RETURN_IF_ERROR(Begin(element));
      for (uint64_t i = 0; i < element.count; ++i) {
        if (!body_.Begin()) return Ends(element, i);
        ASSIGN_OR_RETURN(const Instance instance, ReadInstance(element, i));
        RETURN_IF_ERROR(Take(element, i, instance));
      }
    }
    RETURN_IF_ERROR(MakeParts());
    return std::move(out_);
  }

 private:
  static absl::Status Ends(const Element& element, uint64_t i) {
    return InvalidArgument("its data end within {} {}, wanted {} of them", element.name, i,
                           element.count);
  }

  // Finds the properties that are used; the others are left out.
  absl::Status Begin(const Element& element) {
    // Names that writers give to the same thing.
    static const auto& others = *new std::map<std::string, std::string>{
        {"s", "u"},         {"t", "v"},          {"texture_u", "u"},
        {"texture_v", "v"}, {"texture_s", "u"},  {"texture_t", "v"},
        {"tex_u", "u"},     {"tex_v", "v"},      {"vertex_index", "vertex_indices"},
        {"red", "colour"},  {"green", "colour"}, {"blue", "colour"}};
    static const auto& silent = *new std::set<std::string>{"alpha", "flags"};
    static const auto& used = *new std::map<std::string, std::set<std::string>>{
        {"vertex", {"x", "y", "z", "nx", "ny", "nz", "u", "v"}},
        {"face", {"vertex_indices", "texcoord", "texnumber"}},
        {"tristrips", {"vertex_indices"}}};
    places_.clear();
    const auto of_element = used.find(element.name);
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      const auto other = others.find(property.name);
      const std::string& name = other == others.end() ? property.name : other->second;
      if (of_element == used.end()) continue;
      if (of_element->second.contains(name)) {
        places_.try_emplace(name, i);
        if (name == "x") {
          is_coarse_ = property.type.bytes == 4 && header_.format != Format::kAscii;
        }
      } else if (!silent.contains(name)) {
        const std::string what = name == "colour" ? "colours" : Quoted(name);
        out_.left_out.push_back(element.name + " " + what);
      }
    }
    std::sort(out_.left_out.begin(), out_.left_out.end());
    out_.left_out.erase(std::unique(out_.left_out.begin(), out_.left_out.end()),
                        out_.left_out.end());
    if (element.count == 0) return absl::OkStatus();
    if (of_element == used.end()) {
      out_.left_out.push_back(fmt::format("{} elements {}", element.count, Quoted(element.name)));
      return absl::OkStatus();
    }
    for (const char* name : {"x", "y", "z"}) {
      if (element.name == "vertex" && !places_.contains(name)) {
        return InvalidArgument("its vertices have no property {}", name);
      }
    }
    if (element.name == "vertex" || places_.contains("vertex_indices")) return absl::OkStatus();
    return InvalidArgument("its element {} has no list vertex_indices", element.name);
  }

  absl::StatusOr<Instance> ReadInstance(const Element& element, uint64_t i) {
    Instance instance;
    for (const Property& property : element.properties) {
      std::vector<double>& numbers = instance.emplace_back();
      double count = 1;
      if (property.count) {
        const std::optional<double> read = body_.Number(*property.count);
        if (!read) return Ends(element, i);
        if (!(*read >= 0) || *read != std::floor(*read) || *read > 4294967295.0) {
          return InvalidArgument("{} {}: a list of {:g} numbers", element.name, i, *read);
        }
        count = *read;
      }
      for (; count > 0; --count) {
        const std::optional<double> number = body_.Number(property.type);
        if (!number) return Ends(element, i);
        if (numbers.size() == kMostListed) {
          return InvalidArgument("{} {}: a list of more than {} numbers", element.name, i,
                                 kMostListed);
        }
        numbers.push_back(*number);
      }
    }
    return instance;
  }

  // Returns a property's numbers; none where there is no such property.
  const std::vector<double>& Of(const Instance& instance, const std::string& name) const {
    static const auto& none = *new std::vector<double>;
    const auto place = places_.find(name);
    return place == places_.end() ? none : instance[place->second];
  }

  // Returns the numbers of single properties.
  template <typename Vector>
  static Vector VectorOf(const PlyReader& reader, const Instance& instance,
                         std::initializer_list<const char*> names) {
    Vector vector;
    int i = 0;
    for (const char* name : names) {
      const std::vector<double>& numbers = reader.Of(instance, name);
      vector[i++] = static_cast<typename Vector::Scalar>(numbers.empty() ? 0 : numbers.front());
    }
    return vector;
  }

  absl::Status Take(const Element& element, uint64_t i, const Instance& instance) {
    if (element.name == "vertex") {
      vertex_.positions.push_back(VectorOf<Vec3d>(*this, instance, {"x", "y", "z"}));
      if (places_.contains("nx")) {
        vertex_.normals.push_back(VectorOf<Vec3f>(*this, instance, {"nx", "ny", "nz"}));
      }
      if (places_.contains("u") && places_.contains("v")) {
        vertex_.uv.push_back(VectorOf<Vec2f>(*this, instance, {"u", "v"}));
      }
      return absl::OkStatus();
    }
    const bool is_strips = element.name == "tristrips";
    if (!is_strips && element.name != "face") return absl::OkStatus();
    Face face;
    bool is_odd = false;
    for (const double vertex : Of(instance, "vertex_indices")) {
      if (is_strips && vertex == -1) {  // Begins another strip.
        face.corners.clear();
        is_odd = false;
        continue;
      }
      if (!(vertex >= 0 && vertex < static_cast<double>(vertices_))) {
        return InvalidArgument("{} {}: vertex {:g}, wanted 0 to less than {}", element.name, i,
                               vertex, vertices_);
      }
      face.corners.push_back(static_cast<uint32_t>(vertex));
      if (!is_strips || face.corners.size() < 3) continue;
      RETURN_IF_ERROR(Keep(element, i, face));
      if (is_odd) std::swap(faces_.back().corners[0], faces_.back().corners[1]);
      is_odd = !is_odd;
      face.corners.erase(face.corners.begin());
    }
    if (is_strips) return absl::OkStatus();
    face.uv = Of(instance, "texcoord");
    if (face.uv.size() != 2 * face.corners.size()) face.uv.clear();
    const std::vector<double>& picture = Of(instance, "texnumber");
    if (!picture.empty() && picture.front() > 0 &&
        picture.front() < static_cast<double>(header_.pictures.size())) {
      face.picture = static_cast<size_t>(picture.front());
    }
    return Keep(element, i, std::move(face));
  }

  absl::Status Keep(const Element& element, uint64_t i, Face face) {
    triangles_ += std::max(int64_t{0}, static_cast<int64_t>(face.corners.size()) - 2);
    if (triangles_ > kMostTrianglesOfAFile) {
      return InvalidArgument("{} {}: {} triangles or more, wanted 1 to {}", element.name, i,
                             triangles_, kMostTrianglesOfAFile);
    }
    faces_.push_back(std::move(face));
    return absl::OkStatus();
  }

  // Makes a part of the faces with each picture, with and without coordinates.
  absl::Status MakeParts() {
    std::map<std::pair<size_t, bool>, std::vector<const Face*>> groups;
    for (const Face& face : faces_) groups[{face.picture, !face.uv.empty()}].push_back(&face);
    for (const auto& [key, faces] : groups) {
      MeshPart part;
      if (key.second) {  // Coordinates of corners: each is a vertex.
        for (const Face* face : faces) AddCorners(*face, part);
      } else {
        part = vertex_;
        for (const Face* face : faces) {
          AddPolygon(part.positions, face->corners, part.triangles);
        }
      }
      part.material = out_.materials.size();
      if (is_coarse_) part.step = FloatStep(part.positions);
      RETURN_IF_ERROR(AddMaterial(key.first, !part.uv.empty()));
      out_.parts.push_back(std::move(part));
    }
    return absl::OkStatus();
  }

  void AddCorners(const Face& face, MeshPart& part) const {
    std::vector<uint32_t> corners;
    for (size_t k = 0; k < face.corners.size(); ++k) {
      corners.push_back(static_cast<uint32_t>(part.positions.size()));
      part.positions.push_back(vertex_.positions[face.corners[k]]);
      if (!vertex_.normals.empty()) part.normals.push_back(vertex_.normals[face.corners[k]]);
      part.uv.push_back(Vec2d(face.uv[2 * k], face.uv[2 * k + 1]).cast<float>());
    }
    AddPolygon(part.positions, corners, part.triangles);
  }

  absl::Status AddMaterial(size_t picture, bool has_uv) {
    FileMaterial material;
    if (picture < header_.pictures.size()) {
      const std::string& name = header_.pictures[picture];
      if (has_uv) {
        const std::string folder = std::filesystem::path(path_).parent_path().string();
        material.looks.emplace().albedo.emplace();
        ASSIGN_OR_RETURN(material.looks->albedo->image, ReadBeside(folder, name));
        material.maps.push_back("colour " + name);
      } else {
        out_.left_out.push_back(name + ", on faces without texture coordinates");
      }
    }
    out_.materials.push_back(std::move(material));
    return absl::OkStatus();
  }

  const Header& header_;
  Body body_;
  const std::string& path_;
  uint64_t vertices_ = 0;
  bool is_coarse_ = false;                // Positions have 32 bits.
  std::map<std::string, size_t> places_;  // Properties of the element that is read.
  MeshPart vertex_;                       // All vertices.
  std::vector<Face> faces_;
  int64_t triangles_ = 0;  // The faces make this number of them.
  MeshParts out_;
};

}  // namespace

absl::StatusOr<MeshParts> ReadPly(std::string_view bytes, const std::string& path) {
  ASSIGN_OR_RETURN(const Header header, TakeHeader(bytes));
  return PlyReader(header, bytes, path).Read();
}

}  // namespace parallax
