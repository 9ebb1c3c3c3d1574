#include "worker/dataset/verify/verify_flow.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "parallax/v1/scene.pb.h"
#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kFlowTolerance_px = 2e-3;
constexpr double kFlowTolerance = 2e-5;  // Relative to the flow's length.
constexpr double kPoseTolerance = 1e-6;
constexpr double kReprojected = 0.01;  // Relative to the depth.
// Share of the pixels that depth at the neighbour's pixel centres judges otherwise than rays do:
// what is hidden by something thinner than a pixel.
constexpr double kMostOtherwise = 0.02;
constexpr uint8_t kNone = 128, kHidden = 255;

std::string ThreeDigits(uint32_t number) { return fmt::format("{:03}", number); }

// World from camera, worked out anew from a quaternion.
Eigen::Isometry3d PoseOf(const v1::Transform& t) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      Eigen::Quaterniond(t.qw(), t.qx(), t.qy(), t.qz()).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(t.tx(), t.ty(), t.tz());
  return pose;
}

Eigen::Affine3d PlaceAt(const v1::SceneObject& object, double time_s) {
  const v1::Vec3 &v = object.motion().velocity_mps(), &w = object.motion().spin_rps();
  const Eigen::Vector3d spin(w.x(), w.y(), w.z());
  const double angle = spin.norm() * time_s;
  const Eigen::Matrix3d turn = spin.norm() > 0
                                   ? Eigen::AngleAxisd(angle, spin.normalized()).toRotationMatrix()
                                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Eigen::Isometry3d rest = PoseOf(object.world_from_object());
  Eigen::Affine3d place;
  place.linear() = turn * rest.linear() * object.world_from_object().scale();
  place.translation() = rest.translation() + time_s * Eigen::Vector3d(v.x(), v.y(), v.z());
  return place;
}

// One eye of a rig.
struct FlowCamera {
  Eigen::Isometry3d world_from_eye;
  double fx, fy, cx, cy, baseline_m;

  FlowCamera(const v1::Rig& rig, int eye)
      : world_from_eye(PoseOf(rig.world_from_left())),
        fx(rig.fx_px()),
        fy(rig.fy_px()),
        cx(rig.cx_px()),
        cy(rig.cy_px()),
        baseline_m(rig.baseline_m()) {
    world_from_eye.translation() += eye * rig.baseline_m() * world_from_eye.linear().col(0);
  }
};

class FlowChecker {
 public:
  FlowChecker(const DatasetFrame& frame, std::vector<Finding>& findings)
      : frame_(frame), findings_(findings) {}

  void Run() {
    const auto json = ReadFrameJson(frame_.dir);
    if (!json.ok()) return;  // CheckGeometry reports it.
    const bool flow = frame_.files.contains("flow_forward_left.exr");
    if (!flow && !json->contains("sequence") && !json->contains("moving")) return;
    if (!ReadRecipe()) return;  // CheckRecipes reports it.
    CheckJson(*json);
    if (!flow) return;
    for (int eye = 0; eye < 2; ++eye) {
      CheckEye(eye, "forward", next_);
      CheckEye(eye, "backward", previous_);
    }
  }

 private:
  void Find(const std::string& file, const std::string& message) {
    findings_.push_back({"flow", frame_.dir + "/" + file, message});
  }

  bool ReadRecipe() {
    // VARIANT/frames/SCENE/RIG
    const fs::path scene = fs::path(frame_.dir).parent_path();
    const absl::StatusOr<std::string> bytes = ReadFile(
        scene.parent_path().parent_path() / "scenes" / (scene.filename().string() + ".pb"));
    if (!bytes.ok() || !recipe_.ParseFromString(*bytes)) return false;
    for (const v1::Rig& rig : recipe_.rigs()) {
      if (rig.index() == frame_.rig) rig_ = &rig;
    }
    if (!rig_) return false;
    FindNeighbours();
    return true;
  }

  // Rigs of the same way and baseline just before and after in time.
  void FindNeighbours() {
    if (rig_->path() == 0) return;
    // Which of the right eyes of its left one each has.
    std::map<uint32_t, int> number;
    int last = 0;
    for (const v1::Rig& rig : recipe_.rigs()) {
      number[rig.index()] = last = rig.shares_left() ? last + 1 : 0;
    }
    for (const v1::Rig& rig : recipe_.rigs()) {
      if (rig.path() != rig_->path() || number[rig.index()] != number[rig_->index()]) continue;
      const double ahead = rig.time_s() - rig_->time_s();
      if (ahead > 0 && (!next_ || rig.time_s() < next_->time_s())) next_ = &rig;
      if (ahead < 0 && (!previous_ || rig.time_s() > previous_->time_s())) previous_ = &rig;
    }
  }

