// The folders and files of the user's own content that a study names.
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/study.pb.h"

namespace parallax {

// Returns the fields of `config` that name such folders, to be read or set: pictures, texture sets,
// surroundings, meshes. Fields that are empty are left out. Pointers hold as long as `config` is
// not changed otherwise; groups that the config does not have are not made.
inline std::vector<std::string*> ContentFoldersOf(v1::SceneConfig& config) {
  std::vector<std::string*> folders;
  if (!config.materials().picture_dir().empty()) {
    folders.push_back(config.mutable_materials()->mutable_picture_dir());
  }
  if (!config.materials().texture_dir().empty()) {
    folders.push_back(config.mutable_materials()->mutable_texture_dir());
  }
  if (!config.lighting().hdri_dir().empty()) {
    folders.push_back(config.mutable_lighting()->mutable_hdri_dir());
  }
  if (!config.assets().include().empty()) {
    for (std::string& folder : *config.mutable_assets()->mutable_include()) {
      folders.push_back(&folder);
    }
  }
  return folders;
}

// Returns the path that an own benchmark names: of a folder, or of a list.
inline const std::string& PathOfBenchmark(const v1::OwnBenchmark& own) {
  return own.list().empty() ? own.folder() : own.list();
}

// Sets that path.
inline void SetPath(const std::string& path, v1::OwnBenchmark& own) {
  own.list().empty() ? own.set_folder(path) : own.set_list(path);
}

}  // namespace parallax
