#include "worker/assets/kernel/sweep.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax::kernel {
namespace {

struct Frame {
  Vec3f x, y;
};

Frame FrameTowards(const Vec3f& tangent, const Vec3f& up) {
  Vec3f x = up.cross(tangent);
  if (x.norm() < 1e-5f) x = Vec3f::UnitX().cross(tangent);
  if (x.norm() < 1e-5f) x = Vec3f::UnitY().cross(tangent);
  x.normalize();
  return {x, tangent.cross(x).normalized()};
}

// Closes an open end with a fan round its middle.
void Cap(Shape& shape, uint32_t first, uint32_t count, bool at_start) {
  Vec3f middle = Vec3f::Zero(), texture = Vec3f::Zero();
  for (uint32_t s = 0; s < count; ++s) {
    middle += shape.points[first + s];
    texture += shape.texture[first + s];
  }
  const float inv = 1.0f / static_cast<float>(count);
  const uint32_t center = shape.AddPoint(inv * middle, inv * texture);
  for (uint32_t s = 0; s < count; ++s) {
    const uint32_t t = (s + 1) % count;
    if (at_start) {
      shape.AddTriangle(center, first + t, first + s);
    } else {
      shape.AddTriangle(center, first + s, first + t);
    }
  }
}

// The path without points that coincide, or that lie so close to an end that its rounding, which
// needs a straight end as long as its radius, has no room.
Path3 CleanPath(const Path3& given, const SweepOptions& options) {
  Path3 path;
  for (const Vec3f& p : given) {
    if (path.empty() || (p - path.back()).norm() > 1e-6f) path.push_back(p);
  }
  if (options.closed || options.end_round_m <= 0) return path;
  const float room = 1.1f * options.end_round_m;
  while (path.size() > 3 && (path.back() - path[path.size() - 2]).norm() < room)
    path.erase(path.end() - 2);
  while (path.size() > 3 && (path.front() - path[1]).norm() < room) path.erase(path.begin() + 1);
  return path;
}

// A path with what the section needs at each of its points.
struct SweptPath {
  SweptPath(const Path3& given, const SweepOptions& options)
      : points(CleanPath(given, options)), tangents(points.size()), arc(points.size(), 0.0f) {
    Measure(options.closed);
    MakeFrames(options);
    if (options.closed && !options.keep_up) CloseTwist();
  }

  int size() const { return static_cast<int>(points.size()); }
  float length() const { return arc.back(); }

  Path3 points;
  std::vector<Vec3f> tangents;
  std::vector<float> arc;     // Length from the start.
  std::vector<Frame> frames;  // Axes of the section.
  float closing_twist = 0;    // Turns the last frame of a ring into the first.

 private:
  void Measure(bool closed) {
    const int n = size();
    for (int i = 0; i < n; ++i) {
      const Vec3f& before = closed ? points[(i + n - 1) % n] : points[std::max(i - 1, 0)];
      const Vec3f& after = closed ? points[(i + 1) % n] : points[std::min(i + 1, n - 1)];
      tangents[i] = (after - before).normalized();
      if (i > 0) arc[i] = arc[i - 1] + (points[i] - points[i - 1]).norm();
    }
  }

  // The first frame, carried along without twist or turned towards `up` at every point.
  void MakeFrames(const SweepOptions& options) {
    Vec3f up = options.up;
    if (up.isZero()) up = std::abs(tangents[0].z()) > 0.8f ? Vec3f::UnitY() : Vec3f::UnitZ();
    frames.push_back(FrameTowards(tangents[0], up));
    for (int i = 1; i < size(); ++i) {
      if (options.keep_up) {
        frames.push_back(FrameTowards(tangents[i], up));
      } else {
        const Eigen::Quaternionf turn =
            Eigen::Quaternionf::FromTwoVectors(tangents[i - 1], tangents[i]);
        frames.push_back(FrameTowards(tangents[i], turn * frames.back().y));
      }
    }
  }

  void CloseTwist() {
    const Eigen::Quaternionf turn =
        Eigen::Quaternionf::FromTwoVectors(tangents.back(), tangents[0]);
    const Vec3f x = turn * frames.back().x;
    closing_twist = -std::atan2(x.dot(frames[0].y), x.dot(frames[0].x));
  }
};

// Puts sections along a path as rings of points.
class SectionRings {
 public:
  SectionRings(const SweptPath& path, const Path2& section, const SweepOptions& options,
               Shape& shape)
      : path_(path), section_(section), options_(options), shape_(shape) {
    for (const Vec2f& p : section) half_ = half_.cwiseMax(p.cwiseAbs());
  }

