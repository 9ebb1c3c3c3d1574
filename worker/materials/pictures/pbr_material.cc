#include "worker/materials/pictures/pbr_material.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/surface.h"
#include "worker/materials/pictures/mip_picture.h"

namespace parallax {
namespace {

std::optional<MipPicture> MipOf(const std::optional<ImageRgb8>& image, MipPicture::Values values) {
  if (!image || image->empty()) return std::nullopt;
  return MipPicture(*image, values, MipPicture::Edge::kRepeat);
}

// A place in the pictures, and how wide a pixel of the image is there.
struct PicturePlace {
  float u = 0, v = 0, width = 0;
};

class PbrMaterial final : public PointMaterial {
 public:
  PbrMaterial(const PbrPictures& pictures, PbrMapping mapping)
      : mapping_(mapping),
        color_(pictures.color),
        albedo_(MipOf(pictures.albedo, MipPicture::Values::kColor)),
        normal_(MipOf(pictures.normal, MipPicture::Values::kNumber)),
        roughness_(pictures.roughness),
        metallic_(pictures.metallic) {}

  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    const PicturePlace place = PlaceOf(point);
    SurfaceSample out;
    out.base_color = color_;
    if (albedo_) out.base_color = color_.cwiseProduct(albedo_->At(place.u, place.v, place.width));
    out.base_color = Albedo(out.base_color);
    out.roughness = std::clamp(roughness_.At(place), 0.05f, 1.0f);
    out.metallic = std::clamp(metallic_.At(place), 0.0f, 1.0f);
    return out;
  }

  // A micrometre where the normal leans: it only tells that there is relief. Relief has its slopes.
  float HeightOfPoint(const SurfacePoint& point) const override {
    return normal_ ? 1e-6f * SlopesAt(PlaceOf(point)).x() : 0.0f;
  }

  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const override {
    if (!normal_) return Splat(0);
    const auto plane = OnPlane(ReliefPoint8(points, tangents));
    Dual8 relief = Splat(0);
    for (int lane = 0; lane < points.count; ++lane) {
      const Vec2f slopes = SlopesAt(PlaceOf(points.Get(lane)));
      // How far along u and along v a metre leads, in metres.
      Vec2f along_u(plane.u.dx[lane], plane.u.dy[lane]);
      Vec2f along_v(plane.v.dx[lane], plane.v.dy[lane]);
      if (mapping_ == PbrMapping::kUv) {
        along_u = Vec2f(tangents.u[0][lane], tangents.u[1][lane]);
        along_v = Vec2f(tangents.v[0][lane], tangents.v[1][lane]);
        along_u /= std::max(along_u.norm(), 1e-9f);
        along_v /= std::max(along_v.norm(), 1e-9f);
      }
      const Vec2f slope = slopes.x() * along_u + slopes.y() * along_v;
      relief.dx[lane] = slope.x();
      relief.dy[lane] = slope.y();
    }
    return relief;
  }

 private:
  struct Number {
    explicit Number(const PbrNumber& number)
        : factor(number.factor),
          picture(MipOf(number.picture, MipPicture::Values::kNumber)),
          channel(number.channel) {}
    float At(const PicturePlace& place) const {
      return picture ? factor * picture->At(place.u, place.v, place.width)[channel] : factor;
    }
    float factor;
    std::optional<MipPicture> picture;
    int channel;
  };

  PicturePlace PlaceOf(const SurfacePoint& point) const {
    if (mapping_ == PbrMapping::kPlane) {
      const PlanePoint at = OnPlane(point);
      return {at.u / kPbrTile_m, at.v / kPbrTile_m, point.footprint_m / kPbrTile_m};
    }
    // Pictures are taken to be half a metre wide where the renderer doesn't know.
    return {point.uv.x(), point.uv.y(),
            point.footprint_uv > 0 ? point.footprint_uv : 2 * point.footprint_m};
  }

  // Height a metre along u and along v, as the normal there leans.
  Vec2f SlopesAt(const PicturePlace& place) const {
    constexpr float kFlattest = 0.15f;  // A steeper normal is noise of the picture.
    const Vec3f n = 2.0f * normal_->At(place.u, place.v, place.width) - Vec3f::Ones();
    return -n.head<2>() / std::max(n.z(), kFlattest);
  }

  const PbrMapping mapping_;
  const Vec3f color_;
  const std::optional<MipPicture> albedo_, normal_;
  const Number roughness_, metallic_;
};

}  // namespace

std::unique_ptr<const Material> MakePbrMaterial(const PbrPictures& pictures, PbrMapping mapping) {
  return std::make_unique<PbrMaterial>(pictures, mapping);
}

}  // namespace parallax
