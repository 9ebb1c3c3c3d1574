#include "worker/assets/files/obj_materials.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "common/base/names.h"

namespace parallax {
namespace {

constexpr std::string_view kBlanks = " \t";

std::string_view Trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

std::string LowerWord(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The kinds of lines that give maps.
const char* MapOf(const std::string& key) {
  if (key == "map_kd") return "colour";
  if (key == "map_pr") return "roughness";
  if (key == "map_pm") return "metal";
  if (key == "norm" || key == "map_kn") return "normal";
  return nullptr;
}

// Up to three numbers at a line's beginning.
std::vector<double> TakeNumbers(std::string_view& line) {
  std::vector<double> numbers;
  while (numbers.size() < 3) {
    std::string_view rest = line;
    const std::optional<double> number = ObjNumber(TakeObjWord(rest));
    if (!number) break;
    numbers.push_back(*number);
    line = rest;
  }
  return numbers;
}

bool AreFinite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
}

// Takes the options off a map's line and applies them. Returns those that are not used.
std::vector<std::string> TakeOptions(std::string_view& line, PbrPicture& picture,
                                     double* bump_scale) {
  std::vector<std::string> unused;
  while (line = Trimmed(line), line.size() > 1 && line.front() == '-') {
    const std::string option(TakeObjWord(line));
    if (option == "-s" || option == "-o" || option == "-t" || option == "-mm") {
      const std::vector<double> numbers = TakeNumbers(line);
      if (option == "-t" || option == "-mm" || !AreFinite(numbers)) {
        unused.push_back(option);
        continue;
      }
      for (size_t i = 0; i < std::min<size_t>(numbers.size(), 2); ++i) {
        const auto number = static_cast<float>(numbers[i]);
        const auto c = static_cast<Eigen::Index>(i);
        if (option == "-s") picture.turn(c, c) = number;
        if (option == "-o") picture.offset[c] = number;
      }
    } else {
      const std::string value(TakeObjWord(line));
      if (option == "-clamp" && value == "on") {
        picture.edges = {MipPicture::Edge::kClamp, MipPicture::Edge::kClamp};
      } else if (option == "-bm") {
        const double scale = ObjNumber(value).value_or(1);
        if (std::isfinite(scale)) *bump_scale = scale;
      } else if (option != "-clamp" && option != "-blendu" && option != "-blendv") {
        unused.push_back(option);
      }
    }
  }
  return unused;
}

absl::Status ReadColor(std::string_view line, Vec3f& color) {
  std::string_view rest = line;
  const std::vector<double> numbers = TakeNumbers(rest);
  if (numbers.empty() || !AreFinite(numbers)) {
    return InvalidArgument("Kd{}: wanted three numbers", line);
  }
  for (int c = 0; c < 3; ++c) {
    const double number = numbers.size() == 3 ? numbers[static_cast<size_t>(c)] : numbers[0];
    color[c] = std::clamp(static_cast<float>(number), 0.0f, 1.0f);
  }
  return absl::OkStatus();
}

absl::Status ReadLine(const std::string& key, std::string_view line, ObjMaterial& material) {
  if (key == "kd") return ReadColor(line, material.color.emplace());
  const std::optional<double> number = [&] {
    std::string_view rest = line;
    return ObjNumber(TakeObjWord(rest));
  }();
  if (key == "pr" || key == "pm") {
    if (!number || !std::isfinite(*number)) {
      return InvalidArgument("{}{}: wanted a number", key, line);
    }
    (key == "pr" ? material.roughness : material.metallic) =
        std::clamp(static_cast<float>(*number), 0.0f, 1.0f);
    return absl::OkStatus();
  }
  if (const char* map = MapOf(key)) {
    material.maps.push_back({map, std::string(line)});
  } else if (key.starts_with("map_") || key == "bump" || key == "disp" || key == "decal" ||
             key == "refl") {
    material.left_out.push_back(key);
  } else if (key == "ke") {
    const std::vector<double> glow = TakeNumbers(line);
    const bool glows = std::any_of(glow.begin(), glow.end(), [](double g) { return g > 0; });
    if (glows) material.left_out.push_back("emission");
  } else if ((key == "d" && number && *number < 1) || (key == "tr" && number && *number > 0)) {
    material.left_out.push_back("transparency");
  }
  return absl::OkStatus();
}

}  // namespace

ObjLines::ObjLines(std::string_view text) : text_(text) {
  if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
}

bool ObjLines::Next(std::string_view* line) {
  joined_.clear();
  bool is_joined = false;
  while (!text_.empty()) {
    if (!is_joined) number_ = next_number_;
    const size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
    std::string_view part = text_.substr(0, end);
    const bool crlf = text_.substr(end, 2) == "\r\n";
    text_.remove_prefix(std::min(end + (crlf ? 2 : 1), text_.size()));
    ++next_number_;
    const bool goes_on = part.ends_with('\\') && part.find('#') == part.npos;
    if (goes_on) {
      part.remove_suffix(1);
      joined_ += part;
      joined_ += ' ';
      is_joined = true;
      continue;
    }
    if (is_joined) {
      joined_ += part;
      part = joined_;
    }
    part = Trimmed(part);
    if (!part.empty() && part.front() != '#') {
      *line = part;
      return true;
    }
    joined_.clear();
    is_joined = false;
  }
  return false;
}

std::string_view TakeObjWord(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::optional<double> ObjNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty()) return std::nullopt;
  if (error == std::errc() && end == word.data() + word.size()) return number;
  std::string dotted(word);
  if (std::count(dotted.begin(), dotted.end(), ',') != 1) return std::nullopt;
  std::replace(dotted.begin(), dotted.end(), ',', '.');
  return ObjNumber(dotted);
}

