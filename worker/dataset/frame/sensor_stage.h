// The stage `sensor`: replaces the rendered pictures by those of a camera (worker/sensor), made
// from the linear pictures that a frame keeps. Like the stage `finish` it stores nothing of its
// own: the pictures are made when frames leave the store, with the same bytes everywhere. Ground
// truth, statistics and verdicts stay those of the rendered frame, so that variants with different
// sensors consist of the same pairs.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/jobs.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/sensor/take_picture.h"

namespace parallax {

// Returns the stage's key: the SHA-256, as hex, of its version, the config, and the hashes of those
// `files` of the frame that it reads.
std::string SensorKey(const v1::SensorConfig& config,
                      const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);

// Returns the names of the files of a frame that the stage reads.
std::vector<std::string> FilesForSensor(const v1::SensorConfig& config);

// Makes left.png, right.png and frame.json, by name. The last is the frame's own with an entry
// "sensor": the key and the drawn numbers. `path_of` returns the path of a file of the frame.
// Errors: kFailedPrecondition for a frame without linear pictures; kDataLoss for a frame.json
// without seeds; those of reading and of TakePicture.
absl::StatusOr<std::map<std::string, std::string>> MakeSensorFiles(
    const v1::SensorConfig& config, const std::string& key,
    const std::function<std::string(const std::string& name)>& path_of);

// Returns the key in a frame's frame.json; empty where the pictures are the rendered ones.
std::string SensorKeyOf(const nlohmann::ordered_json& frame_json);

// The pictures made again from the numbers in frame.json.
struct SensorPictures {
  ImageRgb8 left, right;
};
// Makes the pictures of a frame in the folder `dir` once more. Errors: those of MakeSensorFiles;
// kDataLoss for an entry "sensor" that lacks a number.
absl::StatusOr<SensorPictures> RepeatSensor(const nlohmann::ordered_json& frame_json,
                                            const std::string& dir);

// Takes the pictures of a frame in memory. `rig` and `frame` are `scale` times as large as those of
// the study, and so are the sensor's blurs; its noise is that of a pixel. Errors: as TypeOf and
// TakePicture.
absl::StatusOr<SensorPictures> TakeSensor(const v1::SensorConfig& config, const v1::Scene& scene,
                                          const v1::Rig& rig, const StereoFrame& frame,
                                          double scale = 1);

}  // namespace parallax
