// Layouts for sequences: what trainers of optical flow, scene flow and stereo on video read.
#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/base/status.h"
#include "common/image/io.h"
#include "worker/dataset/export/export_layouts.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/plain_formats.h"

namespace parallax {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr uint8_t kNoFlow = 128;
constexpr const char* kEyes[] = {"left", "right"};

struct Flow {
  ImageF3 maps;      // u, v, change of disparity; kUnknownFlow where none exists.
  ImageU8 occluded;  // 255 = occluded or outside of the neighbour.
  ImageU8 none;      // 255 = no flow.
};

absl::StatusOr<Flow> ReadFlow(const ExportFrame& frame, const std::string& direction,
                              const std::string& eye) {
  const std::string dir = frame.source->dir + "/";
  Flow flow;
  ASSIGN_OR_RETURN(flow.maps, ReadExrRgb(dir + "flow_" + direction + "_" + eye + ".exr"));
  ASSIGN_OR_RETURN(flow.occluded,
                   ReadPngU8(dir + "flow_occlusion_" + direction + "_" + eye + ".png"));
  if (flow.maps.pixels() != flow.occluded.pixels()) {
    return DataLoss("{}: flow maps of different sizes", dir);
  }
  flow.none = ImageU8(flow.maps.width(), flow.maps.height());
  for (size_t i = 0; i < flow.none.pixels(); ++i) {
    if (flow.occluded.values()[i] != kNoFlow) continue;
    flow.none.values()[i] = 255;
    flow.occluded.values()[i] = 255;
    for (size_t c = 0; c < 3; ++c) flow.maps.values()[3 * i + c] = kUnknownFlow;
  }
  return flow;
}

void CountDisparities(const ImageF& disparity, FrameFiles& out) {
  Histogram histogram = DisparityHistogram();
  for (const float d : disparity.values()) {
    if (d > 0 && std::isfinite(d)) histogram.Add(double{d});
  }
  out.disparity_counts.assign(histogram.counts.begin(), histogram.counts.end());
}

// FlyingThings3D with optical flow and disparity change. Every frame has files of both directions;
// where there is no neighbour all of their flow is unknown, and readers do not look there.
class FlyingThingsFlow final : public ExportLayout {
 public:
  bool Sequences() const override { return true; }

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    ASSIGN_OR_RETURN(FrameFiles out, stereo_->Convert(frame));
    const std::string place =
        std::string("/") + (frame.test ? "TEST" : "TRAIN") + "/A/" + frame.scene + "/";
    const std::string name = fmt::format("{:03}", frame.source->rig);
    const struct {
      const char *map, *folder, *word;
    } directions[] = {{"forward", "into_future", "Future"}, {"backward", "into_past", "Past"}};
    for (const auto& direction : directions) {
      for (const char* eye : kEyes) {
        ASSIGN_OR_RETURN(Flow flow, ReadFlow(frame, direction.map, eye));
        const std::string folder = place + direction.folder + "/" + eye + "/";
        ImageF change(flow.maps.width(), flow.maps.height());
        for (size_t i = 0; i < change.pixels(); ++i) {
          change.values()[i] = std::exchange(flow.maps.values()[3 * i + 2], 0.0f);
        }
        ASSIGN_OR_RETURN(std::string pfm, EncodePfm(flow.maps));
        out.files.push_back({"optical_flow" + folder + "OpticalFlowInto" + direction.word + "_" +
                                 name + (eye == kEyes[0] ? "_L.pfm" : "_R.pfm"),
                             "", std::move(pfm)});
        ASSIGN_OR_RETURN(std::string changes, EncodePfm(change));
        out.files.push_back({"disparity_change" + folder + name + ".pfm", "", std::move(changes)});
        ASSIGN_OR_RETURN(std::string bits, EncodePngBits(flow.occluded));
        out.files.push_back(
            {"optical_flow_occlusions" + folder + name + ".png", "", std::move(bits)});
      }
    }
    return out;
  }

 private:
  const std::unique_ptr<ExportLayout> stereo_ = MakeFlyingThingsWithFiniteTruth();
};

