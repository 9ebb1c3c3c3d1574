// Books: one, a stack, a row.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// One closed book.
struct BookParams {
  float width_m = 0.15f;       // Spine to fore-edge, along x.
  float height_m = 0.22f;      // Head to tail, along y.
  float thickness_m = 0.025f;  // Along z.
  bool hardcover = true;       // Boards that stand over the block, a rounded spine.
  uint64_t seed = 0;
};

BookParams DrawBook(Rng& rng) {
  BookParams p{.height_m = Draw(rng, 0.17, 0.3)};
  p.width_m = p.height_m * Draw(rng, 0.62, 0.78);
  p.thickness_m = Draw(rng, 0.012, 0.05);
  p.hardcover = rng.Bernoulli(0.6);
  p.seed = rng.Seed();
  return p;
}

// The cover is a C of constant thickness round the block, its spine rounded; groups: 0 inside, 1
// printed.
Shape Cover(const BookParams& p, float board, float out_w, float out_h) {
  const float t = p.thickness_m, bulge = p.hardcover ? std::min(0.3f * t, 0.006f) : 0.0f;
  // Section in (x, z), swept along y. The hinge groove lies just behind the spine.
  Path2 outside, inside;
  const float groove = p.hardcover ? 0.0012f : 0.0f, hinge = 0.008f;
  const auto layer = [&](Path2& path, float inset, float end) {
    path.emplace_back(end, inset);
    if (groove > 0) {
      path.emplace_back(2.1f * hinge, inset);
      path.emplace_back(1.3f * hinge, inset + groove);
      path.emplace_back(0.6f * hinge, inset);
    }
    const int steps = 8;
    for (int k = 0; k <= steps; ++k) {
      const float s = static_cast<float>(k) / steps;
      const float a = 2 * s - 1;
      path.emplace_back(inset - bulge * (1 - a * a), Lerp(inset, t - inset, s));
    }
    if (groove > 0) {
      path.emplace_back(0.6f * hinge, t - inset);
      path.emplace_back(1.3f * hinge, t - inset - groove);
      path.emplace_back(2.1f * hinge, t - inset);
    }
    path.emplace_back(end, t - inset);
  };
  layer(outside, 0, out_w);
  layer(inside, board, out_w);
  Path2 outline(outside.begin(), outside.end());
  outline.insert(outline.end(), inside.rbegin(), inside.rend());
  // Going down the front, round the spine and back inside runs clockwise.
  std::reverse(outline.begin(), outline.end());
  Shape cover = Extrude(outline, out_h, std::min(0.0004f, 0.3f * board));
  cover = cover.Bent([&](const Vec3f& q) { return Vec3f(q.x(), 0.5f * out_h - q.z(), q.y()); });
  TextureAlongLongest(cover);
  cover.crease_rad = 0.7f;
  return cover;
}

// A book lying on its back cover; origin at the middle of the cover.
// The part of a picture that a book's cover shows: all of it, or a crop.
struct CoverCrop {
  float share;
  Vec2f from;
};

// Prints the faces of a cover that look along `normal`; the inner sides of the boards look the same
// way and stay bare. `width`: the share of the crop's width that they show.
void PrintCover(Shape& cover, const BookParams& p, const CoverCrop& crop, const Vec3f& normal,
                const Vec3f& right, const Vec3f& up, float width) {
  PrintFaces(cover, normal, right, up, 2);
  for (Face& f : cover.faces) {
    if (f.group != 2) continue;
    Vec3f middle = Vec3f::Zero();
    for (int k = 0; k < f.corners; ++k) middle += cover.points[f.v[k]] / f.corners;
    const bool outer =
        std::abs(normal.z()) < 0.5f || (middle.z() > 0.5f * p.thickness_m) == (normal.z() > 0);
    f.group = outer ? 1 : 0;
    for (int k = 0; k < f.corners; ++k)
      f.uv[k] = outer ? Vec2f(crop.from + crop.share * Vec2f(f.uv[k].x() * width, f.uv[k].y()))
                      : Vec2f(0, 0);
  }
}

// Front, back and, unless it is cloth, the spine are printed. Books of a stack share few pictures:
// each shows its own crop.
Shape PrintedCover(const BookParams& p, float board, bool alone) {
  Shape cover = Cover(p, board, p.width_m, p.height_m).Moved(-0.5f * p.width_m, 0, 0);
  const CoverCrop crop =
      alone ? CoverCrop{1, Vec2f(0, 0)}
            : CoverCrop{0.55f, Vec2f(0.45f * static_cast<float>(p.seed % 101) / 100.0f,
                                     0.45f * static_cast<float>(p.seed % 89) / 88.0f)};
  PrintCover(cover, p, crop, Vec3f::UnitZ(), Vec3f::UnitX(), Vec3f::UnitY(), 1);
  PrintCover(cover, p, crop, -Vec3f::UnitZ(), -Vec3f::UnitX(), Vec3f::UnitY(), 1);
  const bool cloth_spine = p.hardcover && p.seed % 3 == 0;
  if (!cloth_spine)
    PrintCover(cover, p, crop, -Vec3f::UnitX(), Vec3f::UnitZ(), Vec3f::UnitY(),
               std::min(1.0f, p.thickness_m / p.width_m));
  return cover;
}

