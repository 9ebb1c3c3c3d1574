// Files of cameras: RealSense, ZED.
#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "common/base/names.h"
#include "common/calibration/formats.h"

namespace parallax::calibration_internal {
namespace {

std::string LowerWord(std::string_view text) {
  std::string word;
  for (const char c : text) {
    if (c >= 'A' && c <= 'Z') word += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) word += c;
  }
  return word;
}

// "Infrared 1.intrinsics.fx" is the field "fx" of the stream "infrared1".
struct StreamField {
  std::string stream, field;
};

StreamField SplitName(const std::string& name) {
  std::vector<std::string> parts;
  std::istringstream in(name);
  for (std::string part; std::getline(in, part, '.');) {
    const std::string word = LowerWord(part);
    if (word == "intrinsics" || word == "streams" || word == "depthmodule") continue;
    parts.push_back(word);
  }
  if (parts.empty()) return {};
  StreamField split;
  split.field = parts.back();
  if (parts.size() > 1) split.stream = parts[parts.size() - 2];
  return split;
}

// The names of the two cameras' streams, the preferred ones first.
using StreamNames = std::array<std::string_view, 4>;
constexpr StreamNames kLeftStreams = {"left", "infrared1", "infra1", "ir1"};
constexpr StreamNames kRightStreams = {"right", "infrared2", "infra2", "ir2"};

class RealSense {
 public:
  RealSense(const Fields& fields, const CalibrationOptions& options)
      : fields_(fields), options_(options) {
    for (const std::string& name : fields.Names()) {
      const StreamField split = SplitName(name);
      names_.insert({{split.stream, split.field}, name});
    }
  }

  Parsed Read() {
    StereoCalibration calibration;
    calibration.format = "realsense";
    std::string left = FirstStream(kLeftStreams);
    if (left.empty() && names_.count({"depth", "fx"})) left = "depth";
    if (left.empty() && !names_.count({"", "fx"})) {
      return fields_.Error("left.fx",
                           "missing, allowed are the intrinsics of left and right or of "
                           "infrared1 and infrared2");
    }
    std::string right = FirstStream(kRightStreams);
    if (right.empty()) right = left;
    calibration.raw.emplace();
    ASSIGN_OR_RETURN((*calibration.raw)[0], ReadEye(left));
    ASSIGN_OR_RETURN((*calibration.raw)[1], ReadEye(right));
    const RawIntrinsics& first = (*calibration.raw)[0];
    calibration.rectified = first.k;
    calibration.width_px = first.width_px;
    calibration.height_px = first.height_px;
    RETURN_IF_ERROR(ReadPlaces(&calibration));
    if (IsRectified(*calibration.raw)) calibration.raw.reset();
    return calibration;
  }

 private:
  std::string FirstStream(const StreamNames& streams) const {
    for (const std::string_view stream : streams) {
      if (names_.count({std::string(stream), "fx"})) return std::string(stream);
    }
    return "";
  }

  // The field's name in the file; where it has none, one for the message.
  std::string NameOf(const std::string& stream, const std::string& field) const {
    const auto found = names_.find({stream, field});
    return found != names_.end() ? found->second : (stream.empty() ? "" : stream + ".") + field;
  }

