// The dataset folder that users get: published frames of a study, copied from the store into the
// tree of the dataset format, with index, recipes, dataset card and study files.
//
//   <out>/study.yaml  study.lock.yaml
//   <out>/<variant>/index.jsonl  dataset.json  README.md  LICENSE  croissant.json
//   <out>/<variant>/scenes/<scene>.pb
//   <out>/<variant>/frames/<scene>/<rig>/...
//
// Files are hard links into the store, or copies where links are impossible. A frame's folder
// appears only when it is complete; equal frames that exist are left alone, so adding all frames
// again does nothing. Links to files that the store has no longer are compared by their hashes.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// Writes one archive. Not thread-safe; one writer a folder at a time.
//
//   ASSIGN_OR_RETURN(auto archive, ArchiveWriter::Open(out, study));
//   for (const v1::PublishedFrame& frame : frames) {
//     if (!archive->HasScene(frame.variant(), frame.scene())) archive->AddScene(...GetScene...);
//     archive->AddFrame(frame, store_folder);
//   }
//   archive->Finish();
class ArchiveWriter {
 public:
  struct Totals {
    int64_t frames_added = 0;
    int64_t frames_present = 0;   // Existed already and are equal.
    int64_t frames_replaced = 0;  // Existed with other content.
    int64_t files_linked = 0;
    int64_t files_copied = 0;  // Copied because the store is on another device.
  };

  // Makes the folder, writes study.yaml and study.lock.yaml and reads the index files of an earlier
  // run; its frames get the verdicts of this study's filters. The study may have changed since:
  // what it no longer asks for is put aside (study_change.h). Errors: kFailedPrecondition when the
  // folder belongs to a study of another name or seed, or to other versions of the stages, and when
  // a frame's statistics lack a number that a filter needs; kPermissionDenied and
  // kResourceExhausted from the disk.
  static absl::StatusOr<std::unique_ptr<ArchiveWriter>> Open(const std::string& out_dir,
                                                             const v1::StudySpec& study);
  virtual ~ArchiveWriter() = default;

  // Returns whether the scene's recipe is there and can be read.
  virtual bool HasScene(const std::string& variant, uint32_t scene) const = 0;
  // Writes <variant>/scenes/<scene>.pb. Errors: kInvalidArgument for an unknown variant; as
  // WriteFileAtomically.
  virtual absl::Status AddScene(const std::string& variant, uint32_t scene,
                                const v1::Scene& recipe) = 0;

  // Links or copies the frame's files from `store_dir`/<frame.path>; `store_dir` is a local folder.
  // Errors: kNotFound for a file that the store lacks, kDataLoss when its size is not the
  // manifest's, kInvalidArgument for a path that leaves the store or an unknown variant.
  virtual absl::Status AddFrame(const v1::PublishedFrame& frame, const std::string& store_dir) = 0;

  // Writes each variant's index.jsonl (sorted by scene, rig), dataset.json, README.md,
  // croissant.json and LICENSE; an existing LICENSE stays. May be called repeatedly. Errors: those
  // of WriteDatasetCard.
  virtual absl::Status Finish() = 0;

  virtual const Totals& totals() const = 0;
  // Returns what Open put aside because the study has changed, a text each with its new place.
  virtual const std::vector<std::string>& set_aside() const = 0;
  // Returns the number of frames in the archive, by variant.
  virtual std::map<std::string, int64_t> Frames() const = 0;
};

}  // namespace parallax
