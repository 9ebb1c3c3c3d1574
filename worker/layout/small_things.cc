#include "worker/layout/small_things.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "worker/geometry/ray_scene.h"

namespace parallax {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLift_m = 0.0005;
constexpr double kGap_m = 0.008;
constexpr double kSillBoard_m = 0.1;  // Sill boards reach into the room.
constexpr double kEdge_m = 0.01;
constexpr double kHeadroom_m = 0.03;
constexpr int kThingTries = 24;
constexpr int kModels = 5;

// A thing on a bearer, bearer frame.
struct OnBearer {
  Footprint footprint;
  double bottom_m = 0, top_m = 0;
};

Vec2d Turned(const Vec2d& p, double yaw) {
  return {std::cos(yaw) * p.x() - std::sin(yaw) * p.y(),
          std::sin(yaw) * p.x() + std::cos(yaw) * p.y()};
}

// One bearer with what stands on it so far.
class Bearer {
 public:
  Bearer(const Arrangement& arrangement, int item) : arrangement_(arrangement), item_(item) {
    const Item& own = arrangement.at(item);
    for (const Item& other : arrangement.items()) {
      if (other.anchor != item || other.bottom_m < 0.1) continue;
      OnBearer taken;
      taken.footprint = other.footprint;
      taken.footprint.center =
          Turned(other.footprint.center - own.position.head<2>(), -own.yaw_rad);
      taken.footprint.yaw_rad -= own.yaw_rad;
      taken.bottom_m = other.bottom_m - own.position.z();
      taken.top_m = other.top_m - own.position.z();
      taken_.push_back(taken);
    }
  }

  // How high the asset comes to lie on the bearer itself when it is let down with its middle at
  // `middle`: where the first of its points meets a cushion or a fold. Nothing where that is not
  // about level.
  std::optional<float> RestingHeight(const PooledAsset& asset, const Vec2d& middle,
                                     double yaw) const {
    const Vec2d half = 0.5 * asset.bounds.sizes().head<2>().cast<double>();
    const std::optional<float> level = LevelBelow(middle, 0.85 * half);
    if (!level) return std::nullopt;
    constexpr size_t kPoints = 3000;
    constexpr float kAbove_m = 0.05f, kSteepest_m = 0.03f;
    const std::vector<Vec3f>& points = asset.mesh->positions;
    const float top = *level + asset.bounds.sizes().z() + kAbove_m;
    const Vec2d center = asset.bounds.center().head<2>().cast<double>();
    float height = -std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < points.size(); i += 1 + points.size() / kPoints) {
      const Vec2d at = middle + Turned(points[i].head<2>().cast<double>() - center, yaw);
      const auto hit = Surface().Intersect(
          Vec3d(at.x(), at.y(), 0).cast<float>() + Vec3f(0, 0, top), -Vec3f::UnitZ());
      if (!hit) continue;
      height = std::max(height, top - hit->distance - (points[i].z() - asset.bounds.min().z()));
    }
    if (std::abs(height - *level) > kSteepest_m) return std::nullopt;
    return height;
  }

  int item() const { return item_; }
  const Item& own() const { return arrangement_.at(item_); }
  const std::vector<SupportSurface>& supports() const { return own().asset->supports; }