  absl::StatusOr<RawIntrinsics> ReadEye(const std::string& stream) const {
    RawIntrinsics raw;
    ASSIGN_OR_RETURN(raw.k.fx_px, fields_.Number(NameOf(stream, "fx")));
    ASSIGN_OR_RETURN(raw.k.fy_px, fields_.Number(NameOf(stream, "fy")));
    const bool short_names = names_.count({stream, "cx"}) > 0 && names_.count({stream, "ppx"}) == 0;
    ASSIGN_OR_RETURN(raw.k.cx_px, fields_.Number(NameOf(stream, short_names ? "cx" : "ppx")));
    ASSIGN_OR_RETURN(raw.k.cy_px, fields_.Number(NameOf(stream, short_names ? "cy" : "ppy")));
    if (!(raw.k.fx_px > 0) || !(raw.k.fy_px > 0)) {
      return fields_.Error(NameOf(stream, "fx"), "a focal length is not above 0");
    }
    ASSIGN_OR_RETURN(raw.width_px, fields_.Pixels(NameOf(stream, "width")));
    ASSIGN_OR_RETURN(raw.height_px, fields_.Pixels(NameOf(stream, "height")));
    const std::string coeffs = NameOf(stream, "coeffs");
    if (!fields_.Has(coeffs)) return raw;
    ASSIGN_OR_RETURN(const std::vector<double> c, fields_.Numbers(coeffs, 5));
    if (std::all_of(c.begin(), c.end(), [](double v) { return v == 0; })) return raw;
    const std::string model = NameOf(stream, "model");
    const std::string word = LowerWord(fields_.Text(model));
    std::copy(c.begin(), c.end(), raw.lens.c.begin());
    if (word.find("kannala") != std::string::npos) {
      raw.lens.model = LensDistortion::Model::kKannalaBrandt;
      raw.lens.c[4] = 0;
    } else if (word.find("inverse") == std::string::npos &&
               word.find("brown") != std::string::npos) {
      raw.lens.model = LensDistortion::Model::kBrownConrady;
    } else {
      return fields_.Error(model, Quoted(fields_.Text(model)) +
                                      " with coefficients, allowed are brown_conrady, "
                                      "modified_brown_conrady and kannala_brandt4");
    }
    return raw;
  }

  // The names of the fields of one rs2_extrinsics.
  struct Extrinsics {
    std::string rotation, translation;  // `rotation` is empty where the file has none.
  };

  // Returns all rs2_extrinsics by the name of their entry.
  std::map<std::string, Extrinsics> AllExtrinsics() const {
    std::map<std::string, Extrinsics> entries;
    for (const std::string& name : fields_.Names()) {
      const size_t dot = name.rfind('.');
      const std::string field = LowerWord(dot == name.npos ? name : name.substr(dot + 1));
      if (field != "rotation" && field != "translation") continue;
      Extrinsics& entry = entries[dot == name.npos ? "" : name.substr(0, dot)];
      (field == "rotation" ? entry.rotation : entry.translation) = name;
    }
    std::erase_if(entries, [](const auto& entry) { return entry.second.translation.empty(); });
    return entries;
  }

  // The place of the first of `streams` in an entry's name; npos if none does.
  static size_t PlaceIn(const std::string& word, const StreamNames& streams) {
    for (const std::string_view stream : streams) {
      const size_t at = word.find(stream);
      if (at != word.npos) return at;
    }
    return word.npos;
  }

  // Whether the name is of extrinsics to another sensor than the two cameras.
  static bool NamesOther(const std::string& word) {
    constexpr StreamNames kOthers = {"color", "rgb", "gyro", "accel"};
    const bool depth = word.find("depth") != word.npos;  // It is seen from the left camera.
    return PlaceIn(word, kOthers) != word.npos ||
           (depth && PlaceIn(word, kRightStreams) == word.npos);
  }

  // Returns the extrinsics between the two cameras: those whose name has both streams, from left
  // to right where the file has both directions; or the only ones, if their name has no other
  // sensor. nullptr if there are none.
  static const Extrinsics* Between(const std::map<std::string, Extrinsics>& entries) {
    const Extrinsics* found = nullptr;
    for (const auto& [name, extrinsics] : entries) {
      const std::string word = LowerWord(name);
      const size_t left = PlaceIn(word, kLeftStreams), right = PlaceIn(word, kRightStreams);
      const bool both = left != word.npos && right != word.npos;
      if (both && left < right) return &extrinsics;
      if (both || (entries.size() == 1 && !NamesOther(word))) found = &extrinsics;
    }
    return found;
  }

