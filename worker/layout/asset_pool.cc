#include "worker/layout/asset_pool.h"

namespace parallax {

const std::shared_ptr<const TriangleTree>& PooledAsset::Tree() const {
  if (tree_ == nullptr) tree_ = std::make_shared<TriangleTree>(*mesh);
  return tree_;
}

absl::StatusOr<const PooledAsset*> AssetPool::Get(const std::string& class_name, uint64_t seed) {
  auto& entry = assets_[{class_name, seed}];
  if (entry == nullptr) {
    ASSIGN_OR_RETURN(Asset asset, MakeAsset(class_name, seed));
    entry = std::make_unique<PooledAsset>();
    entry->class_name = class_name;
    entry->seed = seed;
    entry->asset_class = FindAssetClass(class_name);
    entry->bounds = asset.mesh.Bounds();
    entry->supports = std::move(asset.supports);
    entry->mesh = std::make_shared<Mesh>(std::move(asset.mesh));
  }
  return entry.get();
}

}  // namespace parallax
