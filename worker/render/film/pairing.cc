#include "worker/render/film/pairing.h"

namespace parallax {

std::string LeftEyeKey(const v1::Rig& rig, const Pairing& pairing) {
  v1::Rig left = rig;
  left.set_index(pairing.leader.index());
  left.clear_shares_left();
  left.clear_baseline_m();
  return left.SerializeAsString();
}

const RigPlace* RigBook::PlaceOf(const v1::Rig& rig) const {
  for (size_t i = 0; i < rigs_.size(); ++i) {
    if (rigs_[i].index() == rig.index()) return &places_[i];
  }
  return nullptr;
}

Pairing RigBook::PairingOf(const v1::Rig& rig) const {
  const RigPlace* place = PlaceOf(rig);
  if (!place) return {rig, {1.0}, 0};
  Pairing pairing;
  const auto first = static_cast<size_t>(place->left);
  for (size_t i = first; i < rigs_.size() && places_[i].left == place->left; ++i) {
    if (rigs_[i].index() == rig.index()) pairing.partner = i - first;
    pairing.baselines.push_back(rigs_[i].baseline_m() / rigs_[first].baseline_m());
  }
  pairing.leader = pairing.shared() ? rigs_[first] : rig;
  return pairing;
}

const v1::Rig* RigBook::Neighbour(const v1::Rig& rig, bool forward) const {
  const RigPlace* place = PlaceOf(rig);
  const int other = !place ? -1 : forward ? place->next : place->previous;
  return other < 0 ? nullptr : &rigs_[static_cast<size_t>(other)];
}

}  // namespace parallax