  // Reads the cameras' poses from rs2_extrinsics of either direction, or from a baseline.
  absl::Status ReadPlaces(StereoCalibration* calibration) const {
    const std::map<std::string, Extrinsics> entries = AllExtrinsics();
    const Extrinsics* const extrinsics = Between(entries);
    if (extrinsics != nullptr) return ReadPoses(*extrinsics, calibration);
    RETURN_IF_ERROR(ReadBaseline(calibration));
    if (entries.empty() || calibration->baseline_m) return absl::OkStatus();
    std::string names;
    for (const auto& [name, other] : entries) names += (names.empty() ? "" : ", ") + Quoted(name);
    return fields_.Error(entries.begin()->second.translation,
                         "extrinsics of " + std::string(entries.size() == 1 ? "other" : "several") +
                             " streams (" + names +
                             "), allowed are those whose name has both streams, such as "
                             "infrared1_to_infrared2, or a baseline");
  }

  absl::Status ReadPoses(const Extrinsics& extrinsics, StereoCalibration* calibration) const {
    const auto& [rotation, translation] = extrinsics;
    ASSIGN_OR_RETURN(const std::vector<double> t, fields_.Numbers(translation, 3));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (!rotation.empty()) {
      ASSIGN_OR_RETURN(const std::vector<double> r, fields_.Numbers(rotation, 9));
      ASSIGN_OR_RETURN(turn, RotationOf(fields_, rotation, MatrixOf(r).transpose()));
    }
    Eigen::Vector3d place = options_.unit_m.value_or(1) * Eigen::Vector3d(t[0], t[1], t[2]);
    if (place.x() > 0) {  // From the right camera to the left one.
      turn = Eigen::Matrix3d(turn.transpose());
      place = -turn * place;
    }
    return Rectify(fields_, translation, turn, place, calibration);
  }

  absl::Status ReadBaseline(StereoCalibration* calibration) const {
    // The SDK's option "stereo baseline" is in millimetres.
    const struct {
      const char* word;
      double unit_m;
    } kinds[] = {{"baselinem", 1},
                 {"baselinemm", kMillimetre_m},
                 {"stereobaseline", kMillimetre_m},
                 {"baseline", kMillimetre_m}};
    for (const auto& kind : kinds) {
      for (const auto& [key, name] : names_) {
        if (key.second != kind.word) continue;
        ASSIGN_OR_RETURN(const double baseline, fields_.Number(name));
        calibration->baseline_m = baseline * options_.unit_m.value_or(kind.unit_m);
        return absl::OkStatus();
      }
    }
    return absl::OkStatus();
  }

  static bool IsRectified(const std::array<RawIntrinsics, 2>& raw) {
    const auto plain = [&](const RawIntrinsics& eye) {
      return eye.lens.model == LensDistortion::Model::kNone &&
             eye.rectified_from_raw.isIdentity(1e-12);
    };
    const Intrinsics &a = raw[0].k, &b = raw[1].k;
    return plain(raw[0]) && plain(raw[1]) && a.fx_px == b.fx_px && a.fy_px == b.fy_px &&
           a.cx_px == b.cx_px && a.cy_px == b.cy_px;
  }