// MPI Sintel, and beside it the stereo pairs as Sintel's own package has them.
class Sintel final : public ExportLayout {
 public:
  bool Sequences() const override { return true; }

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    const std::string split = frame.test ? "test/" : "training/";
    const std::string name = fmt::format("/{}/frame_{:04}", frame.scene, frame.at + 1);
    const std::string flow_root = "Sintel/" + split, stereo_root = "sintel_stereo/" + split;
    for (const char* pass : {"clean", "final"}) {
      out.files.push_back(
          LinkTo(flow_root + pass + name + ".png", frame, PictureOf(frame, "left")));
      for (const char* eye : kEyes) {
        out.files.push_back(
            LinkTo(stereo_root + pass + "_" + eye + name + ".png", frame, PictureOf(frame, eye)));
      }
    }
    if (frame.at + 1 < frame.length) {
      ASSIGN_OR_RETURN(const Flow flow, ReadFlow(frame, "forward", "left"));
      out.files.push_back({flow_root + "flow" + name + ".flo", "", EncodeFlo(flow.maps)});
      ASSIGN_OR_RETURN(std::string occluded, EncodePng(flow.occluded));
      out.files.push_back({flow_root + "occlusions" + name + ".png", "", std::move(occluded)});
      ASSIGN_OR_RETURN(std::string none, EncodePng(flow.none));
      out.files.push_back({flow_root + "invalid" + name + ".png", "", std::move(none)});
    }
    RETURN_IF_ERROR(AddDisparity(frame, stereo_root, name, out));
    out.list_line = flow_root + "clean" + name + ".png " + stereo_root + "clean_right" + name +
                    ".png " + stereo_root + "disparities" + name + ".png";
    return out;
  }

 private:
  // d = 4 R + G / 64 + B / 16384; occluded and outside of the other eye apart.
  static absl::Status AddDisparity(const ExportFrame& frame, const std::string& root,
                                   const std::string& name, FrameFiles& out) {
    ASSIGN_OR_RETURN(const ImageF disparity, ReadTruthMap(frame, "disparity_left", "left"));
    ASSIGN_OR_RETURN(const ImageU8 occlusion, ReadPngU8(frame.source->dir + "/occlusion_left.png"));
    CountDisparities(disparity, out);
    ImageRgb8 digits(disparity.width(), disparity.height());
    ImageU8 hidden(disparity.width(), disparity.height()), outside(hidden);
    for (int y = 0; y < disparity.height(); ++y) {
      for (int x = 0; x < disparity.width(); ++x) {
        const double d = double{disparity(x, y)};
        const auto steps = d > 0 ? std::llround(16384 * d) : 0;
        const bool is_outside = x + 0.5 - d < 0;
        outside(x, y) = is_outside ? 255 : 0;
        hidden(x, y) = occlusion(x, y) != 0 && !is_outside ? 255 : 0;
        if (steps >= 1 << 24) {
          ++out.pixels_out_of_range;
          continue;
        }
        digits(x, y, 0) = static_cast<uint8_t>(steps >> 16);
        digits(x, y, 1) = static_cast<uint8_t>(steps >> 8 & 255);
        digits(x, y, 2) = static_cast<uint8_t>(steps & 255);
      }
    }
    ASSIGN_OR_RETURN(std::string png, EncodePng(digits));
    out.files.push_back({root + "disparities" + name + ".png", "", std::move(png)});
    ASSIGN_OR_RETURN(std::string occluded, EncodePng(hidden));
    out.files.push_back({root + "occlusions" + name + ".png", "", std::move(occluded)});
    ASSIGN_OR_RETURN(std::string off, EncodePng(outside));
    out.files.push_back({root + "outofframe" + name + ".png", "", std::move(off)});
    return absl::OkStatus();
  }
};

