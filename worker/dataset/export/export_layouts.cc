#include "worker/dataset/export/export_layouts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/frame_maps.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/plain_formats.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint8_t kSkyOrExterior = 1 | 2;  // Bits of masks_*.png.
constexpr float kInfinite = std::numeric_limits<float>::infinity();

std::string RigName(const ExportFrame& frame, int digits) {
  return fmt::format("{:0{}}", frame.source->rig, digits);
}

std::string NumberOf(const Json& json, const char* key) {
  return fmt::format("{:.9g}", json.at(key).get<double>());
}

// Both eyes' disparity and occlusion of a frame.
struct Truth {
  ImageF disparity[2];
  ImageU8 occlusion[2];
};

absl::StatusOr<ImageF> ReadDisparity(const ExportFrame& frame, const char* eye,
                                     FrameFiles* count_in) {
  ASSIGN_OR_RETURN(ImageF disparity, ReadTruthMap(frame, std::string("disparity_") + eye, eye));
  if (count_in != nullptr) {
    Histogram histogram = DisparityHistogram();
    for (const float d : disparity.values()) {
      if (d > 0 && std::isfinite(d)) histogram.Add(double{d});
    }
    count_in->disparity_counts.assign(histogram.counts.begin(), histogram.counts.end());
  }
  return disparity;
}

absl::StatusOr<Truth> ReadTruth(const ExportFrame& frame, FrameFiles& files) {
  Truth truth;
  const char* eyes[] = {"left", "right"};
  for (int eye = 0; eye < 2; ++eye) {
    ASSIGN_OR_RETURN(truth.disparity[eye],
                     ReadDisparity(frame, eyes[eye], eye == 0 ? &files : nullptr));
    ASSIGN_OR_RETURN(truth.occlusion[eye],
                     ReadPngU8(frame.source->dir + "/occlusion_" + eyes[eye] + ".png"));
    const ImageF& d = truth.disparity[eye];
    if (d.width() != truth.occlusion[eye].width() || d.height() != truth.occlusion[eye].height()) {
      return DataLoss("{}: maps of different sizes", frame.source->dir);
    }
  }
  return truth;
}

// Puts `no_truth` where a disparity map has none.
void MarkNoTruth(ImageF& disparity, float no_truth) {
  for (float& d : disparity.values()) {
    if (!(d > 0)) d = no_truth;
  }
}

// 16-bit disparity in steps of 1/`scale` pixel; 0 = none. What does not fit is none, and counted.
ImageU16 Quantise(const ImageF& disparity, double scale, int64_t* out_of_range) {
  ImageU16 image(disparity.width(), disparity.height());
  for (size_t i = 0; i < disparity.pixels(); ++i) {
    const double d = double{disparity.values()[i]};
    if (!(d > 0)) continue;
    const double steps = std::max(1.0, std::round(d * scale));
    if (steps > 65535) {
      if (out_of_range != nullptr) ++*out_of_range;
      continue;
    }
    image.values()[i] = static_cast<uint16_t>(steps);
  }
  return image;
}

absl::StatusOr<std::string> JpegOf(const ExportFrame& frame, const std::string& eye) {
  ASSIGN_OR_RETURN(const ImageRgb8 image,
                   ReadPictureRgb8(frame.source->dir + "/" + PictureOf(frame, eye)));
  return EncodeJpeg(image, 95);
}

class FlyingThings final : public ExportLayout {
 public:
  explicit FlyingThings(float no_truth) : no_truth_(no_truth) {}

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(Truth truth, ReadTruth(frame, out));
    const std::string split = frame.test ? "TEST" : "TRAIN";
    const std::string place = "/" + split + "/A/" + frame.scene + "/";
    const std::string name = RigName(frame, 3);
    const char* eyes[] = {"left", "right"};
    for (int eye = 0; eye < 2; ++eye) {
      const std::string file = std::string(eyes[eye]) + "/" + name;
      const std::string image = PictureOf(frame, eyes[eye]);
      for (const char* pass : {"frames_cleanpass", "frames_finalpass"}) {
        out.files.push_back(LinkTo(pass + place + file + ".png", frame, image));
      }
      MarkNoTruth(truth.disparity[eye], no_truth_);
      ASSIGN_OR_RETURN(std::string pfm, EncodePfm(truth.disparity[eye]));
      out.files.push_back({"disparity" + place + file + ".pfm", "", std::move(pfm)});
      ASSIGN_OR_RETURN(std::string bits, EncodePngBits(truth.occlusion[eye]));
      out.files.push_back({"disparity_occlusions" + place + file + ".png", "", std::move(bits)});
    }
    out.list_line = "frames_finalpass" + place + "left/" + name + ".png frames_finalpass" + place +
                    "right/" + name + ".png disparity" + place + "left/" + name + ".pfm";
    return out;
  }

 private:
  const float no_truth_;
};

