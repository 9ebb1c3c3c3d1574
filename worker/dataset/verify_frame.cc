#include "worker/dataset/verify_frame.h"

#include <fmt/core.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "common/base/file.h"
#include "common/base/hash.h"
#include "common/image/io.h"
#include "common/math/types.h"
#include "worker/dataset/frame_reader.h"
#include "worker/dataset/sensor_stage.h"
#include "worker/dataset/statistics.h"
#include "worker/dataset/verify_infrared.h"
#include "worker/dataset/verify_raw.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kReprojection = 0.01;        // Relative to the depth: the seed's threshold.
constexpr double kMostReprojected = 1e-3;     // Part of the pixels that may be judged otherwise.
constexpr double kRounding_px = 1e-3;         // Depth is a float: it rounds where a point lands.
constexpr double kDisparityTolerance = 1e-6;  // Relative, and half a float's last digit.
constexpr uint8_t kSky = 1, kKnownBits = 1 | 2 | 4 | 8 | 16 | 32;

struct Eye {
  std::string name;
  ImageRgb8 color;
  ImageF depth, disparity;
  ImageU8 occlusion, exact_occlusion, masks;
  ImageU16 objects, materials;
  ImageF3 normals;
};

class FrameChecker {
 public:
  FrameChecker(const DatasetFrame& frame, std::vector<Finding>& findings)
      : frame_(frame), findings_(findings) {}

  void Run() {
    if (!ReadNumbers()) return;
    CheckPoses();
    for (Eye& eye : eyes_) ReadEye(eye);
    for (const Eye& eye : eyes_) {
      CheckDepth(eye);
      CheckTables(eye.objects, eye, "objects");
      CheckTables(eye.materials, eye, "materials");
      CheckMasks(eye);
      CheckNormals(eye);
    }
    CheckOcclusion(eyes_[0], eyes_[1], -1);
    CheckOcclusion(eyes_[1], eyes_[0], 1);
    CheckExactOcclusion(eyes_[0], -1);
    CheckExactOcclusion(eyes_[1], 1);
    CheckIndex();
    if (json_.contains("raw")) Append(CheckRawPair(frame_, json_));
    if (json_.contains("infrared")) Append(CheckInfrared(frame_, json_));
  }

 private:
  void Append(std::vector<Finding> found) {
    for (Finding& finding : found) findings_.push_back(std::move(finding));
  }

  void Find(const char* check, const std::string& file, const std::string& message) {
    findings_.push_back({check, frame_.dir + (file.empty() ? "" : "/" + file), message});
  }

  bool ReadNumbers() {
    absl::StatusOr<Json> json = ReadFrameJson(frame_.dir);
    if (!json.ok()) {
      Find("frame.json", "frame.json", std::string(ToStd(json.status().message())));
      return false;
    }
    json_ = *std::move(json);
    try {
      k_ = IntrinsicsIn(json_);
      baseline_m_ = json_.at("baseline_m");
      const char* keys[] = {"world_from_left", "world_from_right"};
      for (size_t eye = 0; eye < 2; ++eye) {
        for (size_t i = 0; i < 4; ++i) {
          for (size_t j = 0; j < 4; ++j) {
            pose_[eye](static_cast<int>(i), static_cast<int>(j)) =
                json_.at(keys[eye]).at(i).at(j).get<double>();
          }
        }
      }
    } catch (const Json::exception& error) {
      Find("frame.json", "frame.json", error.what());
      return false;
    }
    if (!(k_.fx > 0 && k_.fy > 0 && k_.width > 0 && k_.height > 0 && baseline_m_ > 0)) {
      Find("frame.json", "frame.json", "intrinsics and baseline must be positive");
      return false;
    }
    return true;
  }

