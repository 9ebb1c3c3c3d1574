// Draws a contact sheet of the asset catalogue with flat colours, sky light and a soft sun: to look
// at the modelling.
//   asset_sheet OUT.png [--seeds 2] [--cell 300] [--columns 8] [--first-seed 1] [--edge-mm 0]
//               [CLASS...]
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "worker/assets/asset.h"
#include "worker/assets/detail.h"

namespace parallax {
namespace {

constexpr float kPi = 3.14159265f;

Vec3f FamilyColor(const MaterialSlot& slot) {
  if (slot.emissive) return {1.0f, 0.9f, 0.7f};
  const std::string family = slot.families.empty() ? "" : slot.families.front();
  uint32_t hash = 2166136261u;
  for (char c : slot.name) hash = (hash ^ static_cast<uint32_t>(c)) * 16777619u;
  const float shade = 0.85f + 0.3f * static_cast<float>(hash % 97) / 97.0f;
  Vec3f color(0.5f, 0.5f, 0.5f);
  if (family == "wood") color = {0.42f, 0.25f, 0.13f};
  if (family == "fabric") color = {0.34f, 0.42f, 0.46f};
  if (family == "leather") color = {0.3f, 0.14f, 0.08f};
  if (family == "metal") color = {0.42f, 0.43f, 0.45f};
  if (family == "plastic") color = {0.62f, 0.6f, 0.56f};
  if (family == "ceramic") color = {0.7f, 0.7f, 0.66f};
  if (family == "glass") color = {0.55f, 0.68f, 0.66f};
  if (family == "paper") color = {0.75f, 0.72f, 0.64f};
  if (family == "picture") color = {0.3f, 0.35f, 0.6f};
  if (family == "leaf") color = {0.13f, 0.3f, 0.08f};
  if (family == "soil") color = {0.12f, 0.08f, 0.05f};
  if (family == "paint") color = {0.65f, 0.64f, 0.6f};
  if (family == "stone") color = {0.55f, 0.54f, 0.5f};
  if (family == "carpet") color = {0.45f, 0.2f, 0.18f};
  if (family == "mirror") color = {0.7f, 0.75f, 0.8f};
  if (family == "bark") color = {0.25f, 0.17f, 0.11f};
  if (slot.sheet) color = {0.12f, 0.2f, 0.06f};
  const bool brown = family == "AutumnLeaf" || family == "DryLeaf" || family == "DryGrass";
  if (brown) color = {0.4f, 0.25f, 0.1f};
  if (family == "BirchBark" || family == "WhitePetal") color = {0.7f, 0.68f, 0.62f};
  if (family == "FurrowedBark" || family == "ConiferBark") color = {0.22f, 0.17f, 0.13f};
  // A hue of its own for each slot name.
  const Vec3f tint(0.75f + 0.5f * static_cast<float>(hash / 97 % 89) / 89.0f,
                   0.8f + 0.4f * static_cast<float>(hash / 8633 % 83) / 83.0f,
                   0.75f + 0.5f * static_cast<float>(hash / 716539 % 79) / 79.0f);
  return (color * shade).cwiseProduct(tint);
}

struct Frame {
  Vec3f x, y, z;
  explicit Frame(const Vec3f& n) : z(n) {
    x = (std::abs(n.x()) > 0.5f ? Vec3f::UnitY() : Vec3f::UnitX()).cross(n).normalized();
    y = n.cross(x);
  }
};

bool Blocked(RTCScene scene, const Vec3f& origin, const Vec3f& direction) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.mask = ~0u;
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0;
}

// One cell, linear colour to 8 bit.
cv::Mat Draw(RTCDevice device, const Asset& asset, Placement placement, int size) {
  const Mesh& mesh = asset.mesh;
  const Box3f box = mesh.Bounds();
  const float radius = 0.5f * box.diagonal().norm();
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.positions.size() + 4));
  auto* t = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size() + 2));
  for (const Vec3f& p : mesh.positions) *v++ = p.x(), *v++ = p.y(), *v++ = p.z();
  // Ground, or the wall behind; nothing below hanging things.
  const float far = 40 * radius;
  const bool wall = placement == Placement::kOnWall || placement == Placement::kOpening;
  const float ground =
      placement == Placement::kCeiling ? box.min().z() - 30 * radius : box.min().z();
  for (const Vec2f& c : {Vec2f(-1, -1), Vec2f(1, -1), Vec2f(1, 1), Vec2f(-1, 1)}) {
    const Vec3f p = wall ? Vec3f(-far * c.x(), box.min().y(), far * c.y())
                         : Vec3f(far * c.x(), far * c.y(), ground);
    *v++ = p.x(), *v++ = p.y(), *v++ = p.z();
  }
  for (const Triangle& tri : mesh.triangles) *t++ = tri.a, *t++ = tri.b, *t++ = tri.c;
  const uint32_t base = static_cast<uint32_t>(mesh.positions.size());
  for (uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) *t++ = base + k;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);

  const Vec3f view = placement == Placement::kCeiling  ? Vec3f(0.55f, 0.8f, -0.12f)
                     : placement == Placement::kGround ? Vec3f(0.62f, 0.85f, 0.2f)
                                                       : Vec3f(0.62f, 0.85f, 0.48f);
  const Vec3f forward = -view.normalized();
  const Vec3f right = forward.cross(Vec3f::UnitZ()).normalized(), up = right.cross(forward);
  const float fov = 0.42f;
  // Fit the box's corners rather than its sphere.
  float distance = 0;
  const Vec3f target = box.center();
  for (int c = 0; c < 8; ++c) {
    const Vec3f p = box.corner(static_cast<Box3f::CornerType>(c)) - target;
    distance = std::max({distance, -p.dot(forward) + std::abs(p.dot(right)) / std::tan(0.47f * fov),
                         -p.dot(forward) + std::abs(p.dot(up)) / std::tan(0.47f * fov)});
  }
  const Vec3f eye = target - distance * forward;
  const Vec3f sun = Vec3f(0.75f, 0.35f, 1.0f).normalized();

  cv::Mat image(size, size, CV_8UC3);
  for (int y = 0; y < size; ++y) {
    uint32_t state = 9781u * static_cast<uint32_t>(y + 1);
    const auto random = [&] {
      state = state * 747796405u + 2891336453u;
      const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
      return static_cast<float>((word >> 22) ^ word) * 2.3283064e-10f;
    };
    for (int x = 0; x < size; ++x) {
      Vec3f sum = Vec3f::Zero();
      constexpr int kSamples = 9;
      for (int s = 0; s < kSamples; ++s) {
        const float px = (2 * (static_cast<float>(x) + (static_cast<float>(s % 3) + random()) / 3) /
                              static_cast<float>(size) -
                          1) *
                         std::tan(0.5f * fov);
        const float py =
            (1 - 2 * (static_cast<float>(y) + (static_cast<float>(s / 3) + random()) / 3) /
                     static_cast<float>(size)) *
            std::tan(0.5f * fov);
        const Vec3f direction = (forward + px * right + py * up).normalized();
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit hit{};
        hit.ray.org_x = eye.x(), hit.ray.org_y = eye.y(), hit.ray.org_z = eye.z();
        hit.ray.dir_x = direction.x(), hit.ray.dir_y = direction.y(), hit.ray.dir_z = direction.z();
        hit.ray.tfar = std::numeric_limits<float>::infinity();
        hit.ray.mask = ~0u;
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
          sum += Vec3f(0.75f, 0.8f, 0.85f);
          continue;
        }
        Vec3f n(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z), color(0.6f, 0.6f, 0.6f);
        n.normalize();
        const Vec3f p = eye + hit.ray.tfar * direction;
        bool emissive = false;
        float gloss = 0;
        bool wrong = false;
        if (hit.hit.primID < mesh.triangles.size()) {
          const Triangle& tri = mesh.triangles[hit.hit.primID];
          const float u = hit.hit.u, w = hit.hit.v;
          wrong = n.dot(direction) > 0;  // Seen from inside: an error of winding or a hole.
          n = ((1 - u - w) * mesh.normals[tri.a] + u * mesh.normals[tri.b] +
               w * mesh.normals[tri.c])
                  .normalized();
          const MaterialSlot& slot = mesh.slots[tri.slot];
          if (slot.sheet && wrong) n = -n;
          wrong &= !slot.sheet;
          color = FamilyColor(slot);
          if (slot.sheet) color *= 0.75f + 0.5f * mesh.uv[tri.a].x();
          emissive = slot.emissive;
          const std::string family = slot.families.empty() ? "" : slot.families.front();
          if (family == "picture") {
            const Vec2f uv = (1 - u - w) * mesh.uv[tri.a] + u * mesh.uv[tri.b] + w * mesh.uv[tri.c];
            const int cell =
                static_cast<int>(std::floor(uv.x() * 6)) + static_cast<int>(std::floor(uv.y() * 6));
            color = Vec3f(0.2f + 0.6f * uv.x(), 0.25f + 0.5f * uv.y(), 0.45f) *
                    (cell % 2 ? 1.0f : 0.8f);
          }
          if (family == "metal" || family == "ceramic" || family == "glass") gloss = 0.5f;
          if (family == "wood" || family == "plastic") gloss = 0.15f;
        }
        if (wrong) {
          sum += Vec3f(1, 0, 1);
          continue;
        }
        if (emissive) {
          sum += 1.4f * color;
          continue;
        }
        const Vec3f from = p + 2e-4f * radius * n - 1e-4f * radius * direction;
        const Frame frame(n);
        const float a = 2 * kPi * random(), r = std::sqrt(random());
        const Vec3f sky =
            r * std::cos(a) * frame.x + r * std::sin(a) * frame.y + std::sqrt(1 - r * r) * frame.z;
        Vec3f light = Vec3f::Zero();
        if (!Blocked(scene, from, sky))
          light += Vec3f(0.62f, 0.66f, 0.72f) * (0.75f + 0.35f * sky.z());
        const Frame towards(sun);
        const float b = 2 * kPi * random(), q = 0.12f * std::sqrt(random());
        const Vec3f to_sun =
            (sun + q * std::cos(b) * towards.x + q * std::sin(b) * towards.y).normalized();
        const float cosine = n.dot(to_sun);
        const bool lit = cosine > 0 && !Blocked(scene, from, to_sun);
        if (lit) light += Vec3f(1.25f, 1.15f, 1.0f) * cosine;
        light += Vec3f::Constant(0.22f * std::abs(n.dot(direction)));
        Vec3f out = color.cwiseProduct(light);
        if (gloss > 0) {
          const Vec3f half = (to_sun - direction).normalized();
          if (lit)
            out += Vec3f::Constant(gloss * 1.6f * std::pow(std::max(0.0f, n.dot(half)), 60.0f));
          const Vec3f mirror = direction - 2 * n.dot(direction) * n;
          const float fresnel =
              gloss * (0.1f + 0.9f * std::pow(1 - std::abs(n.dot(direction)), 4.0f));
          if (!Blocked(scene, from, mirror))
            out += fresnel * (mirror.z() > 0 ? 0.9f : 0.35f) * Vec3f(0.8f, 0.85f, 0.9f);
        }
        sum += out;
      }
      const Vec3f mean = 0.62f * sum / static_cast<float>(kSamples);
      for (int c = 0; c < 3; ++c) {
        const float value = std::pow(std::clamp(mean[c], 0.0f, 1.0f), 1 / 2.2f);
        image.at<cv::Vec3b>(y, x)[2 - c] = static_cast<uint8_t>(255 * value + 0.5f);
      }
    }
  }
  rtcReleaseScene(scene);
  return image;
}

