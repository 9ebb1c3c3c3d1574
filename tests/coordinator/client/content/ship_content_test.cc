#include "coordinator/client/content/ship_content.h"

#include <gtest/gtest.h>

#include "common/store/content.h"

namespace parallax::client {
namespace {

TEST(NameOwnCopies, ListsOfAStoreBecomeThePathsTheyStandFor) {
  v1::StudySpec study;
  v1::SceneConfig& config = *study.add_variants()->mutable_config();
  config.mutable_lighting()->set_hdri_dir(
      ContentReferenceText({std::string(64, 'a'), "srv/hdris"}));
  config.mutable_assets()->add_include("srv/chairs");
  config.mutable_assets()->add_include(ContentReferenceText({std::string(64, 'b'), "srv/tables"}));
  NameOwnCopies(study);
  EXPECT_EQ(config.lighting().hdri_dir(), "srv/hdris");
  EXPECT_EQ(config.assets().include(0), "srv/chairs");
  EXPECT_EQ(config.assets().include(1), "srv/tables");
  EXPECT_FALSE(config.has_materials());
}

}  // namespace
}  // namespace parallax::client