  void CheckPoses() {
    const char* keys[] = {"world_from_left", "world_from_right"};
    for (size_t eye = 0; eye < 2; ++eye) {
      const Eigen::Matrix3d r = pose_[eye].topLeftCorner<3, 3>();
      const double off = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
      const double row = (pose_[eye].row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff();
      if (!pose_[eye].allFinite() || off > 1e-6 || row > 1e-12 || r.determinant() < 0) {
        Find("pose", "frame.json", std::string(keys[eye]) + " is not a rotation and a translation");
        return;
      }
    }
    const double turned =
        (pose_[0].topLeftCorner<3, 3>() - pose_[1].topLeftCorner<3, 3>()).cwiseAbs().maxCoeff();
    if (turned > 1e-9) Find("pose", "frame.json", "the two cameras are turned against each other");
    const Vec3d expected =
        pose_[0].topRightCorner<3, 1>() + baseline_m_ * pose_[0].topLeftCorner<3, 1>();
    const double off = (expected - Vec3d(pose_[1].topRightCorner<3, 1>())).norm();
    if (off > 1e-6) {
      Find("pose", "frame.json",
           fmt::format(
               "the right camera is {:.9g} m from where the baseline ({:.9g} m along +x) puts it",
               off, baseline_m_));
    }
  }

  template <typename ImageType>
  void Read(const std::string& file, absl::StatusOr<ImageType> (*read)(const std::string&),
            ImageType& image) {
    absl::StatusOr<ImageType> result = read(frame_.dir + "/" + file);
    if (absl::IsNotFound(result.status())) return;  // CheckFiles knows what must be there.
    if (!result.ok()) {
      Find("image", file, std::string(ToStd(result.status().message())));
      return;
    }
    if (result->width() != k_.width || result->height() != k_.height) {
      Find("size", file,
           fmt::format("{}x{}, frame.json says {}x{}", result->width(), result->height(), k_.width,
                       k_.height));
      return;
    }
    image = *std::move(result);
  }

  void ReadEye(Eye& eye) {
    Read(eye.name + ".png", &ReadPngRgb8, eye.color);
    Read("depth_" + eye.name + ".exr", &ReadExrY, eye.depth);
    Read("disparity_" + eye.name + ".exr", &ReadExrY, eye.disparity);
    Read("occlusion_" + eye.name + ".png", &ReadPngU8, eye.occlusion);
    Read("exact_occlusion_" + eye.name + ".png", &ReadPngU8, eye.exact_occlusion);
    Read("masks_" + eye.name + ".png", &ReadPngU8, eye.masks);
    Read("objects_" + eye.name + ".png", &ReadPngU16, eye.objects);
    Read("materials_" + eye.name + ".png", &ReadPngU16, eye.materials);
    Read("normals_" + eye.name + ".exr", &ReadExrRgb, eye.normals);
  }

  // "(12, 34)" of the pixel with this number.
  std::string At(size_t i) const {
    const auto w = static_cast<size_t>(k_.width);
    return fmt::format("({}, {})", i % w, i / w);
  }

  // Counts the pixels that break a rule and reports the first.
  template <typename Bad, typename Describe>
  void Pixels(const char* check, const std::string& file, const Bad& bad, const Describe& describe,
              double tolerated = 0) {
    const size_t total = static_cast<size_t>(k_.width) * static_cast<size_t>(k_.height);
    size_t count = 0, first = 0;
    for (size_t i = 0; i < total; ++i) {
      if (!bad(i)) continue;
      if (count++ == 0) first = i;
    }
    if (static_cast<double>(count) <= tolerated * static_cast<double>(total)) return;
    Find(check, file,
         fmt::format("{} of {} pixels, the first at {}: {}", count, total, At(first),
                     describe(first)));
  }

  void CheckDepth(const Eye& eye) {
    const std::string depth_file = "depth_" + eye.name + ".exr";
    const std::string disparity_file = "disparity_" + eye.name + ".exr";
    const auto value = [](const ImageF& image, size_t i) { return double{image.values()[i]}; };
    const auto broken = [](double v) { return !std::isfinite(v) || v < 0; };
    if (!eye.depth.empty()) {
      Pixels(
          "finite", depth_file, [&](size_t i) { return broken(value(eye.depth, i)); },
          [&](size_t i) {
            return fmt::format("{:.9g}, wanted a number >= 0", value(eye.depth, i));
          });
    }
    if (eye.disparity.empty()) return;
    Pixels(
        "finite", disparity_file, [&](size_t i) { return broken(value(eye.disparity, i)); },
        [&](size_t i) {
          return fmt::format("{:.9g}, wanted a number >= 0", value(eye.disparity, i));
        });
    if (eye.depth.empty()) return;
    const auto expected = [&](size_t i) {
      const double z = value(eye.depth, i);
      return z > 0 ? k_.fx * baseline_m_ / z : 0.0;
    };
    Pixels(
        "disparity", disparity_file,
        [&](size_t i) {
          const double seen = value(eye.disparity, i), want = expected(i);
          return !(std::abs(seen - want) <= kDisparityTolerance * want);
        },
        [&](size_t i) {
          return fmt::format("{:.9g}, fx * baseline / depth is {:.9g}", value(eye.disparity, i),
                             expected(i));
        });
  }

  void CheckTables(const ImageU16& indices, const Eye& eye, const char* table) {
    if (indices.empty()) return;
    const std::string file = std::string(table) + "_" + eye.name + ".png";
    if (!json_.contains(table) || !json_[table].is_object()) {
      Find("tables", "frame.json", std::string("no table \"") + table + "\"");
      return;
    }
    std::set<uint32_t> known = {0};
    for (const auto& [key, entry] : json_[table].items()) {
      known.insert(static_cast<uint32_t>(std::strtoul(key.c_str(), nullptr, 10)));
      for (const char* field : {"class", "name", "seed"}) {
        if (!entry.is_object() || !entry.contains(field)) {
          Find("tables", "frame.json", std::string(table) + " " + key + " has no " + field);
          return;
        }
      }
      if (!SeedOf(entry["seed"])) {
        Find("tables", "frame.json", std::string(table) + " " + key + ": its seed is no number");
        return;
      }
    }
    std::vector<bool> fine(1 << 16);
    for (const uint32_t index : known) {
      if (index < fine.size()) fine[index] = true;
    }
    Pixels(
        "tables", file, [&](size_t i) { return !fine[indices.values()[i]]; },
        [&](size_t i) { return fmt::format("index {} is not in the table", indices.values()[i]); });
    if (eye.depth.empty() || std::string(table) != "objects") return;
    Pixels(
        "tables", file,
        [&](size_t i) { return (indices.values()[i] != 0) != (eye.depth.values()[i] > 0); },
        [&](size_t i) {
          return fmt::format("object {} at depth {:.9g}", indices.values()[i],
                             double{eye.depth.values()[i]});
        });
  }

  void CheckMasks(const Eye& eye) {
    if (eye.masks.empty()) return;
    const std::string file = "masks_" + eye.name + ".png";
    Pixels(
        "masks", file, [&](size_t i) { return (eye.masks.values()[i] & ~kKnownBits) != 0; },
        [&](size_t i) { return fmt::format("unknown bits in {}", eye.masks.values()[i]); });
    if (eye.depth.empty()) return;
    Pixels(
        "masks", file,
        [&](size_t i) {
          return ((eye.masks.values()[i] & kSky) != 0) != (eye.depth.values()[i] == 0);
        },
        [&](size_t i) {
          return fmt::format("{} at depth {:.9g}",
                             (eye.masks.values()[i] & kSky) ? "sky" : "no sky",
                             double{eye.depth.values()[i]});
        });
  }

  void CheckNormals(const Eye& eye) {
    if (eye.normals.empty()) return;
    const std::string file = "normals_" + eye.name + ".exr";
    const auto normal = [&](size_t i) {
      const float* n = &eye.normals.values()[3 * i];
      return Vec3d(double{n[0]}, double{n[1]}, double{n[2]});
    };
    const auto has_surface = [&](size_t i) {
      return eye.depth.empty() ? normal(i).norm() > 0 : eye.depth.values()[i] > 0;
    };
    // Half floats have eleven bits.
    Pixels(
        "normals", file,
        [&](size_t i) {
          const double length = normal(i).norm();
          return has_surface(i) ? !(std::abs(length - 1) < 3e-3) : length != 0;
        },
        [&](size_t i) { return fmt::format("length {:.9g}", normal(i).norm()); });
    Pixels(
        "normals", file,
        [&](size_t i) {
          const auto w = static_cast<size_t>(k_.width);
          const Vec3d ray((static_cast<double>(i % w) + 0.5 - k_.cx) / k_.fx,
                          (static_cast<double>(i / w) + 0.5 - k_.cy) / k_.fy, 1);
          return has_surface(i) && normal(i).dot(ray.normalized()) > 3e-3;
        },
        [&](size_t) { return std::string("turned away from the camera"); });
  }

  void CheckBinary(const ImageU8& image, const char* check, const std::string& file) {
    Pixels(
        check, file, [&](size_t i) { return image.values()[i] != 0 && image.values()[i] != 255; },
        [&](size_t i) { return fmt::format("{}, wanted 0 or 255", image.values()[i]); });
  }

  // What the other eye's picture leaves out is occluded. What hides the rest can't be told from
  // maps: rays found it between their pixels.
  void CheckExactOcclusion(const Eye& eye, double sign) {
    if (eye.exact_occlusion.empty()) return;
    const std::string file = "exact_occlusion_" + eye.name + ".png";
    CheckBinary(eye.exact_occlusion, "exact_occlusion", file);
    if (eye.depth.empty()) return;
    Pixels(
        "exact_occlusion", file,
        [&](size_t i) {
          const double z = double{eye.depth.values()[i]};
          if (!(z > 0) || eye.exact_occlusion.values()[i] != 0) return false;
          const auto w = static_cast<size_t>(k_.width);
          const double x = static_cast<double>(i % w) + 0.5 + sign * k_.fx * baseline_m_ / z;
          return x < -kRounding_px || x > k_.width + kRounding_px;
        },
        [&](size_t) { return std::string("visible, but outside of the other picture"); });
  }

  // Recomputes left-right consistency from depth alone.
  void CheckOcclusion(const Eye& eye, const Eye& other, double sign) {
    if (eye.occlusion.empty()) return;
    const std::string file = "occlusion_" + eye.name + ".png";
    CheckBinary(eye.occlusion, "occlusion", file);
    if (eye.depth.empty() || other.depth.empty()) return;
    const auto visible = [&](size_t i) {
      const auto w = static_cast<size_t>(k_.width);
      const double z = double{eye.depth.values()[i]};
      const float* row = &other.depth.values()[i / w * w];
      if (!(z > 0)) return !(row[i % w] > 0);
      const double x = static_cast<double>(i % w) + 0.5 + sign * k_.fx * baseline_m_ / z;
      if (x < 0 || x >= k_.width) return false;
      const double c = std::clamp(x - 0.5, 0.0, k_.width - 1.0);
      const auto x0 = static_cast<size_t>(c), x1 = std::min(x0 + 1, w - 1);
      const double a = double{row[x0]}, b = double{row[x1]};
      const auto agrees = [&](double d) { return d > 0 && std::abs(d - z) <= kReprojection * z; };
      if (agrees(a) || agrees(b)) return true;
      const double t = c - static_cast<double>(x0);
      return a > 0 && b > 0 && agrees(1 / ((1 - t) / a + t / b));
    };
    Pixels(
        "occlusion", file, [&](size_t i) { return (eye.occlusion.values()[i] == 0) != visible(i); },
        [&](size_t i) {
          return std::string(eye.occlusion.values()[i] ? "occluded" : "visible") +
                 ", re-projection says otherwise";
        },
        kMostReprojected);
  }

  // Compares the index with the maps.
  void CheckIndex() {
    const Json& line = frame_.line;
    bool passed = true;
    if (line.contains("filters") && line["filters"].is_object()) {
      for (const auto& [name, verdict] : line["filters"].items()) {
        if (!verdict.is_object() || !verdict.contains("passed") || !verdict.contains("value") ||
            !verdict.contains("threshold")) {
          Find("filters", "", "the verdict of \"" + name + "\" lacks passed, value or threshold");
          continue;
        }
        const double value = verdict["value"], threshold = verdict["threshold"];
        const bool is_distance = name == "near" || name == "close";
        const bool is_ambiguous = name == "ambiguous";
        const bool expected =
            is_ambiguous ? value <= threshold : value >= threshold || (is_distance && value == 0);
        passed = passed && verdict["passed"].get<bool>();
        if (verdict["passed"].get<bool>() != expected) {
          Find("filters", "",
               fmt::format("\"{}\" {} with {:.9g}, its threshold is {:.9g}", name,
                           expected ? "failed" : "passed", value, threshold));
        }
        if (is_distance) CompareNearest(name, value);
        if (name == "dark") CompareMean(value);
        if (name == "textureless") CompareTexture(value);
        if (is_ambiguous) CompareShare(value);
      }
    } else {
      Find("filters", "", "the index has no filter verdicts for it");
    }
    if (frame_.passed != passed) Find("filters", "", "passed contradicts the verdicts");
  }

  void CompareNearest(const std::string& name, double value) {
    if (eyes_[0].depth.empty() || eyes_[1].depth.empty()) return;
    double nearest = 0;
    for (const Eye& eye : eyes_) {
      for (const float z : eye.depth.values()) {
        if (z > 0 && (nearest == 0 || double{z} < nearest)) nearest = double{z};
      }
    }
    if (std::abs(nearest - value) > 1e-6 * nearest) {
      Find("filters", "",
           fmt::format("\"{}\" judged a nearest depth of {:.9g} m, the maps have {:.9g}", name,
                       value, nearest));
    }
  }

  // The maps can't tell a network's score, so the verdict is compared with the index's statistics.
  void CompareShare(double value) {
    const Json share =
        frame_.line.value("statistics", Json::object()).value("ambiguous_share", Json());
    if (share.is_number() && share.get<double>() == value && value >= 0 && value <= 1) return;
    Find("filters", "",
         fmt::format("\"ambiguous\" judged a share of {:.9g}, the statistics have {}", value,
                     share.dump()));
  }

  void CompareTexture(double value) {
    const Eye& left = eyes_[0];
    if (left.color.empty() || left.depth.empty() || !SensorKeyOf(json_).empty()) return;
    const double share = TexturedFraction(left.color, left.depth);
    if (std::abs(share - value) <= 1e-9) return;
    Find("filters", "",
         fmt::format("\"textureless\" judged a share of {:.9g}, the maps have {:.9g}", value,
                     share));
  }

  void CompareMean(double value) {
    const ImageRgb8& image = eyes_[0].color;
    if (image.empty() || !SensorKeyOf(json_).empty()) return;  // A sensor's: CheckLight compares.
    double sum = 0;
    for (const uint8_t v : image.values()) sum += v;
    const double mean = sum / static_cast<double>(image.values().size());
    if (std::abs(mean - value) > 1e-6 * std::max(1.0, mean)) {
      Find("filters", "",
           fmt::format("\"dark\" judged a mean intensity of {:.9g}, left.png has {:.9g}", value,
                       mean));
    }
  }

  const DatasetFrame& frame_;
  std::vector<Finding>& findings_;
  Json json_;
  FrameIntrinsics k_;
  double baseline_m_ = 0;
  std::array<Eigen::Matrix4d, 2> pose_;
  std::array<Eye, 2> eyes_ = {Eye{"left", {}, {}, {}, {}, {}, {}, {}, {}},
                              Eye{"right", {}, {}, {}, {}, {}, {}, {}, {}}};
};

}  // namespace

