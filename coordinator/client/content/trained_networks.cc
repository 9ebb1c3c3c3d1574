#include "coordinator/client/content/trained_networks.h"

#include <algorithm>
#include <filesystem>

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

// training/<set>/builtin/seed-<i>/final.*
void AddNetworks(const std::string& out_dir, const std::string& set,
                 std::vector<std::string>& networks) {
  std::error_code error;
  for (const auto& seed :
       fs::directory_iterator(out_dir + "/training/" + set + "/builtin", error)) {
    for (const auto& file : fs::directory_iterator(seed.path(), error)) {
      if (file.path().stem() == "final") networks.push_back(file.path());
    }
  }
}

bool Draws(const v1::Mixture& mixture, const std::string& variant) {
  return std::any_of(mixture.parts().begin(), mixture.parts().end(),
                     [&](const v1::Mixture::Part& part) { return part.variant() == variant; });
}

}  // namespace

absl::StatusOr<std::vector<std::string>> NetworksFor(const std::string& out_dir,
                                                     const v1::StudySpec& study,
                                                     const std::string& variant) {
  std::vector<std::string> networks;
  AddNetworks(out_dir, variant, networks);
  if (networks.empty()) {
    for (const v1::Mixture& mixture : study.train().mixtures()) {
      if (mixture.mismatched() || !Draws(mixture, variant)) continue;
      AddNetworks(out_dir, mixture.name(), networks);
    }
  }
  std::sort(networks.begin(), networks.end());
  if (!networks.empty()) return networks;
  return NotFound(
      "variant '{}': {}/training has no network of the built-in trainer that was trained on it; "
      "name one with --checkpoint FILE",
      variant, out_dir);
}

}  // namespace parallax::client