int Main(int argc, char** argv) {
  int seeds = 2, cell = 300, columns = 8, first_seed = 1, edge_mm = 0;
  std::vector<std::string> names;
  std::string out;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::atoi(argv[++i]) : 0; };
    if (word == "--seeds")
      seeds = value();
    else if (word == "--cell")
      cell = value();
    else if (word == "--columns")
      columns = value();
    else if (word == "--first-seed")
      first_seed = value();
    else if (word == "--edge-mm")
      edge_mm = value();
    else if (out.empty())
      out = word;
    else
      names.push_back(word);
  }
  if (out.empty()) {
    std::fprintf(stderr,
                 "usage: asset_sheet OUT.png [--seeds N] [--cell PX] [--columns N] [--first-seed "
                 "N] [--edge-mm N] [CLASS...]\n");
    return 2;
  }
  if (names.empty()) {
    for (const AssetClass& c : AssetCatalogue()) names.push_back(c.name);
  }
  RTCDevice device = rtcNewDevice(nullptr);
  std::vector<cv::Mat> cells;
  for (const std::string& name : names) {
    for (int s = 0; s < seeds; ++s) {
      const int64_t start = cv::getTickCount();
      const auto asset = MakeAsset(name, static_cast<uint64_t>(first_seed + s),
                                   1e-3f * static_cast<float>(edge_mm));
      const double ms =
          1e3 * static_cast<double>(cv::getTickCount() - start) / cv::getTickFrequency();
      if (!asset.ok()) {
        std::fprintf(stderr, "%s\n", asset.status().ToString().c_str());
        return 1;
      }
      if (const absl::Status valid = ValidateMesh(asset->mesh); !valid.ok()) {
        std::fprintf(stderr, "%s seed %d: %s\n", name.c_str(), first_seed + s,
                     valid.ToString().c_str());
      }
      const Vec3f size = asset->mesh.Bounds().sizes();
      std::printf("%-22s %2d  %7zu triangles  %6.2f ms  %.2f x %.2f x %.2f m\n", name.c_str(),
                  first_seed + s, asset->mesh.triangles.size(), ms, size.x(), size.y(), size.z());
      cv::Mat image = Draw(device, *asset, FindAssetClass(name)->placement, cell);
      char label[128];
      std::snprintf(label, sizeof(label), "%s  %.2f x %.2f x %.2f  %zuk", name.c_str(), size.x(),
                    size.y(), size.z(), (asset->mesh.triangles.size() + 500) / 1000);
      cv::putText(image, label, {6, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.4, {0, 0, 0}, 1, cv::LINE_AA);
      cells.push_back(image);
    }
  }
  const int rows = (static_cast<int>(cells.size()) + columns - 1) / columns;
  cv::Mat sheet(rows * cell, std::min<int>(columns, static_cast<int>(cells.size())) * cell, CV_8UC3,
                cv::Scalar::all(255));
  for (size_t i = 0; i < cells.size(); ++i) {
    const int x = static_cast<int>(i) % columns * cell, y = static_cast<int>(i) / columns * cell;
    cells[i].copyTo(sheet(cv::Rect(x, y, cell, cell)));
  }
  cv::imwrite(out, sheet);
  rtcReleaseDevice(device);
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
