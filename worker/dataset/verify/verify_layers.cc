#include "worker/dataset/verify/verify_layers.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace parallax {
namespace {

constexpr int kMost = 4;
constexpr uint8_t kMore = 128;
constexpr double kLayerTolerance = 1e-6;  // As of the first layer.

// The maps of one layer.
struct Layer {
  ImageF depth, disparity;
  ImageU16 objects, materials;
};

class LayerChecker {
 public:
  LayerChecker(const CheckedFrame& frame, const CheckedEye& eye) : frame_(frame), eye_(eye) {}

  void Run() {
    frame_.ReadMap("layers", eye_, &count_);
    if (count_.empty()) return;
    CheckCount();
    Layer before{eye_.depth, eye_.disparity, eye_.objects, eye_.materials};
    if (before.depth.empty() || before.materials.empty()) return;
    for (int n = 2; n <= kMost; ++n) {
      const bool any = std::any_of(count_.values().begin(), count_.values().end(),
                                   [&](uint8_t value) { return (value & ~kMore) >= n; });
      Layer layer;
      if (!Read(n, any, &layer)) return;
      if (!any) continue;
      Check(n, before, layer);
      before = std::move(layer);
    }
  }

 private:
  void Find(const std::string& stem, const std::string& message) const {
    frame_.Find("layers", MapFile(stem, eye_.name), message);
  }

  // Reads the layer's maps, which must be there exactly where a pixel has one.
  bool Read(int n, bool wanted, Layer* layer) const {
    const auto read = [&](const char* map, auto* image) {
      const std::string stem = map + std::to_string(n);
      frame_.ReadMap(stem, eye_, image);
      if (image->empty() != wanted) return true;
      Find(stem, wanted ? "missing, though pixels have that layer" : "no pixel has that layer");
      return false;
    };
    return read("depth", &layer->depth) && read("disparity", &layer->disparity) &&
           read("objects", &layer->objects) && read("materials", &layer->materials);
  }

  int CountAt(size_t i) const { return count_.values()[i] & ~kMore; }

  template <typename Bad, typename Describe>
  void Pixels(const std::string& stem, const Bad& bad, const Describe& describe) const {
    frame_.Pixels("layers", MapFile(stem, eye_.name), bad, describe);
  }

  void CheckCount() const {
    const auto bad = [&](size_t i) {
      const uint8_t value = count_.values()[i];
      if (CountAt(i) > kMost || ((value & kMore) != 0 && CountAt(i) < kMost)) return true;
      return !eye_.depth.empty() && (value == 0) != (eye_.depth.values()[i] == 0);
    };
    Pixels("layers", bad, [&](size_t i) {
      return fmt::format("{} at a first depth of {:.9g}", count_.values()[i],
                         eye_.depth.empty() ? 0.0 : double{eye_.depth.values()[i]});
    });
  }

  void Check(int n, const Layer& before, const Layer& layer) const {
    const std::string number = std::to_string(n);
    const auto has = [&](size_t i) { return CountAt(i) >= n; };
    const auto depth = [&](size_t i) { return double{layer.depth.values()[i]}; };
    Pixels(
        "depth" + number,
        [&](size_t i) {
          if (!has(i)) return depth(i) != 0;
          return !(std::isfinite(depth(i)) && depth(i) > double{before.depth.values()[i]});
        },
        [&](size_t i) {
          return fmt::format("{:.9g} of {} layers, behind {:.9g}", depth(i), CountAt(i),
                             double{before.depth.values()[i]});
        });
    const auto expected = [&](size_t i) {
      return has(i) ? frame_.k.fx * frame_.baseline_m / depth(i) : 0.0;
    };
    const auto seen = [&](size_t i) { return double{layer.disparity.values()[i]}; };
    Pixels(
        "disparity" + number,
        [&](size_t i) {
          return !(std::abs(seen(i) - expected(i)) <= kLayerTolerance * expected(i));
        },
        [&](size_t i) {
          return fmt::format("{:.9g}, fx * baseline / depth is {:.9g}", seen(i), expected(i));
        });
    CheckIndices("objects", number, layer.objects, has);
    CheckIndices("materials", number, layer.materials, has);
    const std::vector<bool> clear = Known("materials", true);
    Pixels(
        "materials" + number,
        [&](size_t i) { return has(i) && !clear[before.materials.values()[i]]; },
        [&](size_t i) {
          return fmt::format("behind material {}, which is opaque", before.materials.values()[i]);
        });
  }

  // The indices of a table; of those that are see-through only, if `clear`.
  std::vector<bool> Known(const char* table, bool clear) const {
    std::vector<bool> known(1 << 16);
    if (!frame_.json.contains(table)) return known;
    for (const auto& [key, entry] : frame_.json[table].items()) {
      const auto index = static_cast<size_t>(std::strtoul(key.c_str(), nullptr, 10));
      if (index < known.size()) known[index] = !clear || entry.contains("clear");
    }
    return known;
  }

  template <typename Has>
  void CheckIndices(const char* table, const std::string& number, const ImageU16& indices,
                    const Has& has) const {
    std::vector<bool> known = Known(table, false);
    const bool may_be_none = std::string(table) == "materials";  // Objects without a material.
    known[0] = may_be_none;
    Pixels(
        table + number,
        [&](size_t i) {
          const uint16_t index = indices.values()[i];
          return has(i) ? !known[index] : index != 0;
        },
        [&](size_t i) {
          return fmt::format("index {} of {} layers", indices.values()[i], CountAt(i));
        });
  }

  const CheckedFrame& frame_;
  const CheckedEye& eye_;
  ImageU8 count_;
};

}  // namespace

void CheckLayers(const CheckedFrame& frame) {
  for (const CheckedEye& eye : frame.eyes) LayerChecker(frame, eye).Run();
}

}  // namespace parallax