  // Puts the asset's middle at `middle` on the support, if it fits there; returns whether.
  bool Put(const PooledAsset& asset, const SupportSurface& support, const Vec2d& middle, double yaw,
           std::vector<SmallThing>& things) {
    const Vec2d low = asset.bounds.min().head<2>().cast<double>();
    const Vec2d high = asset.bounds.max().head<2>().cast<double>();
    OnBearer place;
    place.footprint = {middle, 0.5 * (high - low), yaw};
    place.bottom_m = static_cast<double>(support.z_m) + kLift_m;
    place.top_m = place.bottom_m + static_cast<double>(asset.bounds.sizes().z());
    if (asset.bounds.sizes().z() > support.clearance_m - 0.01f) return false;
    // On top of a cupboard the room's own ceiling is what ends the space.
    const v1::Room& room = arrangement_.problem().room;
    if (own().position.z() + place.top_m > room.height_m() - room.cornice_m() - kHeadroom_m) {
      return false;
    }
    const Vec2d extent = place.footprint.Extent();
    if (((middle - extent).array() < support.area.min().cast<double>().array()).any() ||
        ((middle + extent).array() > support.area.max().cast<double>().array()).any()) {
      return false;
    }
    for (const OnBearer& other : taken_) {
      if (place.bottom_m < other.top_m && other.bottom_m < place.top_m &&
          Overlap(place.footprint, other.footprint, kGap_m)) {
        return false;
      }
    }
    SmallThing thing;
    thing.asset = &asset;
    thing.bearer = item_;
    thing.yaw_rad = own().yaw_rad + yaw;
    const Vec2d origin = middle - Turned(0.5 * (low + high), yaw);
    const Vec2d world = own().position.head<2>() + Turned(origin, own().yaw_rad);
    thing.position = {
        world.x(), world.y(),
        own().position.z() + place.bottom_m - static_cast<double>(asset.bounds.min().z())};
    const Pose pose{thing.position,
                    Eigen::Quaterniond(Eigen::AngleAxisd(thing.yaw_rad, Vec3d::UnitZ())), 1.0};
    if (Overlap(*own().asset->Tree(), own().WorldFromObject(), *asset.Tree(), pose.Affine())) {
      return false;
    }
    // Things nearby may reach over the bearer: chairs, lamps, pictures.
    const Footprint world_print = {own().position.head<2>() + Turned(middle, own().yaw_rad),
                                   place.footprint.half, thing.yaw_rad};
    if (!arrangement_.ClearOfOpenings(world_print, own().position.z() + place.bottom_m,
                                      own().position.z() + place.top_m, kSillBoard_m)) {
      return false;
    }
    for (const Item& other : arrangement_.items()) {
      if (&other == &own() || arrangement_.IsRug(other)) continue;
      if (own().position.z() + place.bottom_m >= other.top_m ||
          other.bottom_m >= own().position.z() + place.top_m ||
          !Overlap(world_print, other.footprint, 0)) {
        continue;
      }
      // A seat pushed under its table has its box in the way, but not itself.
      if (other.anchor != item_ ||
          Overlap(*other.asset->Tree(), other.WorldFromObject(), *asset.Tree(), pose.Affine())) {
        return false;
      }
    }
    taken_.push_back(place);
    things.push_back(thing);
    return true;
  }

 private:
  // The highest point below a rectangle around `middle`, where that is about level.
  std::optional<float> LevelBelow(const Vec2d& middle, const Vec2d& half) const {
    constexpr int kProbes = 6;
    const float above = own().asset->bounds.max().z() + 0.1f;
    float low = above, high = 0;
    for (int i = 0; i < kProbes * kProbes; ++i) {
      const double x = middle.x() + half.x() * (2.0 * (i % kProbes) / (kProbes - 1) - 1);
      const double y = middle.y() + half.y() * (2.0 * (i / kProbes) / (kProbes - 1) - 1);
      const auto hit =
          Surface().Intersect(Vec3d(x, y, 0).cast<float>() + Vec3f(0, 0, above), -Vec3f::UnitZ());
      if (!hit) return std::nullopt;
      low = std::min(low, above - hit->distance);
      high = std::max(high, above - hit->distance);
    }
    constexpr float kUneven_m = 0.07f;
    if (high - low > kUneven_m) return std::nullopt;
    return high;
  }

  RayScene& Surface() const {
    if (surface_ == nullptr) {
      surface_ = std::make_unique<RayScene>();
      surface_->Add(own().asset->Tree(), Eigen::Affine3f::Identity());
      surface_->Commit();
    }
    return *surface_;
  }

  const Arrangement& arrangement_;
  int item_;
  std::vector<OnBearer> taken_;
  mutable std::unique_ptr<RayScene> surface_;  // The asset's surface, made at first use.
};

class Filler {
 public:
  Filler(const Arrangement& arrangement, const v1::AssetConfig& assets, const ModelRack& rack,
         SceneSeed seed)
      : arrangement_(arrangement), assets_(assets), rack_(rack), root_(seed, "layout/small") {}

