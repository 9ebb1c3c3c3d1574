// Reads .obj.
#include <absl/strings/ascii.h>
#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "common/base/names.h"
#include "common/base/system/file.h"
#include "worker/assets/files/obj_materials.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// A corner of a face: places in the file's lists, from 0; -1 for none.
struct Corner {
  int64_t position = -1, uv = -1, normal = -1;
  auto operator<=>(const Corner&) const = default;
};

// A part while it is read.
struct Group {
  MeshPart part;
  std::map<Corner, uint32_t> vertices;
};

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& path)
      : lines_(bytes), folder_(fs::path(path).parent_path().string()) {}

  absl::StatusOr<MeshParts> Read() {
    for (std::string_view line; lines_.Next(&line);) {
      const absl::Status status = ReadLine(line);
      if (!status.ok()) {
        return InvalidArgument("line {}: {}", lines_.number(), ToStd(status.message()));
      }
    }
    for (auto& [key, group] : groups_) {
      group.part.material = out_.materials.size();
      RETURN_IF_ERROR(AddMaterial(std::get<0>(key), std::get<1>(key)));
      out_.parts.push_back(std::move(group.part));
    }
    for (const auto& [what, count] : left_out_) {
      out_.left_out.push_back(count > 1 ? fmt::format("{} ({} times)", what, count) : what);
    }
    return std::move(out_);
  }

 private:
  absl::Status ReadLine(std::string_view line) {
    const std::string_view key = TakeObjWord(line);
    if (key == "v") return ReadNumbers(line, 3, positions_);
    if (key == "vt") return ReadNumbers(line, 1, uv_);
    if (key == "vn") return ReadNumbers(line, 3, normals_);
    if (key == "f" || key == "fo") return ReadFace(line);
    if (key == "usemtl") {
      material_ = NameIn(line);
    } else if (key == "mtllib") {
      return ReadLibraries(line);
    } else if (key == "p" || key == "l") {
      ++left_out_["points and lines"];
    } else if (key == "curv" || key == "curv2" || key == "surf") {
      ++left_out_["free-form curves and surfaces"];
    }
    return absl::OkStatus();
  }

  static std::string NameIn(std::string_view line) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    return std::string(line);
  }

  // Reads as many numbers as a vector has, of which `least` are needed. More may follow: weights,
  // and colours.
  template <typename Vector>
  absl::Status ReadNumbers(std::string_view line, int least, std::vector<Vector>& to) {
    Vector vector = Vector::Zero();
    int count = 0;
    for (std::string_view word = TakeObjWord(line); !word.empty() && word.front() != '#';
         word = TakeObjWord(line)) {
      const std::optional<double> number = ObjNumber(word);
      if (!number) return InvalidArgument("{} is no number", Quoted(word));
      if (count < vector.size()) {
        vector[count] = static_cast<typename Vector::Scalar>(*number);
      }
      ++count;
    }
    if (count < least) return InvalidArgument("{} numbers, wanted {} or more", count, least);
    if (least == 3 && count >= 6) left_out_["vertex colours"] = 1;
    to.push_back(vector);
    return absl::OkStatus();
  }

  // Reads "7/1/3", of which only the first must be there. Negative ones count back.
  absl::StatusOr<Corner> ReadCorner(std::string_view word) const {
    Corner corner;
    const std::tuple<int64_t*, size_t, const char*> fields[] = {
        {&corner.position, positions_.size(), "vertex"},
        {&corner.uv, uv_.size(), "texture coordinate"},
        {&corner.normal, normals_.size(), "normal"}};
    std::string_view rest = word;
    for (const auto& [place, count, name] : fields) {
      const std::string_view text = rest.substr(0, rest.find('/'));
      rest.remove_prefix(std::min(text.size() + 1, rest.size()));
      if (text.empty() && place != &corner.position) continue;
      int64_t number = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
      const auto most = static_cast<int64_t>(count);
      if (error != std::errc() || end != text.data() + text.size() || number == 0 ||
          number > most || number < -most) {
        return InvalidArgument("{}: {} {}, wanted 1 to {}", Quoted(word), name, text, most);
      }
      *place = number > 0 ? number - 1 : most + number;
    }
    return corner;
  }

  absl::Status ReadFace(std::string_view line) {
    std::vector<Corner> corners;
    bool has_uv = true, has_normals = true;
    for (std::string_view word = TakeObjWord(line); !word.empty() && word.front() != '#';
         word = TakeObjWord(line)) {
      ASSIGN_OR_RETURN(corners.emplace_back(), ReadCorner(word));
      has_uv = has_uv && corners.back().uv >= 0;
      has_normals = has_normals && corners.back().normal >= 0;
    }
    if (corners.size() < 3) {
      ++left_out_["faces of less than 3 corners"];
      return absl::OkStatus();
    }
    triangles_ += static_cast<int64_t>(corners.size()) - 2;
    if (triangles_ > kMostTrianglesOfAFile) {
      return InvalidArgument("{} triangles or more, wanted 1 to {}", triangles_,
                             kMostTrianglesOfAFile);
    }
    Group& group = groups_[{material_, has_uv, has_normals}];
    std::vector<uint32_t> vertices;
    for (Corner& corner : corners) {
      if (!has_uv) corner.uv = -1;
      if (!has_normals) corner.normal = -1;
      vertices.push_back(VertexOf(corner, group));
    }
    AddPolygon(group.part.positions, vertices, group.part.triangles);
    return absl::OkStatus();
  }

  uint32_t VertexOf(const Corner& corner, Group& group) const {
    MeshPart& part = group.part;
    const auto [entry, is_new] =
        group.vertices.try_emplace(corner, static_cast<uint32_t>(part.positions.size()));
    if (is_new) {
      part.positions.push_back(positions_[static_cast<size_t>(corner.position)]);
      if (corner.uv >= 0) part.uv.push_back(uv_[static_cast<size_t>(corner.uv)]);
      if (corner.normal >= 0) {
        part.normals.push_back(normals_[static_cast<size_t>(corner.normal)]);
      }
    }
    return entry->second;
  }

  // Reads one file whose name may have blanks, or several.
  absl::Status ReadLibraries(std::string_view line) {
    const std::string whole = NameIn(line);
    if (FindBeside(folder_, whole).ok()) return ReadLibrary(whole);
    std::vector<std::string> missing;
    bool any = false;
    for (std::string_view name = TakeObjWord(line); !name.empty(); name = TakeObjWord(line)) {
      if (!FindBeside(folder_, std::string(name)).ok()) {
        missing.emplace_back(name);
        continue;
      }
      any = true;
      RETURN_IF_ERROR(ReadLibrary(std::string(name)));
    }
    if (!any) missing = {whole};
    for (const std::string& name : missing) left_out_[name + ", which is not there"] = 1;
    return absl::OkStatus();
  }

  absl::Status ReadLibrary(const std::string& name) {
    ASSIGN_OR_RETURN(const std::string found, FindBeside(folder_, name));
    if (!libraries_.insert(found).second) return absl::OkStatus();
    const fs::path path = fs::path(folder_) / found;
    // Only these count for the mesh's hash and are brought along.
    if (absl::AsciiStrToLower(path.extension().string()) != ".mtl") {
      return InvalidArgument("its materials {} are named like none, wanted .mtl", found);
    }
    ASSIGN_OR_RETURN(const std::string text, ReadFile(path.string()));
    return ReadMtl(text, found, path.parent_path().string(), materials_);
  }

  absl::Status AddMaterial(const std::string& name, bool has_uv) {
    FileMaterial read;
    read.name = name;
    const auto found = materials_.find(name);
    if (found != materials_.end()) {
      RETURN_IF_ERROR(ReadObjLooks(found->second, folder_, has_uv, read, out_.left_out));
    } else if (!name.empty()) {
      left_out_[fmt::format("material {}, which no .mtl has", name)] = 1;
    }
    out_.materials.push_back(std::move(read));
    return absl::OkStatus();
  }

  ObjLines lines_;
  const std::string folder_;
  std::vector<Vec3d> positions_;
  std::vector<Vec2f> uv_;
  std::vector<Vec3f> normals_;
  std::string material_;                                         // The faces that follow have it.
  std::map<std::tuple<std::string, bool, bool>, Group> groups_;  // With uv, with normals.
  std::map<std::string, ObjMaterial> materials_;
  std::set<std::string> libraries_;
  std::map<std::string, int> left_out_;  // How often.
  int64_t triangles_ = 0;
  MeshParts out_;
};

}  // namespace

absl::StatusOr<MeshParts> ReadObj(std::string_view bytes, const std::string& path) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff") ||
      bytes.substr(0, 1000).find('\0') != bytes.npos) {
    return InvalidArgument("no text in UTF-8; in UTF-16 or binary it can't be read");
  }
  return ObjReader(bytes, path).Read();
}

}  // namespace parallax
