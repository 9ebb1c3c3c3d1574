#include "worker/assets/kernel/subdivide.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax::kernel {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// The interpolated value: OpenSubdiv asks for these two members.
template <typename Value>
struct Primvar {
  Value value;
  void Clear() { value.setZero(); }
  void AddWithWeight(const Primvar& other, float weight) { value += weight * other.value; }
};
using PointVar = Primvar<Eigen::Matrix<float, 6, 1>>;  // Position and texture.
using UvVar = Primvar<Vec2f>;

// Each point's different uv values, numbered: seams are where a point has several.
struct UvChannel {
  std::vector<UvVar> values;
  std::vector<int> of_corner;
};

UvChannel CollectUv(const Shape& shape) {
  UvChannel channel;
  std::map<std::tuple<uint32_t, float, float>, int> known;
  for (const Face& f : shape.faces) {
    for (int k = 0; k < f.corners; ++k) {
      const auto [at, added] = known.try_emplace({f.v[k], f.uv[k].x(), f.uv[k].y()},
                                                 static_cast<int>(channel.values.size()));
      if (added) channel.values.push_back({f.uv[k]});
      channel.of_corner.push_back(at->second);
    }
  }
  return channel;
}

float MeanEdge(const Shape& shape) {
  double sum = 0;
  size_t count = 0;
  for (const Face& f : shape.faces) {
    for (int k = 0; k < f.corners; ++k, ++count) {
      sum += (shape.points[f.v[k]] - shape.points[f.v[(k + 1) % f.corners]]).norm();
    }
  }
  return count ? static_cast<float>(sum / static_cast<double>(count)) : 0.0f;
}

Vec3f Middle(const Shape& shape, const Face& face) {
  Vec3f sum = Vec3f::Zero();
  for (int k = 0; k < face.corners; ++k) sum += shape.points[face.v[k]];
  return sum / static_cast<float>(face.corners);
}

std::unique_ptr<Far::TopologyRefiner> MakeRefiner(const Cage& cage, const UvChannel* uv) {
  std::vector<int> corners, corner_points, crease_points;
  std::vector<float> sharpness;
  for (const Face& f : cage.shape.faces) {
    corners.push_back(f.corners);
    for (int k = 0; k < f.corners; ++k) corner_points.push_back(static_cast<int>(f.v[k]));
  }
  for (const Crease& c : cage.creases) {
    if (c.sharpness <= 0) continue;
    crease_points.insert(crease_points.end(), {static_cast<int>(c.a), static_cast<int>(c.b)});
    sharpness.push_back(std::min(c.sharpness, 10.0f));
  }
  Far::TopologyDescriptor topology;
  topology.numVertices = static_cast<int>(cage.shape.points.size());
  topology.numFaces = static_cast<int>(corners.size());
  topology.numVertsPerFace = corners.data();
  topology.vertIndicesPerFace = corner_points.data();
  topology.numCreases = static_cast<int>(sharpness.size());
  topology.creaseVertexIndexPairs = crease_points.data();
  topology.creaseWeights = sharpness.data();
  Far::TopologyDescriptor::FVarChannel channel;
  if (uv != nullptr) {
    channel.numValues = static_cast<int>(uv->values.size());
    channel.valueIndices = uv->of_corner.data();
    topology.numFVarChannels = 1;
    topology.fvarChannels = &channel;
  }
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_BOUNDARIES);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  return std::unique_ptr<Far::TopologyRefiner>(
      Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, options)));
}

}  // namespace

