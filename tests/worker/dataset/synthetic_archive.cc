#include "tests/worker/dataset/synthetic_archive.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/sensor_presets.h"
#include "tests/worker/dataset/synthetic_scene.h"
#include "worker/dataset/archive/archive.h"
#include "worker/dataset/frame/frame_writer.h"

namespace parallax {
namespace {

void Must(const absl::Status& status) {
  if (status.ok()) return;
  std::cerr << status << "\n";
  std::abort();
}

// The synthetic scene knows exact visibility; archives hold what re-projection with 1 % gives.
void Reproject(const View& view, const View& other, int sign, ImageU8& occlusion) {
  for (int y = 0; y < occlusion.height(); ++y) {
    for (int x = 0; x < occlusion.width(); ++x) {
      const double z = double{view.depth_m(x, y)};
      const double c = x + sign * double{view.disparity_px(x, y)};
      bool visible = z > 0 ? c >= -0.5 && c < occlusion.width() - 0.5 : other.depth_m(x, y) <= 0;
      if (visible && z > 0) {
        const double at = std::clamp(c, 0.0, occlusion.width() - 1.0);
        const int x0 = static_cast<int>(at), x1 = std::min(x0 + 1, occlusion.width() - 1);
        const double a = double{other.depth_m(x0, y)}, b = double{other.depth_m(x1, y)};
        const auto near = [z](double depth) { return std::abs(depth - z) <= 0.01 * z; };
        const double t = at - x0;
        visible = near(a) || near(b) || (a > 0 && b > 0 && near(1 / ((1 - t) / a + t / b)));
      }
      occlusion(x, y) = visible ? 0 : 255;
    }
  }
}

ImageU8 GreyOf(const ImageRgb8& color) {
  ImageU8 grey(color.width(), color.height());
  for (size_t i = 0; i < grey.pixels(); ++i) grey.values()[i] = color.values()[3 * i + 1];
  return grey;
}

// Raw cameras that are the rectified ones.
void AddRawCameras(v1::Scene& scene) {
  for (v1::Rig& rig : *scene.mutable_rigs()) {
    v1::RawCamera& raw = *rig.mutable_raw_left();
    raw.set_fx_px(rig.fx_px());
    raw.set_fy_px(rig.fy_px());
    raw.set_cx_px(rig.cx_px());
    raw.set_cy_px(rig.cy_px());
    raw.set_qw(1);
    raw.set_width_px(rig.width_px());
    raw.set_height_px(rig.height_px());
    raw.set_lens(v1::LensConfig::MODEL_NONE);
    *rig.mutable_raw_right() = raw;
  }
}

void GiveExtras(View& view, float sign, RawView& raw) {
  view.infrared = GreyOf(view.color);
  raw.color = view.color;
  raw.occlusion = view.occlusion;
  raw.flow = ImageF3(view.color.width(), view.color.height());
  for (size_t i = 0; i < view.disparity_px.pixels(); ++i) {
    raw.flow.values()[3 * i] = sign * view.disparity_px.values()[i];
    raw.flow.values()[3 * i + 2] = 1;
  }
}

}  // namespace

void MakeSyntheticArchive(const std::string& dir, const SyntheticArchive& options) {
  const std::string store = dir + ".store";
  std::filesystem::remove_all(dir);
  std::filesystem::remove_all(store);
  v1::StudySpec study;
  study.set_name("synthetic");
  study.set_seed(1);
  study.set_rigs_per_scene(options.rigs);
  study.set_pairs(int64_t{1} * options.scenes * options.rigs);
  for (const std::string& name : options.variants) {
    v1::VariantSpec& variant = *study.add_variants();
    variant.set_name(name);
    *variant.mutable_config() = DefaultSceneConfig();
    variant.mutable_config()->mutable_render()->set_keep_hdr(options.keep_hdr);
    if (options.sequence) {
      variant.mutable_config()->mutable_rigs()->mutable_path()->set_paths(1);
      variant.mutable_config()->mutable_render()->add_maps("flow");
    }
    TakeSensorPreset(options.sensor, variant.mutable_config()->mutable_sensor());
  }
  v1::RenderConfig& render = *study.mutable_variants(0)->mutable_config()->mutable_render();
  if (options.extras) {
    render.add_maps("raw");
    render.add_maps("infrared");
    render.add_maps("layers");
  }
  v1::Scene scene = MakeSyntheticScene(options.rigs, options.width_px, options.height_px);
  if (options.extras) AddRawCameras(scene);
  if (options.sequence) MakeSequence(scene);
  auto archive = ArchiveWriter::Open(dir, study);
  Must(archive.status());
  for (const std::string& variant : options.variants) {
    for (int s = 0; s < options.scenes; ++s) {
      Must((*archive)->AddScene(variant, static_cast<uint32_t>(s), scene));
      for (int r = 0; r < options.rigs; ++r) {
        const bool last = s == options.scenes - 1 && r == options.rigs - 1;
        if (last && options.last_frame_missing) continue;
        StereoFrame frame = RenderSyntheticFrame(scene, scene.rigs(r));
        Reproject(frame.left, frame.right, -1, frame.left.occlusion);
        Reproject(frame.right, frame.left, 1, frame.right.occlusion);
        if (last && options.last_frame_dark) {
          for (uint8_t& value : frame.left.color.values()) value = static_cast<uint8_t>(value / 64);
        }
        // Frames tell each other apart.
        frame.left.color(0, 0) = static_cast<uint8_t>(10 * s + r);
        if (options.keep_hdr) GiveLight(frame);
        if (options.sequence) GiveFlow(scene, scene.rigs(r), frame);
        if (options.extras) {
          GiveExtras(frame.left, -1, frame.raw_left);
          GiveExtras(frame.right, 1, frame.raw_right);
          GiveLayers(scene.rigs(r), frame);
        }
        const std::string path = variant + std::to_string(s) + "/.attempt-1/" + std::to_string(r);
        v1::PublishedFrame published;
        published.set_variant(variant);
        published.set_scene(static_cast<uint32_t>(s));
        auto written = WriteFrame({.scene = scene,
                                   .rig = scene.rigs(r),
                                   .frame = frame,
                                   .render = study.variants(0).config().render(),
                                   .dir = store + "/" + path,
                                   .store_path = path});
        Must(written.status());
        *published.mutable_frame() = *std::move(written);
        Must((*archive)->AddFrame(published, store));
      }
    }
  }
  Must((*archive)->Finish());
}

void ChangeIndex(const std::string& dir,
                 const std::function<void(nlohmann::ordered_json& line)>& change) {
  const std::string index = dir + "/a/index.jsonl";
  std::string text;
  std::istringstream in(*ReadFile(index));
  for (std::string line; std::getline(in, line);) {
    auto json = nlohmann::ordered_json::parse(line);
    change(json);
    text += json.dump() + "\n";
  }
  Must(WriteFile(index, text));
}

void ForgeFile(const std::string& dir, const std::string& name, const std::string& bytes) {
  const std::string path = dir + "/a/frames/000000/001/" + name;
  std::filesystem::remove(path);
  Must(WriteFile(path, bytes));
  ChangeIndex(dir, [&](nlohmann::ordered_json& line) {
    if (line["scene"] == 0 && line["rig"] == 1) line["files"][name] = Sha256Hex(bytes);
  });
}

}  // namespace parallax