  // A ring at point `i`, moved along its tangent and shrunk by `inset` on each side.
  void Add(int i, float shift, float inset) {
    const float t = path_.length() > 0 ? path_.arc[i] / path_.length() : 0.0f;
    const Vec2f scale = options_.scale ? options_.scale(t) : Vec2f(1, 1);
    const float twist =
        (options_.twist_rad ? options_.twist_rad(t) : 0.0f) +
        path_.closing_twist * static_cast<float>(i) / static_cast<float>(path_.size());
    const float c = std::cos(twist), s = std::sin(twist);
    const Vec2f size = half_.cwiseProduct(scale).cwiseMax(1e-6f);
    const Vec2f shrink = (size - Vec2f::Constant(inset)).cwiseMax(0.04f * size).cwiseQuotient(size);
    const Vec3f &at = path_.points[i], &tangent = path_.tangents[i];
    const Frame& frame = path_.frames[i];
    for (const Vec2f& p : section_) {
      const Vec2f q = p.cwiseProduct(scale).cwiseProduct(shrink);
      const Vec2f r(c * q.x() - s * q.y(), s * q.x() + c * q.y());
      shape_.AddPoint(at + shift * tangent + r.x() * frame.x + r.y() * frame.y,
                      {path_.arc[i] + shift, p.x(), p.y()});
    }
    ++rings_;
  }

  // A rounded start and end: a quarter of a circle in steps, its radius at most what `next` leaves.
  void AddRoundedStart() {
    const float r = EndRadius(0, 1);
    for (int k = kSteps; k >= 1; --k) {
      const float a = 0.5f * kPi * static_cast<float>(k) / kSteps;
      Add(0, r * (1 - std::sin(a)), options_.end_round_m * (1 - std::cos(a)));
    }
    Add(0, r, 0);
  }
  void AddRoundedEnd() {
    const int n = path_.size();
    const float r = EndRadius(n - 1, n - 2);
    Add(n - 1, -r, 0);
    for (int k = 1; k <= kSteps; ++k) {
      const float a = 0.5f * kPi * static_cast<float>(k) / kSteps;
      Add(n - 1, -r * (1 - std::sin(a)), options_.end_round_m * (1 - std::cos(a)));
    }
  }

  int rings() const { return rings_; }

 private:
  static constexpr int kSteps = 4;

  float EndRadius(int end, int next) const {
    return std::min(options_.end_round_m, 0.9f * (path_.points[end] - path_.points[next]).norm());
  }

  const SweptPath& path_;
  const Path2& section_;
  const SweepOptions& options_;
  Shape& shape_;
  Vec2f half_ = Vec2f::Zero();
  int rings_ = 0;
};

// Quads from ring to ring of `m` points; open ends get caps.
void JoinRings(Shape& shape, int rings, uint32_t m, bool closed) {
  const int spans = closed ? rings : rings - 1;
  for (int i = 0; i < spans; ++i) {
    const uint32_t a = static_cast<uint32_t>(i) * m;
    const uint32_t b = static_cast<uint32_t>((i + 1) % rings) * m;
    for (uint32_t s = 0; s < m; ++s) {
      const uint32_t t = (s + 1) % m;
      shape.AddQuad(a + s, a + t, b + t, b + s);
    }
  }
  if (closed) return;
  Cap(shape, 0, m, true);
  Cap(shape, static_cast<uint32_t>(rings - 1) * m, m, false);
}

}  // namespace

Shape Sweep(const Path3& given, const Path2& section, const SweepOptions& options) {
  const SweptPath path(given, options);
  Shape shape;
  SectionRings rings(path, section, options, shape);
  const int n = path.size();
  const bool rounded = !options.closed && options.end_round_m > 0;
  rounded ? rings.AddRoundedStart() : rings.Add(0, 0, 0);
  for (int i = 1; i + 1 < n; ++i) rings.Add(i, 0, 0);
  rounded ? rings.AddRoundedEnd() : rings.Add(n - 1, 0, 0);
  JoinRings(shape, rings.rings(), static_cast<uint32_t>(section.size()), options.closed);
  return shape;
}

Shape Tube(const Path3& path, float radius, float end_round_m, int segments) {
  const SweepOptions options{.end_round_m = end_round_m};
  const int n =
      segments > 0 ? DetailedSegments(segments, radius) : std::min(CircleSegments(radius), 24);
  return Sweep(path, EllipseSection(2 * radius, 2 * radius, n), options);
}

Shape Ring(const Path3& closed_path, float radius, int segments) {
  const SweepOptions options{.closed = true};
  const int n = DetailedSegments(segments, radius);
  return Sweep(closed_path, EllipseSection(2 * radius, 2 * radius, n), options);
}

Shape Rod(const Vec3f& from, const Vec3f& to, float from_radius, float to_radius,
          float end_round_m) {
  SweepOptions options{.end_round_m = end_round_m};
  const float largest = std::max(from_radius, to_radius);
  options.scale = [=](float t) {
    return Vec2f::Constant(Lerp(from_radius, to_radius, t) / largest).eval();
  };
  return Sweep({from, to},
               EllipseSection(2 * largest, 2 * largest, std::min(CircleSegments(largest), 24)),
               options);
}