Shape Subdivided(const Cage& cage, int levels) {
  const Shape& from = cage.shape;
  const int pieces = DetailedPieces(1 << levels, MeanEdge(from), 2);
  levels = std::max(1, static_cast<int>(std::lround(std::log2(static_cast<float>(pieces)))));
  const bool printed = std::any_of(from.faces.begin(), from.faces.end(), [](const Face& f) {
    return std::any_of(f.uv.begin(), f.uv.end(), [](const Vec2f& v) { return !v.isZero(); });
  });
  UvChannel uv;
  if (printed) uv = CollectUv(from);
  const auto refiner = MakeRefiner(cage, printed ? &uv : nullptr);
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;  // The limit needs each point's neighbours.
  refiner->RefineUniform(uniform);

  const Far::PrimvarRefiner primvars(*refiner);
  std::vector<PointVar> points(from.points.size());
  for (size_t i = 0; i < points.size(); ++i) points[i].value << from.points[i], from.texture[i];
  for (int level = 1; level <= levels; ++level) {
    std::vector<PointVar> finer(static_cast<size_t>(refiner->GetLevel(level).GetNumVertices()));
    primvars.Interpolate(level, points, finer);
    points = std::move(finer);
    if (!printed) continue;
    std::vector<UvVar> finer_uv(static_cast<size_t>(refiner->GetLevel(level).GetNumFVarValues(0)));
    primvars.InterpolateFaceVarying(level, uv.values, finer_uv);
    uv.values = std::move(finer_uv);
  }
  std::vector<PointVar> limit(points.size());
  primvars.Limit(points, limit);

  Shape out{.crease_rad = from.crease_rad};
  out.points.reserve(limit.size());
  out.texture.reserve(limit.size());
  for (const PointVar& p : limit) out.AddPoint(p.value.head<3>(), p.value.tail<3>());
  const Far::TopologyLevel& finest = refiner->GetLevel(levels);
  out.faces.reserve(static_cast<size_t>(finest.GetNumFaces()));
  for (int i = 0; i < finest.GetNumFaces(); ++i) {
    int parent = i;
    for (int level = levels; level > 0; --level) {
      parent = refiner->GetLevel(level).GetFaceParentFace(parent);
    }
    const Far::ConstIndexArray v = finest.GetFaceVertices(i);
    Face face{.group = from.faces[static_cast<size_t>(parent)].group};
    for (int k = 0; k < 4; ++k) {
      face.v[k] = static_cast<uint32_t>(v[k]);
      if (printed) {
        face.uv[k] = uv.values[static_cast<size_t>(finest.GetFaceFVarValues(i, 0)[k])].value;
      }
    }
    out.faces.push_back(face);
  }
  return out;
}

Path3 EightPoints(const Vec2f& low, const Vec2f& high, float z, float exponent) {
  const Vec2f middle = 0.5f * (low + high), half = 0.5f * (high - low);
  constexpr int kX[] = {1, 1, 0, -1, -1, -1, 0, 1}, kY[] = {0, 1, 1, 1, 0, -1, -1, -1};
  // A cubic B-spline passes (before + 4 at + after) / 6.
  float side = 1, diagonal = 1;
  if (exponent > 0) {
    const float wanted = std::pow(0.5f, 1 / exponent);
    const float ratio = (4 * wanted - 1) / (4 - 2 * wanted);
    side = 6 / (4 + 2 * ratio);
    diagonal = ratio * side;
  }
  Path3 ring;
  for (int i = 0; i < 8; ++i) {
    const float share = i % 2 ? diagonal : side;
    ring.emplace_back(middle.x() + share * static_cast<float>(kX[i]) * half.x(),
                      middle.y() + share * static_cast<float>(kY[i]) * half.y(), z);
  }
  return ring;
}

