// A test scene's frame, rendered by a renderer of its own.
#pragma once

#include <gtest/gtest.h>

#include "tests/worker/render/test_scenes.h"
#include "worker/render/renderer.h"

namespace parallax::test {

inline StereoFrame RenderFrame(const TestScene& test, const v1::RenderConfig& config,
                               const v1::Rig& rig) {
  auto renderer = Renderer::Create(test.recipe, test.geometry, config);
  EXPECT_TRUE(renderer.ok()) << renderer.status();
  auto frame = (*renderer)->RenderRig(rig, {}, {});
  EXPECT_TRUE(frame.ok()) << frame.status();
  return *std::move(frame);
}

}  // namespace parallax::test