  // Each step does one task: one row of the table for one bearer.
  absl::StatusOr<SmallFill> Run(const std::vector<SmallRow>& rows, int steps) {
    for (int i = 0; i < arrangement_.size(); ++i) {
      if (arrangement_.RowOf(arrangement_.at(i)) != nullptr) bearers_.emplace_back(arrangement_, i);
    }
    std::vector<Task> tasks = Tasks(rows);
    SmallFill fill;
    for (const Task& task : tasks) fill.wanted += task.count;
    // Tables are laid before loose things take their places.
    std::stable_sort(tasks.begin(), tasks.end(), [](const Task& a, const Task& b) {
      return Order(a.row->spread) < Order(b.row->spread);
    });
    for (Task& task : tasks) {
      if (steps-- <= 0) break;
      for (; task.count > 0; --task.count) RETURN_IF_ERROR(AddOne(task, fill.things));
    }
    return fill;
  }

 private:
  struct Task {
    const SmallRow* row;
    size_t bearer;
    int count;
    std::vector<std::string> classes;
    Rng rng;
    int done = 0;
  };

  std::vector<Task> Tasks(const std::vector<SmallRow>& rows) const {
    std::vector<Task> tasks;
    for (size_t b = 0; b < bearers_.size(); ++b) {
      const std::string& group = arrangement_.RowOf(bearers_[b].own())->group;
      for (size_t r = 0; r < rows.size(); ++r) {
        if (rows[r].bearer != group) continue;
        Task task{&rows[r], b, 0, {}, root_.Child(fmt::format("{}/{}", group, r), b)};
        for (const std::string& name : rows[r].classes) {
          if (ClassAllowed(assets_, name)) task.classes.push_back(name);
        }
        if (task.classes.empty()) continue;
        task.count = DrawCount(rows[r], bearers_[b], task.rng);
        tasks.push_back(std::move(task));
      }
    }
    return tasks;
  }

  static int Order(Spread spread) {
    return spread == Spread::kCentre ? 0 : spread == Spread::kSettings ? 1 : 2;
  }

  // Counts of loose things are stated for half a square metre. Tables are laid for everybody, or
  // just for a few.
  static int DrawCount(const SmallRow& row, const Bearer& bearer, Rng& rng) {
    const int drawn = rng.UniformInt(row.least, row.most);
    if (row.spread == Spread::kCentre || row.spread == Spread::kSoft) return drawn;
    if (bearer.supports().empty()) return 0;
    if (row.spread == Spread::kSettings) return rng.Bernoulli(0.7) ? row.most : drawn;
    return static_cast<int>(std::lround(drawn * std::clamp(SupportArea(bearer) / 0.5, 0.5, 2.0)));
  }

  static double SupportArea(const Bearer& bearer) {
    double area = 0;
    for (const SupportSurface& s : bearer.supports()) {
      if (!s.area.isEmpty()) area += static_cast<double>(s.area.sizes().prod());
    }
    return area;
  }

  absl::Status AddOne(Task& task, std::vector<SmallThing>& things) {
    switch (task.row->spread) {
      case Spread::kSettings:
        return AddSetting(task, things);
      case Spread::kLine:
        return AddInLine(task, things);
      case Spread::kSoft:
        return AddSoft(task, things);
      default:
        return AddLoose(task, things);
    }
  }

  absl::StatusOr<const PooledAsset*> DrawThing(Task& task) {
    const std::string& name = task.rng.Pick(task.classes);
    return rack_.Get(name, static_cast<uint64_t>(task.rng.UniformInt(0, kModels - 1)));
  }

  const SupportSurface* PickSupport(Task& task) {
    const auto& supports = bearers_[task.bearer].supports();
    double total = 0;
    for (const SupportSurface& s : supports) total += Weight(s);
    double u = task.rng.Uniform() * total;
    for (const SupportSurface& s : supports) {
      if (u < Weight(s)) return &s;
      u -= Weight(s);
    }
    return nullptr;
  }
  static double Weight(const SupportSurface& s) {
    return s.area.isEmpty() ? 0 : std::sqrt(static_cast<double>(s.area.sizes().prod()));
  }

