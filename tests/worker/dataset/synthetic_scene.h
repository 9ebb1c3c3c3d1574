// A small analytic scene for tests: a textured room's back wall, a floor and balls, seen by a rig,
// with ground truth in closed form. Enough for everything that writes, checks or draws frames; no
// renderer is needed.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// Objects: 1 floor, 2 back wall (parts of the room), 3.. balls. Materials: 1 Tile,
// 2 Brick, 3.. Plastic.
v1::Scene MakeSyntheticScene(int rigs = 2, int width_px = 160, int height_px = 90);

// Both eyes of a rig of that scene. Deterministic.
StereoFrame RenderSyntheticFrame(const v1::Scene& scene, const v1::Rig& rig);

// Makes the rigs of the scene frames of one way, 0.1 s apart, and two of its balls move.
void MakeSequence(v1::Scene& scene);

// Flow of both eyes to the frames before and after, occluded as rays say.
void GiveFlow(const v1::Scene& scene, const v1::Rig& rig, StereoFrame& frame);

// Gives both views the light that their pictures were made of: developed, it gives them again.
void GiveLight(StereoFrame& frame);

// Makes glass of the balls: half a metre behind each is the second layer, of the back wall.
void GiveLayers(const v1::Rig& rig, StereoFrame& frame);

}  // namespace parallax