// Disparity in thousandths of a pixel as digits to the base 255.
class FoundationStereo final : public ExportLayout {
 public:
  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(const ImageF disparity, ReadDisparity(frame, "left", &out));
    ImageRgb8 digits(disparity.width(), disparity.height());
    for (size_t i = 0; i < disparity.pixels(); ++i) {
      const double d = double{disparity.values()[i]};
      const auto v = d > 0 ? std::llround(1000 * d) : 0;
      if (v > 255LL * 65025 + 254 * 255 + 254) {
        ++out.pixels_out_of_range;
        continue;
      }
      digits.values()[3 * i] = static_cast<uint8_t>(v / 65025);
      digits.values()[3 * i + 1] = static_cast<uint8_t>(v / 255 % 255);
      digits.values()[3 * i + 2] = static_cast<uint8_t>(v % 255);
    }
    const std::string place = frame.scene + "/dataset/data/";
    const std::string name = RigName(frame, 4);
    for (const char* eye : {"left", "right"}) {
      ASSIGN_OR_RETURN(std::string jpeg, JpegOf(frame, eye));
      out.files.push_back({place + eye + "/rgb/" + name + ".jpg", "", std::move(jpeg)});
    }
    ASSIGN_OR_RETURN(std::string png, EncodePng(digits));
    out.files.push_back({place + "left/disparity/" + name + ".png", "", std::move(png)});
    out.list_line = place + "left/rgb/" + name + ".jpg " + place + "right/rgb/" + name + ".jpg " +
                    place + "left/disparity/" + name + ".png";
    return out;
  }

  // Two lines as FoundationStereo reads them, of the first frame; then a comment for each frame,
  // because our rigs differ in focal length and baseline.
  absl::StatusOr<std::vector<ExportFile>> FinishScene(
      const std::vector<ExportFrame>& frames) const override {
    std::string text, comments = "# frame fx cx fy cy baseline_m\n";
    for (const ExportFrame& frame : frames) {
      ASSIGN_OR_RETURN(const Camera camera,
                       CatchJson(frame.source->dir, [&frame] { return CameraOf(frame); }));
      const auto& [fx, fy, cx, cy, baseline] = camera;
      if (text.empty()) {
        text = fx + " 0 " + cx + " 0 " + fy + " " + cy + " 0 0 1\n" + baseline + "\n";
      }
      comments += "# " + RigName(frame, 4) + " " + fx + " " + cx + " " + fy + " " + cy + " " +
                  baseline + "\n";
    }
    return std::vector<ExportFile>{
        {frames.front().scene + "/dataset/data/K.txt", "", text + comments}};
  }

 private:
  // The numbers of K.txt.
  struct Camera {
    std::string fx, fy, cx, cy, baseline;
  };

  static absl::StatusOr<Camera> CameraOf(const ExportFrame& frame) {
    ASSIGN_OR_RETURN(const Json json, ReadFrameJson(frame.source->dir));
    if (!json.contains("intrinsics") || !json.contains("baseline_m")) {
      return DataLoss("{}/frame.json: no camera", frame.source->dir);
    }
    const Json& k = json.at("intrinsics");
    return Camera{NumberOf(k, "fx"), NumberOf(k, "fy"), NumberOf(k, "cx"), NumberOf(k, "cy"),
                  NumberOf(json, "baseline_m")};
  }
};

class CreStereo final : public ExportLayout {
 public:
  explicit CreStereo(bool flat) : flat_(flat) {}

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    // Readers want all four folders. Scenes are spread over them; too few scenes are cut.
    static constexpr const char* kFolders[] = {"shapenet", "reflective", "tree", "hole"};
    const int part = frame.scenes >= 4 ? frame.scene_number : frame.number;
    const std::string place =
        std::string(kFolders[part % 4]) + "/" + frame.scene + (flat_ ? "_" : "/");
    const std::string name = RigName(frame, 3);
    for (const char* eye : {"left", "right"}) {
      ASSIGN_OR_RETURN(std::string jpeg, JpegOf(frame, eye));
      out.files.push_back({place + name + "_" + eye + ".jpg", "", std::move(jpeg)});
      const bool left = std::string(eye) == "left";
      ASSIGN_OR_RETURN(const ImageF disparity, ReadDisparity(frame, eye, left ? &out : nullptr));
      ASSIGN_OR_RETURN(
          std::string png,
          EncodePng(Quantise(disparity, 32, left ? &out.pixels_out_of_range : nullptr)));
      out.files.push_back({place + name + "_" + eye + ".disp.png", "", std::move(png)});
    }
    out.list_line = place + name + "_left.jpg " + place + name + "_right.jpg " + place + name +
                    "_left.disp.png";
    return out;
  }

 private:
  const bool flat_;
};