  absl::Status AddLoose(Task& task, std::vector<SmallThing>& things) {
    Bearer& bearer = bearers_[task.bearer];
    for (int k = 0; k < kThingTries; ++k) {
      if (k % 6 == 0) {
        ASSIGN_OR_RETURN(current_, DrawThing(task));
      }
      const bool centre = task.row->spread == Spread::kCentre;
      const SupportSurface* support = centre ? MainSupport(*bearer.own().asset) : PickSupport(task);
      if (support == nullptr) return absl::OkStatus();
      // Round things turn freely; on shelves the front looks out.
      const bool free = support->clearance_m > 0.6f;
      const double yaw = free ? task.rng.Uniform(-kPi, kPi) : task.rng.Uniform(-0.3, 0.3);
      const Vec2d size = support->area.sizes().cast<double>();
      const Vec2d middle = support->area.center().cast<double>();
      const double reach = centre ? 0.12 : 1.0;
      const Vec2d at = middle + Vec2d(task.rng.Uniform(-0.5, 0.5) * size.x() * reach,
                                      task.rng.Uniform(-0.5, 0.5) * size.y() * reach);
      if (bearer.Put(*current_, *support, at, yaw, things)) break;
    }
    return absl::OkStatus();
  }

  // Where a seat or a mattress is about level, before its back.
  absl::Status AddSoft(Task& task, std::vector<SmallThing>& things) {
    Bearer& bearer = bearers_[task.bearer];
    const Box3f& box = bearer.own().asset->bounds;
    const Vec2d low = box.min().head<2>().cast<double>(), high = box.max().head<2>().cast<double>();
    for (int k = 0; k < kThingTries; ++k) {
      if (k % 6 == 0) {
        ASSIGN_OR_RETURN(current_, DrawThing(task));
      }
      const Vec2d half = 0.5 * current_->bounds.sizes().head<2>().cast<double>();
      const Vec2d at(task.rng.Uniform(low.x() + 0.8 * half.x(), high.x() - 0.8 * half.x()),
                     task.rng.Uniform(0.5 * (low.y() + high.y()) - 0.25 * (high.y() - low.y()),
                                      high.y() - half.y()));
      const double yaw = task.rng.Uniform(-0.35, 0.35);
      const auto height = bearer.RestingHeight(*current_, at, yaw);
      if (!height) continue;
      SupportSurface seat;
      seat.area = {Vec2f::Constant(-10), Vec2f::Constant(10)};
      bool put = false;
      for (int lift = 0; lift < 4 && !put; ++lift) {
        // Edges may cross between the points that were let down.
        seat.z_m = *height + 0.003f * static_cast<float>(lift);
        put = bearer.Put(*current_, seat, at, yaw, things);
      }
      if (put) break;
    }
    return absl::OkStatus();
  }

  // Side by side from one end of a shelf, backs near the back.
  absl::Status AddInLine(Task& task, std::vector<SmallThing>& things) {
    Bearer& bearer = bearers_[task.bearer];
    for (int k = 0; k < 6; ++k) {
      ASSIGN_OR_RETURN(const PooledAsset* asset, DrawThing(task));
      const SupportSurface* support = PickSupport(task);
      if (support == nullptr) return absl::OkStatus();
      const Vec2d half = 0.5 * asset->bounds.sizes().head<2>().cast<double>();
      const Vec2d low = support->area.min().cast<double>(),
                  high = support->area.max().cast<double>();
      const double y = std::min(low.y() + half.y() + task.rng.Uniform(0.01, 0.05),
                                high.y() - half.y() - kEdge_m);
      const bool from_left = task.rng.Bernoulli(0.6);
      const double first = task.rng.Uniform(0.0, 0.06);
      const double span = (high.x() - low.x()) - 2 * half.x() - 2 * kEdge_m;
      for (double x = first; x < span; x += 0.03) {
        const double at =
            from_left ? low.x() + kEdge_m + half.x() + x : high.x() - kEdge_m - half.x() - x;
        if (bearer.Put(*asset, *support, {at, y}, 0, things)) return absl::OkStatus();
      }
    }
    return absl::OkStatus();
  }