  void CheckJson(const Json& json) {
    const auto number = [](const v1::Rig* rig) { return rig ? Json(rig->index()) : Json(); };
    if (rig_->path() > 0) {
      const Json wanted = {{"path", rig_->path()},
                           {"time_s", rig_->time_s()},
                           {"previous", number(previous_)},
                           {"next", number(next_)}};
      const Json seen = json.value("sequence", Json());
      if (seen != wanted) {
        Find("frame.json", "sequence is " + seen.dump() + ", the recipe says " + wanted.dump());
      }
    }
    // Frames before version 26 have none.
    if (json.contains("motion")) CheckMotion(json["motion"]);
    const Json moving = json.value("moving", Json::object());
    for (const v1::SceneObject& object : recipe_.objects()) {
      if (object.has_motion()) CheckPlace(object, moving);
    }
  }

  // Moved and turned as `motion` says, the rig comes from the frame before to the one after.
  void CheckMotion(const Json& motion) {
    const v1::Rig& from = previous_ ? *previous_ : *rig_;
    const v1::Rig& to = next_ ? *next_ : *rig_;
    const double passes_s = to.time_s() - from.time_s();
    Eigen::Vector3d moved, turned;
    for (int i = 0; i < 3; ++i) {
      const auto at = static_cast<size_t>(i);
      moved[i] = passes_s * motion.at("velocity_m_s").at(at).get<double>();
      turned[i] = passes_s * motion.at("turn_rad_s").at(at).get<double>();
    }
    const Eigen::Matrix3d axes = PoseOf(rig_->world_from_left()).linear();
    Eigen::Isometry3d reached = PoseOf(from.world_from_left());
    reached.translation() += axes * moved;
    if (turned.norm() > 0) {
      reached.linear() =
          Eigen::AngleAxisd(turned.norm(), axes * turned.normalized()) * reached.linear();
    }
    const Eigen::Isometry3d wanted = PoseOf(to.world_from_left());
    if ((reached.matrix() - wanted.matrix()).cwiseAbs().maxCoeff() <= kPoseTolerance) return;
    Find("frame.json", "motion is " + motion.dump() + ", not that of the recipe's poses");
  }

