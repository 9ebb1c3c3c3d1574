#include "worker/scene/types/nature/ground/prototypes.h"

#include <list>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "common/base/rng.h"
#include "worker/assets/detail.h"
#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/trees.h"
#include "worker/scene/types/nature/ground/snow_caps.h"

namespace parallax {
namespace {

constexpr size_t kMostTriangles = 4'000'000;  // The process keeps at most this many in all.

Season SeasonOf(std::string_view name) {
  if (name == "spring") return Season::kSpring;
  if (name == "autumn") return Season::kAutumn;
  return name == "winter" ? Season::kWinter : Season::kSummer;
}

template <typename Table>
absl::StatusOr<size_t> RowOf(const Table& table, std::string_view name) {
  std::string known;
  for (size_t i = 0; i < table.size(); ++i) {
    if (table[i].name == name) return i;
    known += (known.empty() ? "" : ", ") + std::string(table[i].name);
  }
  return NotFound("no species \"{}\"; there are {}", name, known);
}

template <typename Params, typename Table>
absl::StatusOr<Params> TreeOf(const Table& table, std::string_view species, uint64_t seed,
                              const std::string& season) {
  Params params;
  ASSIGN_OR_RETURN(params.species, RowOf(table, species));
  Rng rng(SceneSeed{seed}, "tree");
  const auto& row = table[params.species];
  params.height_m =
      row.height_low_m + (row.height_high_m - row.height_low_m) * static_cast<float>(rng.Uniform());
  params.season = SeasonOf(season);
  params.seed = rng.Seed();
  return params;
}

absl::StatusOr<Mesh> Make(const v1::Prototype& prototype, uint64_t seed, PlantDetail detail) {
  const std::string& name = prototype.asset_class();
  const size_t slash = name.find('/');
  if (slash == std::string::npos) {
    ASSIGN_OR_RETURN(Asset asset, MakeAsset(name, seed, EdgeOfDetail(detail)));
    return std::move(asset.mesh);
  }
  const std::string_view species = std::string_view(name).substr(slash + 1);
  const kernel::DetailScope scope(EdgeOfDetail(detail));
  if (name.starts_with("BroadleafTree/")) {
    ASSIGN_OR_RETURN(const BroadleafParams params,
                     TreeOf<BroadleafParams>(BroadleafTable(), species, seed, prototype.season()));
    return MakeBroadleafTree(params).mesh;
  }
  if (name.starts_with("Conifer/")) {
    ASSIGN_OR_RETURN(const ConiferParams params,
                     TreeOf<ConiferParams>(ConiferTable(), species, seed, prototype.season()));
    return MakeConifer(params).mesh;
  }
  return NotFound("no asset class with species \"{}\"", name);
}

// Class, season, snow, seed.
using Key = std::tuple<std::string, std::string, double, uint64_t, PlantDetail>;

// Remembers what was made last.
class Store {
 public:
  std::shared_ptr<const Mesh> Find(const Key& key) {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto found = meshes_.find(key);
    return found == meshes_.end() ? nullptr : found->second;
  }
  std::shared_ptr<const Mesh> Keep(const Key& key, Mesh mesh) {
    auto kept = std::make_shared<const Mesh>(std::move(mesh));
    std::lock_guard<std::mutex> lock(mutex_);
    if (!meshes_.emplace(key, kept).second) return meshes_[key];
    order_.push_back(key);
    triangles_ += kept->triangles.size();
    while (triangles_ > kMostTriangles && order_.size() > 1) {
      triangles_ -= meshes_[order_.front()]->triangles.size();
      meshes_.erase(order_.front());
      order_.pop_front();
    }
    return kept;
  }

 private:
  std::mutex mutex_;
  std::map<Key, std::shared_ptr<const Mesh>> meshes_;
  std::list<Key> order_;
  size_t triangles_ = 0;
};

Store& TheStore() {
  static Store& store = *new Store;
  return store;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Mesh>> PrototypeMesh(const v1::Prototype& prototype,
                                                          uint32_t shape, PlantDetail detail) {
  const uint64_t seed = Rng(SceneSeed{prototype.seed()}, "prototype").Child("shape", shape).Seed();
  const Key key(prototype.asset_class(), prototype.season(), prototype.snow_m(), seed, detail);
  if (auto found = TheStore().Find(key)) return found;
  ASSIGN_OR_RETURN(Mesh mesh, Make(prototype, seed, detail));
  AddSnowCaps(static_cast<float>(prototype.snow_m()), mesh);
  return TheStore().Keep(key, std::move(mesh));
}

std::string CatalogueClass(const v1::Prototype& prototype) {
  return prototype.asset_class().substr(0, prototype.asset_class().find('/'));
}

}  // namespace parallax