  // A plate before the next seat, with what lies and stands around it.
  absl::Status AddSetting(Task& task, std::vector<SmallThing>& things) {
    Bearer& bearer = bearers_[task.bearer];
    std::vector<const Item*> seats;
    for (const Item& item : arrangement_.items()) {
      const RoomRow* row = arrangement_.RowOf(item);
      if (row != nullptr && row->stand == Stand::kAround && item.anchor == bearer.item()) {
        seats.push_back(&item);
      }
    }
    if (task.done >= static_cast<int>(seats.size())) return absl::OkStatus();
    const SupportSurface* support = MainSupport(*bearer.own().asset);
    if (support == nullptr) return absl::OkStatus();
    const Item& seat = *seats[static_cast<size_t>(task.done++)];
    const Item& own = bearer.own();
    // The table's edge before the seat, table frame; `in` leads to the middle, `right` is the
    // diner's right hand.
    const Vec2d at = Turned(seat.footprint.center - own.position.head<2>(), -own.yaw_rad);
    const double facing = seat.side * kPi / 2;
    const Vec2d in = Turned(Vec2d::UnitY(), facing), right = Turned(Vec2d::UnitX(), facing);
    const Vec2d half = 0.5 * support->area.sizes().cast<double>();
    const Vec2d middle = support->area.center().cast<double>();
    const double edge = seat.side % 2 == 0 ? half.y() : half.x();
    const Vec2d base = middle + right * (at - middle).dot(right) - in * edge;

    ASSIGN_OR_RETURN(const PooledAsset* plate, SetPiece("Plate"));
    if (plate == nullptr) return absl::OkStatus();
    const double radius = 0.5 * static_cast<double>(plate->bounds.sizes().y());
    const double side_reach = 0.5 * static_cast<double>(plate->bounds.sizes().x());
    const double deep = radius + 0.03;
    if (!bearer.Put(*plate, *support, base + in * deep, facing, things)) return absl::OkStatus();
    struct Piece {
      const char* name;
      double across, along;
    };
    const Piece pieces[] = {{"Fork", -side_reach - 0.035, 0},
                            {"Knife", side_reach + 0.03, 0},
                            {"Spoon", side_reach + 0.065, 0},
                            {"Wineglass", side_reach + 0.05, radius + 0.06}};
    for (const Piece& piece : pieces) {
      ASSIGN_OR_RETURN(const PooledAsset* asset, SetPiece(piece.name));
      if (asset == nullptr) continue;
      // Long pieces point away from the diner.
      const bool lies_along_x = asset->bounds.sizes().x() > asset->bounds.sizes().y() * 1.5f;
      bearer.Put(*asset, *support, base + in * (deep + piece.along) + right * piece.across,
                 facing + (lies_along_x ? kPi / 2 : 0) + task.rng.Uniform(-0.05, 0.05), things);
    }
    return absl::OkStatus();
  }

  // One model for the whole table; nullptr when there is no such class.
  absl::StatusOr<const PooledAsset*> SetPiece(const std::string& name) {
    if (!ClassAllowed(assets_, name)) return nullptr;
    return rack_.Get(name,
                     static_cast<uint64_t>(root_.Child("set/" + name).UniformInt(0, kModels - 1)));
  }

  const Arrangement& arrangement_;
  const v1::AssetConfig& assets_;
  const ModelRack& rack_;
  Rng root_;
  std::vector<Bearer> bearers_;
  const PooledAsset* current_ = nullptr;
};

}  // namespace

absl::StatusOr<SmallFill> FillSupports(const Arrangement& arrangement,
                                       const std::vector<SmallRow>& rows,
                                       const v1::AssetConfig& assets, const ModelRack& rack,
                                       int steps, SceneSeed seed) {
  return Filler(arrangement, assets, rack, seed).Run(rows, steps);
}

}  // namespace parallax
