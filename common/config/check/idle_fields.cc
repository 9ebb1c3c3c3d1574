#include "common/config/check/idle_fields.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/config/check/field_rules.h"
#include "common/config/config.h"

namespace parallax::config_internal {
namespace {

bool IsZero(const v1::Distribution& distribution) { return SupportOf(distribution).high <= 0; }

class IdleFields {
 public:
  IdleFields(YamlReader& reader, const YAML::Node& node, const std::string& path)
      : reader_(reader), node_(node), path_(path) {}

  // Tells of the `fields` of `message`, which lies at `place` and has `defaults`.
  void Tell(const std::string& place, const std::vector<std::string>& fields,
            const google::protobuf::Message& message, const google::protobuf::Message& defaults,
            const std::string& what) {
    const YAML::Node group = Find(place);
    if (!group.IsMap()) return;
    for (const std::string& field : fields) {
      if (!group[field]) continue;
      if (!Differs(message, defaults, *message.GetDescriptor()->FindFieldByName(field))) continue;
      reader_.Error(group[field], Dotted(Dotted(path_, place), field), what);
    }
  }

 private:
  // Returns the node at a path of fields; one that is no map if none exists.
  YAML::Node Find(const std::string& place) const {
    YAML::Node node = node_;
    for (size_t begin = 0; node.IsMap() && begin < place.size();) {
      const size_t end = std::min(place.find('.', begin), place.size());
      node.reset(YAML::Node(node[place.substr(begin, end - begin)]));
      begin = end + 1;
    }
    return node;
  }

  YamlReader& reader_;
  const YAML::Node& node_;
  const std::string& path_;
};

}  // namespace

void CheckIdleFields(YamlReader& reader, const YAML::Node& node, const std::string& path,
                     const v1::SceneConfig& merged) {
  const v1::SceneConfig defaults = DefaultSceneConfig();
  IdleFields idle(reader, node, path);
  const v1::SensorConfig& sensor = merged.sensor();
  const bool sensor_is_on = !sensor.preset().empty() && sensor.preset() != "off";
  if (sensor_is_on && IsZero(sensor.exposure_ms())) {
    idle.Tell("sensor", {"shake_m_s", "shake_deg_s"}, sensor, defaults.sensor(),
              "given, but sensor.exposure_ms is 0, so that nothing moves while the shutter is "
              "open, allowed with exposure_ms above 0");
  }
  if (sensor_is_on && IsZero(sensor.white_e())) {
    idle.Tell("sensor", {"read_noise_e"}, sensor, defaults.sensor(),
              "given, but sensor.white_e is 0, which means no noise, allowed with white_e above 0");
  }
  const v1::RigConfig& rigs = merged.rigs();
  if (rigs.path().paths() == 0) {
    idle.Tell("rigs.path", {"fps", "speed_mps", "max_turn_dps"}, rigs.path(),
              defaults.rigs().path(),
              "given, but rigs.path.paths is 0, which means single views, allowed with paths of 1 "
              "or more");
  }
  if (!rigs.baselines_m().empty()) {
    idle.Tell("rigs", {"baseline_m"}, rigs, defaults.rigs(),
              "given beside rigs.baselines_m, allowed is one of them");
  }
}

}  // namespace parallax::config_internal
