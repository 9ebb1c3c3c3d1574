// The choice of floating objects: a class and one of its models. Private to worker/scene.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/own_content.h"

namespace parallax {

class FloatingChoice {
 public:
  // Errors: those of FloatingClasses; kInvalidArgument for a weight of an unknown class, for an own
  // class that `own` has no mesh of, and when all weights are 0.
  static absl::StatusOr<FloatingChoice> Of(const v1::SceneConfig& config, const OwnContent& own);

  struct Model {
    std::string asset_class;
    uint64_t seed = 0;
  };
  // From addresses below `stream`: own meshes take none from what is drawn without them.
  Model Draw(const Rng& stream) const;

 private:
  struct Class {
    std::string name;
    double weight = 1;
  };
  static const std::string& Pick(const std::vector<Class>& classes, Rng rng);

  std::vector<Class> catalogue_, own_;                   // At least one of them is not empty.
  std::map<std::string, std::vector<uint64_t>> meshes_;  // Models of own classes.
  double own_p_ = 0;
};

}  // namespace parallax
