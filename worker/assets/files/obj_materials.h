// Materials of .mtl files. Thread-safe.   Source: Wavefront, "The .mtl file format".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {

// The lines of an .obj or .mtl: without byte order mark and comments, with those joined that end in
// a backslash.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text);
  // Takes the next line that is not empty; false at the end. The view holds until the next call.
  bool Next(std::string_view* line);
  int number() const { return number_; }  // The last line's, from 1.

 private:
  std::string_view text_;
  std::string joined_;
  int number_ = 0, next_number_ = 1;
};

// Takes the first word off a line; empty at its end.
std::string_view TakeObjWord(std::string_view& line);
// Reads a number as writers in any language have it ("1.5", "1,5"); nullopt for none.
std::optional<double> ObjNumber(std::string_view word);

// A material with the lines of its maps, whose pictures are read once they are needed.
struct ObjMaterial {
  struct Map {
    const char* name;     // "colour"
    std::string options;  // The line's rest: options, then the picture's name.
  };
  std::optional<Vec3f> color;
  std::optional<float> roughness, metallic;
  std::vector<Map> maps;
  std::vector<std::string> left_out;
  std::string folder;  // The folder of the .mtl.
};

// Reads a file's text into `materials`, where the first of a name stays. Errors: kInvalidArgument
// naming the line.
absl::Status ReadMtl(std::string_view text, const std::string& file, const std::string& folder,
                     std::map<std::string, ObjMaterial>& materials);

// Gives `read`, which has its name, the looks of a material. Without Kd its colour map counts
// alone, as beside the black of writers that leave Kd 0; without either it is grey, 0.6. Pictures
// lie beside its .mtl or in `folder`. Errors: kInvalidArgument naming the picture.
absl::Status ReadObjLooks(const ObjMaterial& material, const std::string& folder, bool has_uv,
                          FileMaterial& read, std::vector<std::string>& left_out);

}  // namespace parallax