  void CheckPlace(const v1::SceneObject& object, const Json& moving) {
    const std::string index = std::to_string(object.index());
    if (!moving.contains(index)) {
      return Find("frame.json", "moving has no object " + index + ", which moves in the recipe");
    }
    const Eigen::Matrix4d wanted = PlaceAt(object, rig_->time_s()).matrix();
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 4; ++j) {
        const double off = moving[index].at(i).at(j).get<double>() -
                           wanted(static_cast<int>(i), static_cast<int>(j));
        if (std::abs(off) <= kPoseTolerance) continue;
        return Find("frame.json",
                    "moving: object " + index + " is not where the recipe's motion puts it");
      }
    }
  }

  template <typename ImageType>
  bool Read(const std::string& dir, const std::string& file,
            absl::StatusOr<ImageType> (*read)(const std::string&), ImageType& image) {
    absl::StatusOr<ImageType> result = read(dir + "/" + file);
    if (!result.ok() || result->width() != rig_->width_px() ||
        result->height() != rig_->height_px()) {
      return false;
    }
    image = *std::move(result);
    return true;
  }

  void CheckEye(int eye, const std::string& direction, const v1::Rig* then) {
    const std::string side = eye == 0 ? "left" : "right";
    const std::string name = "flow_" + direction + "_" + side + ".exr";
    const std::string mask_name = "flow_occlusion_" + direction + "_" + side + ".png";
    ImageF3 flow;
    ImageU8 mask;
    if (!Read(frame_.dir, name, &ReadExrRgb, flow)) return Find(name, "can't be read at its size");
    if (!Read(frame_.dir, mask_name, &ReadPngU8, mask)) {
      return Find(mask_name, "can't be read at its size");
    }
    if (!then) return CheckNone(name, flow, mask);
    ImageF depth, other;
    ImageU16 objects;
    // Depth and objects are what flow is worked out from; without them there is nothing to compare.
    if (!Read(frame_.dir, "depth_" + side + ".exr", &ReadExrY, depth) ||
        !Read(frame_.dir, "objects_" + side + ".png", &ReadPngU16, objects)) {
      return;
    }
    const std::string neighbour =
        fs::path(frame_.dir).parent_path().string() + "/" + ThreeDigits(then->index());
    Read(neighbour, "depth_" + side + ".exr", &ReadExrY, other);
    ComparePixels(
        {FlowCamera(*rig_, eye), FlowCamera(*then, eye), MotionTo(*then), name, mask_name}, flow,
        mask, depth, objects, other);
  }

  void CheckNone(const std::string& name, const ImageF3& flow, const ImageU8& mask) {
    const bool still =
        std::all_of(flow.values().begin(), flow.values().end(), [](float v) { return v == 0; });
    const bool none = std::all_of(mask.values().begin(), mask.values().end(),
                                  [](uint8_t v) { return v == kNone; });
    if (!still || !none) Find(name, "has flow, but there is no such neighbour");
  }

  std::map<uint32_t, Eigen::Affine3d> MotionTo(const v1::Rig& then) const {
    std::map<uint32_t, Eigen::Affine3d> motions;
    for (const v1::SceneObject& object : recipe_.objects()) {
      if (!object.has_motion()) continue;
      motions[object.index()] =
          PlaceAt(object, then.time_s()) * PlaceAt(object, rig_->time_s()).inverse();
    }
    return motions;
  }

  struct Comparison {
    FlowCamera now, then;
    std::map<uint32_t, Eigen::Affine3d> motions;
    std::string name, mask_name;
  };

  // In the neighbour's camera; without surface a direction.
  static Eigen::Vector3d PointThen(const Comparison& c, int x, int y, double depth,
                                   uint32_t object) {
    const Eigen::Vector3d ray((x + 0.5 - c.now.cx) / c.now.fx, (y + 0.5 - c.now.cy) / c.now.fy, 1);
    if (!(depth > 0)) {
      return c.then.world_from_eye.linear().transpose() * (c.now.world_from_eye.linear() * ray);
    }
    Eigen::Vector3d point = c.now.world_from_eye * Eigen::Vector3d(depth * ray);
    const auto motion = c.motions.find(object);
    if (motion != c.motions.end()) point = motion->second * point;
    return c.then.world_from_eye.inverse() * point;
  }

  void ComparePixels(const Comparison& c, const ImageF3& flow, const ImageU8& mask,
                     const ImageF& depth, const ImageU16& objects, const ImageF& other) {
    int64_t otherwise = 0, judged = 0;
    for (int y = 0; y < depth.height(); ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        const std::string at = fmt::format("({}, {})", x, y);
        const double z = depth(x, y);
        const Eigen::Vector3d then = PointThen(c, x, y, z, objects(x, y));
        const float* seen = flow.At(x, y);
        const uint8_t value = mask(x, y);
        if (value != 0 && value != kNone && value != kHidden) {
          return Find(c.mask_name, fmt::format("{}: {}, wanted 0, 128 or 255", at, value));
        }
        if (then.z() <= 1e-5 || value == kNone) {
          if (value == kNone && then.z() > 1e-5) {
            return Find(c.mask_name, at + " has no flow, but lies before the neighbour's camera");
          }
          continue;
        }
        const Eigen::Vector2d end(c.then.cx + c.then.fx * then.x() / then.z(),
                                  c.then.cy + c.then.fy * then.y() / then.z());
        Eigen::Vector3d wanted(end.x() - x - 0.5, end.y() - y - 0.5, 0);
        if (z > 0) {
          wanted.z() = c.then.fx * c.then.baseline_m / then.z() - c.now.fx * c.now.baseline_m / z;
        }
        const Eigen::Vector3d off =
            Eigen::Vector3d(double{seen[0]}, double{seen[1]}, double{seen[2]}) - wanted;
        if (!(off.cwiseAbs().maxCoeff() <= kFlowTolerance_px + kFlowTolerance * wanted.norm())) {
          return Find(
              c.name,
              fmt::format("{}: {:.6g} {:.6g} {:.6g}, depth and motion give {:.6g} {:.6g} {:.6g}",
                          at, double{seen[0]}, double{seen[1]}, double{seen[2]}, wanted.x(),
                          wanted.y(), wanted.z()));
        }
        const Sight sight = SightOf(other, end, z > 0 ? then.z() : 0, depth);
        if (sight == Sight::kUnknown) continue;
        ++judged;
        otherwise += value == 0 ? sight == Sight::kHidden : sight == Sight::kVisible;
      }
    }
    if (static_cast<double>(otherwise) <= kMostOtherwise * static_cast<double>(judged)) return;
    Find(c.mask_name, fmt::format("{} of {} pixels are judged otherwise by the neighbour's depth",
                                  otherwise, judged));
  }

  enum class Sight { kUnknown, kHidden, kVisible, kAtEdge };

  // How the neighbour's depth shows a point of this depth (0: sky), by the pixels around it. At
  // edges of things they differ, and rays between them may go either way.
  static Sight SightOf(const ImageF& other, const Eigen::Vector2d& at, double depth,
                       const ImageF& own) {
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() < own.width() && at.y() < own.height())) {
      return Sight::kHidden;
    }
    if (other.empty()) return Sight::kUnknown;
    const int x = static_cast<int>(std::floor(at.x() - 0.5));
    const int y = static_cast<int>(std::floor(at.y() - 0.5));
    int past = 0;
    for (int k = 0; k < 16; ++k) {
      const double d = double{other(std::clamp(x - 1 + k % 4, 0, own.width() - 1),
                                    std::clamp(y - 1 + k / 4, 0, own.height() - 1))};
      // Farther than the point, or the point itself.
      past += depth > 0 ? d == 0 || d >= (1 - kReprojected) * depth : !(d > 0);
    }
    return past == 0 ? Sight::kHidden : past == 16 ? Sight::kVisible : Sight::kAtEdge;
  }

  const DatasetFrame& frame_;
  std::vector<Finding>& findings_;
  v1::Scene recipe_;
  const v1::Rig *rig_ = nullptr, *next_ = nullptr, *previous_ = nullptr;
};

}  // namespace

void CheckFlow(const DatasetFrame& frame, std::vector<Finding>& findings) {
  try {
    FlowChecker(frame, findings).Run();
  } catch (const Json::exception& error) {
    findings.push_back({"flow", frame.dir + "/frame.json", error.what()});
  }
}

}  // namespace parallax