void CheckFiles(const DatasetFrame& frame, bool hashes, std::vector<Finding>& findings,
                int64_t& bytes) {
  const auto find = [&](const char* check, const std::string& file, const std::string& message) {
    findings.push_back({check, frame.dir + "/" + file, message});
  };
  for (const char* name : {"left.png", "right.png", "frame.json"}) {
    if (!frame.files.contains(name)) find("missing", name, "not in the index");
  }
  for (const auto& [name, hash] : frame.files) {
    struct stat info {};
    if (::stat((frame.dir + "/" + name).c_str(), &info) != 0) {
      find("missing", name, "the index has it, the disk has not");
      continue;
    }
    bytes += info.st_size;
    if (!hashes) continue;
    const absl::StatusOr<std::string> seen = Sha256HexOfFile(frame.dir + "/" + name);
    if (!seen.ok()) {
      find("hash", name, std::string(ToStd(seen.status().message())));
    } else if (*seen != hash) {
      find("hash", name,
           "SHA-256 is " + seen->substr(0, 12) + "..., the index says " + hash.substr(0, 12) +
               "...");
    }
  }
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(frame.dir, error)) {
    const std::string name = entry.path().filename();
    if (!frame.files.contains(name)) find("stray", name, "not in the index");
  }
}

void CheckGeometry(const DatasetFrame& frame, std::vector<Finding>& findings) {
  try {
    FrameChecker(frame, findings).Run();
  } catch (const Json::exception& error) {
    findings.push_back({"index", frame.dir, error.what()});
  }
}

}  // namespace parallax