// The block of pages: its fore-edge follows the rounded spine in a hollow.
Shape PageBlock(const BookParams& p, float board, float stand) {
  const BoxOptions box{.bevel_m = 0, .pieces = {1, 1, 6}};
  const float inner = p.thickness_m - 2 * board;
  const Vec3f size(p.width_m - board - stand - 0.0005f, p.height_m - 2 * stand, inner - 0.0001f);
  const float hollow = p.hardcover ? std::min(0.22f * inner, 0.005f) : 0.0f;
  Shape block = RoundedBox(size, box).Bent([&](const Vec3f& q) {
    const float s = 2 * q.z() / size.z();
    return Vec3f(q.x() - (q.x() > 0 ? hollow : 0.6f * hollow) * (1 - s * s), q.y(), q.z());
  });
  // Leaves lie across z: the paper's grain runs along y.
  for (size_t i = 0; i < block.points.size(); ++i)
    block.texture[i] = {block.points[i].y(), block.points[i].x(), block.points[i].z()};
  block.crease_rad = 0.6f;
  return block.Moved(0.5f * (board - stand) - 0.0001f, 0, 0.5f * p.thickness_m);
}

void AddBook(AssetBuilder& b, const BookParams& p, const Eigen::Affine3f& place, int serial) {
  const std::string suffix = serial == 0 ? "" : fmt::format("_{}", serial % 3 + 1);
  const float board = p.hardcover ? 0.0026f : 0.0006f;
  const float stand = p.hardcover ? 0.0035f : 0.0f;  // How far the boards stand over the block.
  b.Add(PrintedCover(p, board, serial == 0).Placed(place),
        {Slot("cover_cloth" + suffix, {"paper", "fabric", "leather"}),
         PictureSlot("cover" + suffix)});
  b.Add(PageBlock(p, board, stand).Placed(place), Slot("pages", {"paper"}));
}

Eigen::Affine3f At(const Vec3f& origin, float turn_z) {
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.translate(origin);
  place.rotate(Eigen::AngleAxisf(turn_z, Vec3f::UnitZ()));
  return place;
}

// Lies on its back cover, spine at -x.
Asset MakeBook(const BookParams& p) {
  AssetBuilder b(p.seed);
  AddBook(b, p, Eigen::Affine3f::Identity(), 0);
  return b.Finish();
}

Asset SampleBook(Rng& rng) { return MakeBook(DrawBook(rng)); }

Asset SampleBookStack(Rng& rng) {
  const int count = rng.UniformInt(3, 8);
  std::vector<BookParams> books;
  for (int i = 0; i < count; ++i) books.push_back(DrawBook(rng));
  std::stable_sort(books.begin(), books.end(), [](const BookParams& a, const BookParams& c) {
    return a.width_m * a.height_m > c.width_m * c.height_m;
  });
  AssetBuilder b(rng.Seed());
  float z = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3f at{Draw(rng, -0.01, 0.01), Draw(rng, -0.012, 0.012), z};
    float turn = static_cast<float>(rng.Normal(0, 0.09));
    if (rng.Bernoulli(0.5)) turn += kPi;
    AddBook(b, books[i], At(at, turn), i + 1);
    z += books[i].thickness_m + 0.0002f;
  }
  const BookParams& top = books.back();
  const float half = 0.35f * top.width_m;
  b.Support({-half, -half}, {half, half}, z - 0.0002f);
  return b.Finish();
}

Asset SampleBookColumn(Rng& rng) {
  const int count = rng.UniformInt(4, 11);
  AssetBuilder b(rng.Seed());
  const bool leaning = rng.Bernoulli(0.5);
  const float height = Draw(rng, 0.19, 0.27);
  float x = 0;
  for (int i = 0; i < count; ++i) {
    BookParams p = DrawBook(rng);
    p.height_m = height * Draw(rng, 0.85, 1.1);
    p.width_m = p.height_m * Draw(rng, 0.62, 0.74);
    // Upright, spine to the front (+y): the book's -x becomes +y, its y becomes z, its z becomes x.
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    const bool leans = leaning && i + 1 == count;
    const float angle = leans ? 0.2f : 0.0f;
    place.translate(Vec3f(x + (leans ? p.height_m * std::sin(angle) + 0.0005f : 0.0f),
                          0.5f * (0.2f - p.width_m) + Draw(rng, -0.006, 0.004), 0));
    place.rotate(Eigen::AngleAxisf(-angle, Vec3f::UnitY()));
    Mat3f upright;
    upright.col(0) = -Vec3f::UnitY();
    upright.col(1) = Vec3f::UnitZ();
    upright.col(2) = -Vec3f::UnitX();
    place.rotate(upright);
    place.translate(Vec3f(0, 0.5f * p.height_m, -p.thickness_m));
    AddBook(b, p, place, i + 1);
    x += p.thickness_m + 0.0004f;
  }
  return b.Finish();
}

}  // namespace

void RegisterBooks(std::vector<AssetClass>& classes) {
  classes.push_back({"Book", "books", Placement::kOnTop, true, 0, SampleBook,
                     SizeRange({0.1f, 0.16f, 0.01f}, {0.25f, 0.31f, 0.06f})});
  classes.push_back({"BookStack", "books", Placement::kOnTop, true, 0, SampleBookStack,
                     SizeRange({0.11f, 0.15f, 0.03f}, {0.34f, 0.36f, 0.42f})});
  classes.push_back({"BookColumn", "books", Placement::kOnTop, true, 0, SampleBookColumn,
                     SizeRange({0.05f, 0.1f, 0.14f}, {0.6f, 0.26f, 0.33f})});
}

}  // namespace parallax