absl::Status ReadMtl(std::string_view text, const std::string& file, const std::string& folder,
                     std::map<std::string, ObjMaterial>& materials) {
  ObjLines lines(text);
  ObjMaterial* material = nullptr;
  ObjMaterial double_named;
  for (std::string_view line; lines.Next(&line);) {
    const std::string key = LowerWord(TakeObjWord(line));
    if (key == "newmtl") {
      const auto [entry, is_new] = materials.try_emplace(std::string(Trimmed(line)));
      material = is_new ? &entry->second : &double_named;
      material->folder = folder;
      continue;
    }
    if (material == nullptr) continue;
    const absl::Status status = ReadLine(key, line, *material);
    if (!status.ok()) {
      return InvalidArgument("{}:{}: {}", file, lines.number(), ToStd(status.message()));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadObjLooks(const ObjMaterial& material, const std::string& folder, bool has_uv,
                          FileMaterial& read, std::vector<std::string>& left_out) {
  PbrPictures& looks = read.looks.emplace();
  const bool has_map =
      has_uv && std::any_of(material.maps.begin(), material.maps.end(),
                            [](const auto& map) { return map.name == std::string_view("colour"); });
  looks.color = material.color.value_or(Vec3f::Constant(has_map ? 1.0f : 0.6f));
  if (has_map && looks.color.isZero(0)) {
    left_out.push_back("Kd 0 0 0 of material " + read.name + ", which has a colour map");
    looks.color.setOnes();
  }
  if (material.roughness) looks.roughness.factor = *material.roughness;
  if (material.metallic) looks.metallic.factor = *material.metallic;
  for (const std::string& what : material.left_out) {
    left_out.push_back(what + " of material " + read.name);
  }
  if (!has_uv) {
    if (!material.maps.empty()) {
      left_out.push_back("the maps of material " + read.name +
                         " on faces without texture coordinates");
    }
    return absl::OkStatus();
  }
  for (const ObjMaterial::Map& map : material.maps) {
    PbrPicture picture;
    std::string_view rest = map.options;
    double bump_scale = 1;
    for (const std::string& option : TakeOptions(rest, picture, &bump_scale)) {
      left_out.push_back(
          fmt::format("{} of the {} map of material {}", option, map.name, read.name));
    }
    const std::string name(rest);
    const bool is_beside_mtl = FindBeside(material.folder, name).ok();
    ASSIGN_OR_RETURN(picture.image, ReadBeside(is_beside_mtl ? material.folder : folder, name));
    read.maps.push_back(std::string(map.name) + " " + name);
    const std::string_view kind = map.name;
    if (kind == "colour") {
      looks.albedo = std::move(picture);
    } else if (kind == "normal") {
      looks.normal = std::move(picture);
      looks.normal_scale = static_cast<float>(bump_scale);
    } else if (kind == "metal") {
      looks.metallic = {material.metallic.value_or(1), std::move(picture), 0};
    } else {
      looks.roughness = {material.roughness.value_or(1), std::move(picture), 0};
    }
  }
  return absl::OkStatus();
}

}  // namespace parallax