class WmgStereo final : public ExportLayout {
 public:
  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    // Three levels above Image/: type, scene, sequence.
    const std::string place = frame.type + "/" + frame.scene + "/frames/";
    const std::string name = RigName(frame, 4);
    const char* eyes[] = {"left", "right"};
    for (int eye = 0; eye < 2; ++eye) {
      const std::string camera = fmt::format("camera_{}/{}", eye, name);
      out.files.push_back(
          LinkTo(place + "Image/" + camera + ".png", frame, PictureOf(frame, eyes[eye])));
      ASSIGN_OR_RETURN(const ImageF disparity,
                       ReadDisparity(frame, eyes[eye], eye == 0 ? &out : nullptr));
      out.files.push_back({place + "disparity/" + camera + ".npy", "", EncodeNpy(disparity)});
    }
    out.list_line = place + "Image/camera_0/" + name + ".png " + place + "Image/camera_1/" + name +
                    ".png " + place + "disparity/camera_0/" + name + ".npy";
    return out;
  }
};

class Middlebury final : public ExportLayout {
 public:
  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(Truth truth, ReadTruth(frame, out));
    const std::string place = frame.scene + "_" + RigName(frame, 3) + "/";
    out.files.push_back(LinkTo(place + "im0.png", frame, PictureOf(frame, "left")));
    out.files.push_back(LinkTo(place + "im1.png", frame, PictureOf(frame, "right")));
    const ImageF& left = truth.disparity[0];
    ImageU8 mask(left.width(), left.height());
    float largest = 0, smallest = kInfinite;
    for (size_t i = 0; i < left.pixels(); ++i) {
      const float d = left.values()[i];
      if (!(d > 0)) continue;
      mask.values()[i] = truth.occlusion[0].values()[i] ? 128 : 255;
      largest = std::max(largest, d);
      smallest = std::min(smallest, d);
    }
    for (int eye = 0; eye < 2; ++eye) {
      // Their tools know unknown disparity as infinite.
      MarkNoTruth(truth.disparity[eye], kInfinite);
      ASSIGN_OR_RETURN(std::string pfm, EncodePfm(truth.disparity[eye]));
      out.files.push_back({fmt::format("{}disp{}GT.pfm", place, eye), "", std::move(pfm)});
    }
    ASSIGN_OR_RETURN(std::string png, EncodePng(mask));
    out.files.push_back({place + "mask0nocc.png", "", std::move(png)});
    ASSIGN_OR_RETURN(const Json json, ReadFrameJson(frame.source->dir));
    const Json& k = json.at("intrinsics");
    const std::string matrix = fmt::format("[{} 0 {}; 0 {} {}; 0 0 1]", NumberOf(k, "fx"),
                                           NumberOf(k, "cx"), NumberOf(k, "fy"), NumberOf(k, "cy"));
    const double baseline_mm = 1000 * json.at("baseline_m").get<double>();
    const int vmax = static_cast<int>(std::ceil(largest));
    const int vmin = largest > 0 ? static_cast<int>(std::floor(smallest)) : 0;
    out.files.push_back({place + "calib.txt", "",
                         fmt::format("cam0={}\ncam1={}\ndoffs=0\nbaseline={:.9g}\nwidth={}\nheight="
                                     "{}\nndisp={}\nisint=0\nvmin={}\nvmax={}\ndyavg=0\ndymax=0\n",
                                     matrix, matrix, baseline_mm, left.width(), left.height(),
                                     vmax + 1, vmin, vmax)});
    out.list_line = place + "im0.png " + place + "im1.png " + place + "disp0GT.pfm";
    return out;
  }
};

class Kitti final : public ExportLayout {
 public:
  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(const Truth truth, ReadTruth(frame, out));
    const std::string name = fmt::format("{:06}_10.png", frame.number);
    out.files.push_back(LinkTo("training/image_2/" + name, frame, PictureOf(frame, "left")));
    out.files.push_back(LinkTo("training/image_3/" + name, frame, PictureOf(frame, "right")));
    ImageU16 all = Quantise(truth.disparity[0], 256, &out.pixels_out_of_range);
    ASSIGN_OR_RETURN(std::string occluded, EncodePng(all));
    out.files.push_back({"training/disp_occ_0/" + name, "", std::move(occluded)});
    for (size_t i = 0; i < all.pixels(); ++i) {
      if (truth.occlusion[0].values()[i]) all.values()[i] = 0;
    }
    ASSIGN_OR_RETURN(std::string visible, EncodePng(all));
    out.files.push_back({"training/disp_noc_0/" + name, "", std::move(visible)});
    out.list_line =
        "training/image_2/" + name + " training/image_3/" + name + " training/disp_occ_0/" + name;
    return out;
  }
};

