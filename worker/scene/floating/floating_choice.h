// The choice of floating objects: a class and one of its models. Private to worker/scene.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/own_content.h"

namespace parallax {

// The longest side of a floating object.
struct FloatingSize {
  double drawn_m = 0;  // At FloatingConfig.size_at_m.
  double added_m = 0;

  // Draws from random addresses below `stream`.
  static FloatingSize Draw(const v1::FloatingConfig& config, const Rng& stream);
  // Returns the size at a distance from the camera, metres.
  double At(const v1::FloatingConfig& config, double distance_m) const {
    return Grown(config.size_at_m() > 0 ? distance_m / config.size_at_m() : 1);
  }
  double Grown(double factor) const { return std::max(kLeast_m, drawn_m * factor + added_m); }

  static constexpr double kLeast_m = 0.02;
};

// Draws classes and models by the config's weights.
class FloatingChoice {
 public:
  // Makes the choice of a config. Errors: those of FloatingClasses; kInvalidArgument for a weight
  // of an unknown class, for an own class without a mesh in `own`, and if all weights are 0.
  static absl::StatusOr<FloatingChoice> Of(const v1::SceneConfig& config, const OwnContent& own);

  // A class and the seed of one of its models.
  struct Model {
    std::string asset_class;
    uint64_t seed = 0;
  };
  // Draws a model, from random addresses below `stream`. Own meshes have separate addresses, so
  // that adding them changes no other draw.
  Model Draw(const Rng& stream) const;

 private:
  struct Class {
    std::string name;
    double weight = 1;
  };
  static const std::string& Pick(const std::vector<Class>& classes, Rng rng);

  std::vector<Class> catalogue_, own_;                   // At least one is not empty.
  std::map<std::string, std::vector<uint64_t>> meshes_;  // Models of own classes.
  double own_p_ = 0;
};

}  // namespace parallax