// Dynamic Replica: frame annotations of a split in one file, as its loader reads them.
class DynamicReplica final : public ExportLayout {
 public:
  bool Sequences() const override { return true; }

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(const OrderedJson json, ReadFrameJson(frame.source->dir));
    const OrderedJson moving = json.value("moving", OrderedJson::object());
    for (const char* eye : kEyes) {
      const std::string dir = frame.source->dir + "/";
      const std::string side(eye), place = PlaceOf(frame, side);
      ASSIGN_OR_RETURN(const ImageF depth, ReadTruthMap(frame, "depth_" + side, side));
      ASSIGN_OR_RETURN(const ImageU16 objects, ReadPngU16(dir + "objects_" + side + ".png"));
      out.files.push_back(
          LinkTo(place + "images/" + NameOf(frame) + ".png", frame, PictureOf(frame, side)));
      ASSIGN_OR_RETURN(std::string halves, EncodePng(Halves(depth)));
      out.files.push_back(
          {place + "depths/" + NameOf(frame) + ".geometric.png", "", std::move(halves)});
      ImageU8 mask(objects.width(), objects.height());
      for (size_t i = 0; i < mask.pixels(); ++i) {
        mask.values()[i] = moving.contains(std::to_string(objects.values()[i])) ? 255 : 0;
      }
      ASSIGN_OR_RETURN(std::string foreground, EncodePng(mask));
      out.files.push_back({place + "masks/" + NameOf(frame) + ".png", "", std::move(foreground)});
      out.files.push_back(LinkTo(place + "instance_id_maps/" + NameOf(frame) + ".png", frame,
                                 "objects_" + side + ".png"));
      RETURN_IF_ERROR(AddFlow(frame, side, out));
      if (eye != kEyes[0]) continue;
      ASSIGN_OR_RETURN(const ImageF disparity, ReadTruthMap(frame, "disparity_left", "left"));
      CountDisparities(disparity, out);
    }
    const std::string split = SplitOf(frame) + "/";
    out.list_line = split + PathOf(frame, "left") + "images/" + NameOf(frame) + ".png " + split +
                    PathOf(frame, "right") + "images/" + NameOf(frame) + ".png " + split +
                    PathOf(frame, "left") + "depths/" + NameOf(frame) + ".geometric.png";
    return out;
  }

  // Refuses baselines that differ from frame to frame: the loader makes disparity of depth by the
  // camera of a sample's first frame.
  absl::StatusOr<std::vector<ExportFile>> FinishScene(
      const std::vector<ExportFrame>& frames) const override {
    std::optional<double> first;
    for (const ExportFrame& frame : frames) {
      const std::string& dir = frame.source->dir;
      const absl::StatusOr<double> baseline_m = CatchJson(dir, [&dir]() -> absl::StatusOr<double> {
        ASSIGN_OR_RETURN(const OrderedJson json, ReadFrameJson(dir));
        return json.at("baseline_m").get<double>();
      });
      RETURN_IF_ERROR(baseline_m.status());
      if (std::abs(*baseline_m - first.value_or(*baseline_m)) > 1e-9) {
        return FailedPrecondition(
            "{}: has a baseline of {} m, the first frame of its sequence {} m, but readers of "
            "dynamic-replica take that of the first frame for all (nature.walk.baseline_per: "
            "scene)",
            dir, *baseline_m, *first);
      }
      first = first.value_or(*baseline_m);
    }
    return std::vector<ExportFile>();
  }

  // Writes the test split as "valid", too, which dynamic_stereo's train.py opens first: a list of
  // the same files.
  absl::StatusOr<std::vector<ExportFile>> Finish(
      const std::vector<ExportFrame>& frames) const override {
    const struct {
      std::string name, from, prefix;
    } lists[] = {{"train", "train", ""}, {"test", "test", ""}, {"valid", "test", "../test/"}};
    std::vector<ExportFile> files;
    for (const auto& list : lists) {
      ASSIGN_OR_RETURN(const OrderedJson all, Annotations(frames, list.from, list.prefix));
      if (all.empty()) continue;
      ASSIGN_OR_RETURN(std::string bytes, Gzip(all.dump()));
      files.push_back(
          {list.name + "/frame_annotations_" + list.name + ".jgz", "", std::move(bytes)});
    }
    return files;
  }

 private:
  static std::string SplitOf(const ExportFrame& frame) { return frame.test ? "test" : "train"; }
  static std::string NameOf(const ExportFrame& frame) { return fmt::format("{:04}", frame.at); }
  // Below the split's folder, and with it.
  static std::string PathOf(const ExportFrame& frame, const std::string& eye) {
    return frame.scene + "_" + eye + "/";
  }
  static std::string PlaceOf(const ExportFrame& frame, const std::string& eye) {
    return SplitOf(frame) + "/" + PathOf(frame, eye);
  }

  static ImageU16 Halves(const ImageF& image) {
    ImageU16 bits(image.width(), image.height());
    for (size_t i = 0; i < bits.pixels(); ++i) bits.values()[i] = HalfBits(image.values()[i]);
    return bits;
  }

  static bool HasFlow(const ExportFrame& frame, const std::string& direction) {
    return direction == "forward" ? frame.at + 1 < frame.length : frame.at > 0;
  }

  // u and v side by side; what is not visible in the neighbour is 0 in the mask.
  static absl::Status AddFlow(const ExportFrame& frame, const std::string& eye, FrameFiles& out) {
    for (const std::string direction : {"forward", "backward"}) {
      if (!HasFlow(frame, direction)) continue;
      ASSIGN_OR_RETURN(const Flow flow, ReadFlow(frame, direction, eye));
      const int width = flow.maps.width();
      ImageF both(2 * width, flow.maps.height());
      ImageU8 mask(width, flow.maps.height());
      for (int y = 0; y < both.height(); ++y) {
        for (int x = 0; x < width; ++x) {
          mask(x, y) = flow.occluded(x, y) == 0 ? 255 : 0;
          if (flow.none(x, y)) continue;
          both(x, y) = flow.maps(x, y, 0);
          both(x + width, y) = flow.maps(x, y, 1);
        }
      }
      const std::string folder = PlaceOf(frame, eye) + "flow_" + direction;
      ASSIGN_OR_RETURN(std::string halves, EncodePng(Halves(both)));
      out.files.push_back({folder + "/" + NameOf(frame) + ".png", "", std::move(halves)});
      ASSIGN_OR_RETURN(std::string bits, EncodePngBits(mask));
      out.files.push_back({folder + "_mask/" + NameOf(frame) + ".png", "", std::move(bits)});
    }
    return absl::OkStatus();
  }

  // All frames of a split, whose files lie at `prefix` from its list.
  static absl::StatusOr<OrderedJson> Annotations(const std::vector<ExportFrame>& frames,
                                                 const std::string& split,
                                                 const std::string& prefix) {
    OrderedJson all = OrderedJson::array();
    for (size_t begin = 0; begin < frames.size();
         begin += static_cast<size_t>(frames[begin].length)) {
      if (SplitOf(frames[begin]) != split) continue;
      for (const char* eye : kEyes) {
        for (int i = 0; i < frames[begin].length; ++i) {
          const ExportFrame& frame = frames[begin + static_cast<size_t>(i)];
          ASSIGN_OR_RETURN(OrderedJson entry, CatchJson(frame.source->dir, [&] {
                             return Annotation(frame, eye, prefix);
                           }));
          all.push_back(std::move(entry));
        }
      }
    }
    return all;
  }

  // One frame of one eye.   Source: dynamic_stereo's DynamicReplicaFrameAnnotation and PyTorch3D's
  // FrameAnnotation.
  static absl::StatusOr<OrderedJson> Annotation(const ExportFrame& frame, const std::string& eye,
                                                const std::string& prefix) {
    ASSIGN_OR_RETURN(const OrderedJson json, ReadFrameJson(frame.source->dir));
    const OrderedJson& k = json.at("intrinsics");
    const int width = k.at("width"), height = k.at("height");
    const std::string place = prefix + PathOf(frame, eye), name = NameOf(frame);
    OrderedJson entry = {
        {"sequence_name", frame.scene},
        {"frame_number", frame.at},
        {"frame_timestamp", json.at("sequence").at("time_s")},
        {"image", {{"path", place + "images/" + name + ".png"}, {"size", {height, width}}}},
        {"depth",
         {{"path", place + "depths/" + name + ".geometric.png"},
          {"scale_adjustment", 1.0},
          {"mask_path", nullptr}}},
        {"mask", {{"path", place + "masks/" + name + ".png"}, {"mass", nullptr}}},
        {"viewpoint", Viewpoint(json, k, eye)},
        {"camera_name", eye},
        {"instance_id_map_path", place + "instance_id_maps/" + name + ".png"}};
    for (const std::string direction : {"forward", "backward"}) {
      const bool has = HasFlow(frame, direction);
      const std::string key = "flow_" + direction;
      const auto path = [&](const std::string& folder) {
        return has ? OrderedJson{{"path", place + folder + "/" + name + ".png"}} : OrderedJson();
      };
      entry[key] = path(key);
      entry[key + "_mask"] = path(key + "_mask");
    }
    return entry;
  }

  // PyTorch3D: x to the left, y up; rows times R plus T; lengths over half of the smaller side.
  static OrderedJson Viewpoint(const OrderedJson& json, const OrderedJson& k,
                               const std::string& eye) {
    const OrderedJson& pose = json.at("world_from_" + eye);
    const double flip[3] = {-1, -1, 1};
    OrderedJson rotation = OrderedJson::array(), translation = OrderedJson::array();
    for (size_t i = 0; i < 3; ++i) {
      OrderedJson row = OrderedJson::array();
      double shift = 0;
      for (size_t j = 0; j < 3; ++j) {
        // camera_from_world is the transposed rotation, which R transposes again.
        row.push_back(pose.at(i).at(j).get<double>() * flip[j]);
        shift -= pose.at(j).at(i).get<double>() * pose.at(j).at(3).get<double>();
      }
      rotation.push_back(row);
      translation.push_back(flip[i] * shift);
    }
    const double half_x = k.at("width").get<double>() / 2;
    const double half_y = k.at("height").get<double>() / 2;
    const double half = std::min(half_x, half_y);
    return {
        {"R", rotation},
        {"T", translation},
        {"focal_length", {k.at("fx").get<double>() / half, k.at("fy").get<double>() / half}},
        {"principal_point",
         {(half_x - k.at("cx").get<double>()) / half, (half_y - k.at("cy").get<double>()) / half}},
        {"intrinsics_format", "ndc_isotropic"}};
  }
};

}  // namespace

std::unique_ptr<ExportLayout> MakeSequenceLayout(const std::string& name) {
  if (name == "flyingthings-flow") return std::make_unique<FlyingThingsFlow>();
  if (name == "sintel") return std::make_unique<Sintel>();
  if (name == "dynamic-replica") return std::make_unique<DynamicReplica>();
  return nullptr;
}

}  // namespace parallax