  const Fields& fields_;
  const CalibrationOptions& options_;
  std::map<std::pair<std::string, std::string>, std::string> names_;  // By stream and field.
};

struct ZedMode {
  const char* name;
  int width_px, height_px;
};
// Source: Stereolabs, ZED SDK's RESOLUTION.
constexpr ZedMode kZedModes[] = {{"HD", 1280, 720}, {"2K", 2208, 1242},      {"FHD", 1920, 1080},
                                 {"VGA", 672, 376}, {"FHD1200", 1920, 1200}, {"SVGA", 960, 600}};

// `side` is LEFT or RIGHT. The lens is in the mode's section; of a ZED X in a section for all
// modes.
absl::StatusOr<RawIntrinsics> ZedEye(const Fields& fields, const std::string& side,
                                     const ZedMode& mode) {
  const std::string section = side + "_CAM_" + mode.name + ".";
  RawIntrinsics raw;
  ASSIGN_OR_RETURN(raw.k.fx_px, fields.Number(section + "fx"));
  ASSIGN_OR_RETURN(raw.k.fy_px, fields.Number(section + "fy"));
  ASSIGN_OR_RETURN(raw.k.cx_px, fields.Number(section + "cx"));
  ASSIGN_OR_RETURN(raw.k.cy_px, fields.Number(section + "cy"));
  if (!(raw.k.fx_px > 0) || !(raw.k.fy_px > 0)) {
    return fields.Error(section + "fx", "a focal length is not above 0");
  }
  const bool own = fields.Has(section + "k1") || !fields.Has(side + "_DISTO.k1");
  const std::string lens = own ? section : side + "_DISTO.";
  ASSIGN_OR_RETURN(raw.lens.c[0], fields.Number(lens + "k1"));
  const char* names[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  for (size_t i = 1; i < 8; ++i) {
    ASSIGN_OR_RETURN(raw.lens.c[i], fields.NumberOr(lens + names[i], 0));
  }
  raw.lens.model = LensDistortion::Model::kBrownConrady;
  raw.width_px = mode.width_px;
  raw.height_px = mode.height_px;
  return raw;
}

}  // namespace

Parsed FromRealSense(const Fields& fields, const CalibrationOptions& options) {
  return RealSense(fields, options).Read();
}

// R is Rodrigues' vector (RX, CV, RZ). (Baseline, TY, TZ) points to the right camera: it is -T of
// cv::stereoRectify, whose rectification does not depend on T's sign.
// Source: Stereolabs, zed-opencv-native.
Parsed FromZed(const Fields& fields, const CalibrationOptions& options) {
  const std::string part = options.part.empty() ? "HD" : options.part;
  const ZedMode* mode = std::find_if(std::begin(kZedModes), std::end(kZedModes),
                                     [&](const ZedMode& m) { return part == m.name; });
  if (mode == std::end(kZedModes)) {
    return fields.Error("calibration_part", Quoted(part) +
                                                " is no resolution, allowed are 2K, FHD, HD, VGA, "
                                                "FHD1200 and SVGA");
  }
  StereoCalibration calibration;
  calibration.format = "zed";
  calibration.raw.emplace();
  ASSIGN_OR_RETURN((*calibration.raw)[0], ZedEye(fields, "LEFT", *mode));
  ASSIGN_OR_RETURN((*calibration.raw)[1], ZedEye(fields, "RIGHT", *mode));
  calibration.rectified = (*calibration.raw)[0].k;
  calibration.width_px = mode->width_px;
  calibration.height_px = mode->height_px;
  const auto of_mode = [&](const char* name) -> absl::StatusOr<double> {
    const std::string own = std::string("STEREO.") + name + "_" + part;
    return fields.NumberOr(fields.Has(own) ? own : std::string("STEREO.") + name, 0);
  };
  ASSIGN_OR_RETURN(const double rx, of_mode("RX"));
  ASSIGN_OR_RETURN(const double cv, of_mode("CV"));
  ASSIGN_OR_RETURN(const double rz, of_mode("RZ"));
  ASSIGN_OR_RETURN(const double baseline, fields.Number("STEREO.Baseline"));
  ASSIGN_OR_RETURN(const double ty, of_mode("TY"));
  ASSIGN_OR_RETURN(const double tz, of_mode("TZ"));
  const Eigen::Vector3d vector(rx, cv, rz);
  const Eigen::Matrix3d rotation =
      vector.norm() > 0 ? Eigen::AngleAxisd(vector.norm(), vector.normalized()).toRotationMatrix()
                        : Eigen::Matrix3d::Identity();
  const Eigen::Vector3d place =
      -options.unit_m.value_or(kMillimetre_m) * Eigen::Vector3d(baseline, ty, tz);
  RETURN_IF_ERROR(Rectify(fields, "STEREO.Baseline", rotation, place, &calibration));
  return calibration;
}

}  // namespace parallax::calibration_internal