Shape Bar(const Vec3f& from, const Vec3f& to, const Vec2f& from_size, const Vec2f& to_size,
          float bevel_m, const Vec3f& up) {
  SweepOptions options{.end_round_m = bevel_m, .up = up};
  const Vec2f largest = from_size.cwiseMax(to_size);
  options.scale = [=](float t) {
    return (from_size + t * (to_size - from_size)).cwiseQuotient(largest).eval();
  };
  return Sweep({from, to}, RectSection(largest.x(), largest.y(), bevel_m, 2), options);
}

std::vector<std::array<uint32_t, 3>> Triangulate(const Path2& polygon) {
  std::vector<std::array<uint32_t, 3>> out;
  std::vector<uint32_t> left(polygon.size());
  for (size_t i = 0; i < left.size(); ++i) left[i] = static_cast<uint32_t>(i);
  const auto cross = [&](uint32_t a, uint32_t b, uint32_t c) {
    const Vec2f u = polygon[b] - polygon[a], v = polygon[c] - polygon[a];
    return u.x() * v.y() - u.y() * v.x();
  };
  while (left.size() > 3) {
    const size_t n = left.size();
    size_t best = n;
    float best_quality = -1;
    for (size_t i = 0; i < n; ++i) {
      const uint32_t a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
      const float area = cross(a, b, c);
      if (area <= 0) continue;
      bool ear = true;
      for (uint32_t p : left) {
        if (p == a || p == b || p == c) continue;
        if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) {
          ear = false;
          break;
        }
      }
      if (!ear) continue;
      // Compact ears first: slivers shade badly.
      const float reach = (polygon[c] - polygon[a]).squaredNorm();
      const float quality = area / std::max(reach, 1e-20f);
      if (quality > best_quality) {
        best_quality = quality;
        best = i;
      }
    }
    if (best == n) best = 0;  // Only collinear corners are left.
    out.push_back({left[(best + n - 1) % n], left[best], left[(best + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  out.push_back({left[0], left[1], left[2]});
  return out;
}

namespace {

// For each corner, the way it moves when the polygon shrinks by one.
std::vector<Vec2f> InwardOffsets(const Path2& polygon) {
  const size_t n = polygon.size();
  std::vector<Vec2f> inward(n);
  for (size_t i = 0; i < n; ++i) {
    const Vec2f in = (polygon[i] - polygon[(i + n - 1) % n]).normalized();
    const Vec2f go = (polygon[(i + 1) % n] - polygon[i]).normalized();
    const Vec2f a(-in.y(), in.x()), b(-go.y(), go.x());
    const Vec2f sum = a + b;
    inward[i] = sum.squaredNorm() > 0.1f ? Vec2f(2.0f * sum / sum.squaredNorm()) : a;
  }
  return inward;
}

// Heights of a prism's levels and how far each is drawn in, from the lower bevel to the upper.
std::vector<std::pair<float, float>> PrismLevels(float height, float bevel, int pieces) {
  std::vector<std::pair<float, float>> levels;
  if (bevel <= 0) {
    for (int k = 0; k <= pieces; ++k)
      levels.emplace_back(height * static_cast<float>(k) / static_cast<float>(pieces), 0.0f);
    return levels;
  }
  for (int k = 2; k >= 0; --k) {
    const float a = 0.25f * kPi * static_cast<float>(k);
    levels.emplace_back(bevel * (1 - std::sin(a)), bevel * (1 - std::cos(a)));
  }
  for (int k = 1; k < pieces; ++k)
    levels.emplace_back(
        Lerp(bevel, height - bevel, static_cast<float>(k) / static_cast<float>(pieces)), 0.0f);
  for (int k = 0; k <= 2; ++k) {
    const float a = 0.25f * kPi * static_cast<float>(k);
    levels.emplace_back(height - bevel * (1 - std::sin(a)), bevel * (1 - std::cos(a)));
  }
  return levels;
}

}  // namespace

Shape Extrude(const Path2& polygon, float height, float bevel_m, int pieces) {
  const std::vector<Vec2f> inward = InwardOffsets(polygon);
  const auto levels = PrismLevels(height, std::min(bevel_m, 0.45f * height), pieces);
  Shape shape;
  for (const auto& [z, inset] : levels) {
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Vec2f p = polygon[i] + inset * inward[i];
      shape.AddPoint({p.x(), p.y(), z});
    }
  }
  const uint32_t m = static_cast<uint32_t>(polygon.size());
  for (uint32_t level = 0; level + 1 < levels.size(); ++level) {
    for (uint32_t s = 0; s < m; ++s) {
      const uint32_t t = (s + 1) % m, a = level * m, c = (level + 1) * m;
      shape.AddQuad(a + s, a + t, c + t, c + s);
    }
  }
  const uint32_t top = (static_cast<uint32_t>(levels.size()) - 1) * m;
  for (const auto& [i, j, k] : Triangulate(polygon)) {
    shape.AddTriangle(i, k, j);
    shape.AddTriangle(top + i, top + j, top + k);
  }
  TextureAlongLongest(shape);
  return shape;
}

}  // namespace parallax::kernel