// A sample's JSON has lists of rows where frame.json has tables: readers that put samples in typed
// columns (Hugging Face `datasets`) take each key for a column and drop those that the first
// samples lack.
Json TableRows(const Json& table) {
  Json rows = Json::array();
  for (const auto& [index, entry] : table.items()) {
    Json row = {{"index", std::strtoul(index.c_str(), nullptr, 10)}};
    row.update(entry);
    // Older archives have numbers.
    if (const auto seed = SeedOf(entry.at("seed"))) row["seed"] = std::to_string(*seed);
    rows.push_back(std::move(row));
  }
  return rows;
}

Json PixelRows(const Json& pixels_by_class) {
  Json rows = Json::array();
  for (const auto& [name, pixels] : pixels_by_class.items()) {
    rows.push_back({{"class", name}, {"pixels", pixels}});
  }
  return rows;
}

Json MovingRows(const Json& moving) {
  Json rows = Json::array();
  for (const auto& [index, pose] : moving.items()) {
    rows.push_back({{"index", std::strtoul(index.c_str(), nullptr, 10)}, {"pose", pose}});
  }
  return rows;
}

absl::StatusOr<Json> SampleJson(const ExportFrame& frame) {
  ASSIGN_OR_RETURN(Json json, ReadFrameJson(frame.source->dir));
  for (const char* table : {"objects", "materials"}) json[table] = TableRows(json.at(table));
  for (const char* pixels : {"object_pixels", "material_pixels"}) {
    json[pixels] = PixelRows(json.at(pixels));
  }
  // Absent where the scene has no motion: readers take a list that is empty in the first samples
  // for one of nulls, and fail at the first that is not.
  if (json.contains("moving")) json["moving"] = MovingRows(json.at("moving"));
  if (const auto seed = SeedOf(json.at("seeds").at("scene"))) {
    json["seeds"]["scene"] = std::to_string(*seed);
  }
  json["split"] = frame.test ? "TEST" : "TRAIN";
  json["type"] = frame.type;
  json["variant"] = frame.source->variant;
  json["scene"] = frame.source->scene;
  return json;
}

class WebDataset final : public ExportLayout {
 public:
  bool Shards() const override { return true; }

  absl::StatusOr<FrameFiles> Convert(const ExportFrame& frame) const override {
    FrameFiles out;
    ASSIGN_OR_RETURN(const ImageF disparity, ReadDisparity(frame, "left", &out));
    ASSIGN_OR_RETURN(const ImageU8 occlusion, ReadPngU8(frame.source->dir + "/occlusion_left.png"));
    ASSIGN_OR_RETURN(const Json json, SampleJson(frame));
    const std::string key = frame.scene + "_" + RigName(frame, 3);
    for (const char* eye : {"left", "right"}) {
      ASSIGN_OR_RETURN(std::string png, ReadUnchanged(frame, PictureOf(frame, eye)));
      out.files.push_back({key + "." + eye + ".png", "", std::move(png)});
    }
    out.files.push_back({key + ".disp.npy", "", EncodeNpy(disparity)});
    ASSIGN_OR_RETURN(std::string occ, EncodePng(occlusion));
    out.files.push_back({key + ".occ.png", "", std::move(occ)});
    for (const char* eye : {"left", "right"}) {
      RETURN_IF_ERROR(AddMore(frame, key, eye, occlusion, out));
    }
    out.files.push_back({key + ".json", "", json.dump() + "\n"});
    out.list_line = key;
    return out;
  }

 private:
  // The rows whose files are members of a sample: PNG first, by name.
  static std::vector<const FrameMap*> MoreOfSamples() {
    std::vector<const FrameMap*> rows;
    for (const FrameMap& row : FrameMaps()) {
      if (row.sample) rows.push_back(&row);
    }
    std::sort(rows.begin(), rows.end(), [](const FrameMap* a, const FrameMap* b) {
      return std::pair(a->IsExr(), a->stem()) < std::pair(b->IsExr(), b->stem());
    });
    return rows;
  }

