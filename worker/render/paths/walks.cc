#include "worker/render/paths/walks.h"

namespace parallax {

const Int8* CompactionOrders() {
  static const auto orders = [] {
    std::array<Int8, 256> all{};
    for (uint32_t stays = 0; stays < all.size(); ++stays) {
      int to = 0;
      for (int32_t lane = 0; lane < kLanes; ++lane) {
        if (stays >> lane & 1) all[stays][to++] = lane;
      }
    }
    return all;
  }();
  return orders.data();
}

}  // namespace parallax
