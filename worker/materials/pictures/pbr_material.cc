#include "worker/materials/pictures/pbr_material.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/surface.h"
#include "worker/materials/pictures/mip_picture.h"

namespace parallax {
namespace {

// A place in the pictures, and how wide a pixel of the image is there.
struct PicturePlace {
  float u = 0, v = 0, width = 0;
};

// A picture with its mip levels where it lies on the surface.
class LaidPicture {
 public:
  static std::optional<LaidPicture> Of(const std::optional<PbrPicture>& picture,
                                       MipPicture::Values values) {
    if (!picture || picture->image.empty()) return std::nullopt;
    return LaidPicture(*picture, values);
  }

  Vec3f At(const PicturePlace& place) const {
    if (!is_moved_) return mips_.At(place.u, place.v, place.width);
    const Vec2f at = turn_ * Vec2f(place.u, place.v) + offset_;
    return mips_.At(at.x(), at.y(), place.width * scale_);
  }

  const Eigen::Matrix2f& turn() const { return turn_; }

 private:
  LaidPicture(const PbrPicture& picture, MipPicture::Values values)
      : mips_(picture.image, values, picture.edges),
        turn_(picture.turn),
        offset_(picture.offset),
        is_moved_(!turn_.isIdentity(0) || !offset_.isZero(0)),
        scale_(std::sqrt(std::abs(turn_.determinant()))) {}

  MipPicture mips_;
  Eigen::Matrix2f turn_;
  Vec2f offset_;
  bool is_moved_;
  float scale_;
};

class PbrMaterial final : public PointMaterial {
 public:
  PbrMaterial(const PbrPictures& pictures, PbrMapping mapping)
      : mapping_(mapping),
        color_(pictures.color),
        albedo_(LaidPicture::Of(pictures.albedo, MipPicture::Values::kColor)),
        normal_(LaidPicture::Of(pictures.normal, MipPicture::Values::kNumber)),
        normal_scale_(pictures.normal_scale),
        roughness_(pictures.roughness),
        metallic_(pictures.metallic) {}

  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    const PicturePlace place = PlaceOf(point);
    SurfaceSample out;
    out.base_color = color_;
    if (albedo_) out.base_color = color_.cwiseProduct(albedo_->At(place));
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
      // The directions along which the picture's u and v grow.
      Vec2f along_u(plane.u.dx[lane], plane.u.dy[lane]);
      Vec2f along_v(plane.v.dx[lane], plane.v.dy[lane]);
      if (mapping_ == PbrMapping::kUv) {
        const Vec2f u(tangents.u[0][lane], tangents.u[1][lane]);
        const Vec2f v(tangents.v[0][lane], tangents.v[1][lane]);
        const Eigen::Matrix2f& turn = normal_->turn();
        along_u = turn(0, 0) * u + turn(0, 1) * v;
        along_v = turn(1, 0) * u + turn(1, 1) * v;
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
          picture(LaidPicture::Of(number.picture, MipPicture::Values::kNumber)),
          channel(number.channel) {}
    float At(const PicturePlace& place) const {
      return picture ? factor * picture->At(place)[channel] : factor;
    }
    float factor;
    std::optional<LaidPicture> picture;
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
    const Vec3f n = 2.0f * normal_->At(place) - Vec3f::Ones();
    return -normal_scale_ * n.head<2>() / std::max(n.z(), kFlattest);
  }

  const PbrMapping mapping_;
  const Vec3f color_;
  const std::optional<LaidPicture> albedo_, normal_;
  const float normal_scale_;
  const Number roughness_, metallic_;
};

}  // namespace

std::unique_ptr<const Material> MakePbrMaterial(const PbrPictures& pictures, PbrMapping mapping) {
  return std::make_unique<PbrMaterial>(pictures, mapping);
}

}  // namespace parallax