  // Adds an eye's further maps, as far as the frame has them. Sparse ones are there in each sample
  // of a frame that might have them: readers leave out what the first samples lack.
  static absl::Status AddMore(const ExportFrame& frame, const std::string& key,
                              const std::string& eye, const ImageU8& size, FrameFiles& out) {
    const auto has = [&](const FrameMap& row) {
      return frame.source->files.contains(row.FileOf(eye));
    };
    for (const FrameMap* row : MoreOfSamples()) {
      const bool none = row->sparse && !has(*row) && has(FrameMapOf(row->map));
      if (!none && !has(*row)) continue;
      const std::string name = key + "." + std::string(row->stem()) + "_" + eye;
      const std::string path = frame.source->dir + "/" + row->FileOf(eye);
      if (row->encoding == FrameMap::kHalfRgb) {  // As it is: an array is several times as large.
        ASSIGN_OR_RETURN(std::string exr, ReadUnchanged(frame, row->FileOf(eye)));
        out.files.push_back({name + ".exr", "", std::move(exr)});
      } else if (row->encoding == FrameMap::kFloatY) {
        ImageF image(size.width(), size.height());
        if (!none) {
          ASSIGN_OR_RETURN(image, ReadExrY(path));
        }
        out.files.push_back({name + ".npy", "", EncodeNpy(image)});
      } else if (row->IsExr()) {
        ASSIGN_OR_RETURN(const ImageF3 image, ReadExrRgb(path));
        out.files.push_back({name + ".npy", "", EncodeNpy(image)});
      } else {
        absl::StatusOr<std::string> png = none ? EncodePng(ImageU16(size.width(), size.height()))
                                               : ReadUnchanged(frame, row->FileOf(eye));
        RETURN_IF_ERROR(png.status());
        out.files.push_back({name + ".png", "", *std::move(png)});
      }
    }
    return absl::OkStatus();
  }
};

}  // namespace

std::string PictureOf(const ExportFrame& frame, const std::string& eye) {
  return (frame.infrared ? "infrared_" : "") + eye + ".png";
}

absl::StatusOr<ImageF> ReadTruthMap(const ExportFrame& frame, const std::string& map,
                                    const std::string& eye) {
  ASSIGN_OR_RETURN(ImageF truth, ReadExrY(frame.source->dir + "/" + map + ".exr"));
  const std::string name = "masks_" + eye + ".png";
  if (!frame.source->files.contains(name)) return truth;
  ASSIGN_OR_RETURN(const ImageU8 masks, ReadPngU8(frame.source->dir + "/" + name));
  if (masks.width() != truth.width() || masks.height() != truth.height()) {
    return DataLoss("{}: {} and {}.exr are of different sizes", frame.source->dir, name, map);
  }
  for (size_t i = 0; i < truth.pixels(); ++i) {
    if ((masks.values()[i] & kSkyOrExterior) != 0) truth.values()[i] = 0;
  }
  return truth;
}

absl::StatusOr<std::string> ReadUnchanged(const ExportFrame& frame, const std::string& file) {
  const std::string path = frame.source->dir + "/" + file;
  ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
  const auto known = frame.source->files.find(file);
  if (known != frame.source->files.end() && Sha256Hex(bytes) != known->second) {
    return DataLoss("{}: its content is not what the index says", path);
  }
  return bytes;
}

ExportFile LinkTo(std::string path, const ExportFrame& frame, const std::string& file) {
  return {std::move(path), frame.source->dir + "/" + file, {}};
}

const std::vector<std::string>& ExportLayouts() {
  static const std::vector<std::string> names = {
      "flyingthings", "fsd",        "crestereo",         "wmgstereo", "middlebury",
      "kitti",        "webdataset", "flyingthings-flow", "sintel",    "dynamic-replica"};
  return names;
}

std::unique_ptr<ExportLayout> MakeFlyingThingsWithFiniteTruth() {
  return std::make_unique<FlyingThings>(0.0f);
}

std::unique_ptr<ExportLayout> MakeExportLayout(const ExportOptions& options) {
  const std::string& name = options.layout;
  // RAFT-Stereo and its kin train on every disparity below 512, and on 0, too.
  if (name == "flyingthings") return std::make_unique<FlyingThings>(kInfinite);
  if (name == "fsd") return std::make_unique<FoundationStereo>();
  if (name == "crestereo") return std::make_unique<CreStereo>(options.flat);
  if (name == "wmgstereo") return std::make_unique<WmgStereo>();
  if (name == "middlebury") return std::make_unique<Middlebury>();
  if (name == "kitti") return std::make_unique<Kitti>();
  if (name == "webdataset") return std::make_unique<WebDataset>();
  return MakeSequenceLayout(name);
}

}  // namespace parallax