Cage Loft(const std::vector<CageRing>& rings) {
  Cage cage;
  Shape& s = cage.shape;
  const uint32_t n = static_cast<uint32_t>(rings.front().points.size());
  const auto at = [&](size_t ring, uint32_t k) { return static_cast<uint32_t>(ring) * n + k % n; };
  for (const CageRing& ring : rings) {
    for (const Vec3f& p : ring.points) s.AddPoint(p);
  }
  for (size_t r = 0; r < rings.size(); ++r) {
    for (uint32_t k = 0; k < n; ++k) {
      cage.creases.push_back({at(r, k), at(r, k + 1), rings[r].sharpness});
      if (r + 1 == rings.size()) continue;
      s.AddQuad(at(r, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k));
      if (k % 2 == 1) cage.creases.push_back({at(r, k), at(r + 1, k), rings[r].corners});
    }
  }
  // A fan of quads: eight points make four round a regular middle.
  for (const size_t end : {size_t{0}, rings.size() - 1}) {
    Vec3f middle = Vec3f::Zero();
    for (const Vec3f& p : rings[end].points) middle += p / static_cast<float>(n);
    const uint32_t center = s.AddPoint(middle);
    for (uint32_t k = 0; k < n; k += 2) {
      if (end == 0)
        s.AddQuad(center, at(end, k + 2), at(end, k + 1), at(end, k));
      else
        s.AddQuad(center, at(end, k), at(end, k + 1), at(end, k + 2));
    }
  }
  return cage;
}

Cage Slab(const SlabOptions& o) {
  Cage cage;
  Shape& s = cage.shape;
  const auto kept = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < o.columns && j < o.rows && (!o.keep || o.keep(i, j));
  };
  // Points that a kept cell touches, the lower one after the upper.
  std::vector<uint32_t> upper(static_cast<size_t>((o.columns + 1) * (o.rows + 1)), 0);
  const auto top = [&](int i, int j) -> uint32_t& {
    return upper[static_cast<size_t>(j * (o.columns + 1) + i)];
  };
  for (int j = 0; j <= o.rows; ++j) {
    for (int i = 0; i <= o.columns; ++i) {
      const int cells = kept(i, j) + kept(i - 1, j) + kept(i, j - 1) + kept(i - 1, j - 1);
      if (cells == 0) continue;
      const Vec3f p = o.point(i, j);
      top(i, j) = s.AddPoint(p);
      s.AddPoint(p - Vec3f(0, 0, o.thickness(i, j)));
      // Where the outline turns, its upright edge is as sharp as the rim.
      if (cells == 1) cage.creases.push_back({top(i, j), top(i, j) + 1, o.rim_sharpness});
    }
  }
  for (int j = 0; j < o.rows; ++j) {
    for (int i = 0; i < o.columns; ++i) {
      if (!kept(i, j)) continue;
      const uint32_t t[4] = {top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1)};
      s.AddQuad(t[0], t[1], t[2], t[3]);
      s.AddQuad(t[3] + 1, t[2] + 1, t[1] + 1, t[0] + 1);
      const bool open[4] = {!kept(i, j - 1), !kept(i + 1, j), !kept(i, j + 1), !kept(i - 1, j)};
      for (int k = 0; k < 4; ++k) {
        if (!open[k]) continue;
        const uint32_t a = t[k], b = t[(k + 1) % 4];
        s.AddQuad(a + 1, b + 1, b, a);
        cage.creases.push_back({a, b, o.rim_sharpness});
        cage.creases.push_back({a + 1, b + 1, o.rim_sharpness});
      }
    }
  }
  return cage;
}

uint32_t ExtrudeFace(Shape& shape, uint32_t face, const Vec3f& by, float scale) {
  const Face old = shape.faces[face];
  const Vec3f middle = Middle(shape, old);
  Face end = old;
  for (int k = 0; k < old.corners; ++k) {
    end.v[k] = shape.AddPoint(middle + scale * (shape.points[old.v[k]] - middle) + by);
  }
  if (old.corners == 3) end.v[3] = end.v[2];
  shape.faces[face] = end;
  for (int k = 0; k < old.corners; ++k) {
    const int n = (k + 1) % old.corners;
    shape.AddQuad(old.v[k], old.v[n], end.v[n], end.v[k], old.group);
  }
  return face;
}

uint32_t NearestFace(const Shape& shape, const Vec3f& to) {
  const auto nearest =
      std::min_element(shape.faces.begin(), shape.faces.end(), [&](const Face& a, const Face& b) {
        return (Middle(shape, a) - to).squaredNorm() < (Middle(shape, b) - to).squaredNorm();
      });
  return static_cast<uint32_t>(nearest - shape.faces.begin());
}

}  // namespace parallax::kernel
