#include "worker/assets/files/ply_check.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "common/base/names.h"
#include "worker/assets/files/mesh_file.h"

namespace parallax {
namespace {

constexpr size_t kMostHeaderBytes = 64 << 10;
constexpr std::string_view kBlanks = " \t\r";

struct Type {
  size_t bytes = 0;
  bool is_float = false, is_signed = false;
};

struct Property {
  Type type;
  std::optional<Type> count;  // Set for lists.
  bool is_vertex = false;     // Names vertices.
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
  uint64_t vertices = 0;
};

// Takes the first word off a line; empty at its end.
std::string_view TakeWord(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
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
  if (element.name == "vertex") header.vertices = element.count;
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
  const std::string_view name = TakeWord(line);
  property.is_vertex = property.count && header.elements.back().name == "face" &&
                       (name == "vertex_indices" || name == "vertex_index");
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

  bool Skip(const Type& type, uint64_t count) {
    if (format_ == Format::kAscii) {
      for (; count > 0; --count) {
        if (TakeWord(line_).empty()) return false;
      }
      return true;
    }
    if (count > bytes_.size() / type.bytes) return false;
    bytes_.remove_prefix(count * type.bytes);
    return true;
  }

  // Reads a number; NaN for a word that is none.
  std::optional<double> Number(const Type& type) {
    if (format_ == Format::kAscii) {
      const std::string_view word = TakeWord(line_);
      if (word.empty()) return std::nullopt;
      double number = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      return error == std::errc() && end == word.data() + word.size() ? number : std::nan("");
    }
    const std::string_view at = bytes_;
    if (!Skip(type, 1)) return std::nullopt;
    return Decoded(at.substr(0, type.bytes), type);
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

class Walker {
 public:
  Walker(const Header& header, std::string_view bytes)
      : header_(header), body_(bytes, header.format) {}

  absl::Status Walk() {
    for (const Element& element : header_.elements) {
      for (uint64_t i = 0; i < element.count; ++i) {
        if (!body_.Begin()) return Ends(element, i);
        for (const Property& property : element.properties) {
          RETURN_IF_ERROR(Read(property, element, i));
        }
      }
    }
    return absl::OkStatus();
  }

 private:
  static absl::Status Ends(const Element& element, uint64_t i) {
    return InvalidArgument("its data end within {} {}, wanted {} of them", element.name, i,
                           element.count);
  }

  absl::Status Read(const Property& property, const Element& element, uint64_t i) {
    if (!property.count) {
      return body_.Skip(property.type, 1) ? absl::OkStatus() : Ends(element, i);
    }
    const std::optional<double> count = body_.Number(*property.count);
    if (!count) return Ends(element, i);
    if (!(*count >= 0) || *count != std::floor(*count) || *count > 4294967295.0) {
      return InvalidArgument("{} {}: a list of {:g} numbers", element.name, i, *count);
    }
    const auto numbers = static_cast<uint64_t>(*count);
    if (!property.is_vertex) {
      return body_.Skip(property.type, numbers) ? absl::OkStatus() : Ends(element, i);
    }
    for (uint64_t k = 0; k < numbers; ++k) {
      const std::optional<double> vertex = body_.Number(property.type);
      if (!vertex) return Ends(element, i);
      if (*vertex >= 0 && *vertex < static_cast<double>(header_.vertices)) continue;
      return InvalidArgument("{} {}: vertex {:g}, wanted 0 to less than {}", element.name, i,
                             *vertex, header_.vertices);
    }
    return absl::OkStatus();
  }

  const Header& header_;
  Body body_;
};

}  // namespace

absl::Status CheckPly(std::string_view bytes) {
  ASSIGN_OR_RETURN(const Header header, TakeHeader(bytes));
  return Walker(header, bytes).Walk();
}

}  // namespace parallax
