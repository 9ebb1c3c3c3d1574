// Paths that begin at what a visibility buffer shows.
#pragma once

#include "worker/render/film/film.h"
#include "worker/render/paths/path_tracer.h"
#include "worker/render/raster/visibility_buffer.h"

namespace parallax {

// Sets lane k of the starts to the triangle that is seen at a sample of the pixel, and (u, v) to
// the sample's place in the pixel.
inline void StartAtSeen(const VisibilityBuffer& visible, const PixelAt& at, size_t sample, size_t k,
                        PathStarts8* starts, Float8* u, Float8* v) {
  (*u)[k] = visible.points().X(at.x, at.y)[sample];
  (*v)[k] = visible.points().Y(at.x, at.y)[sample];
  const uint32_t id = visible.Ids(at.x, at.y)[sample];
  if (id == VisibilityBuffer::kNothing) {
    starts->body[k] = PathStarts8::kNothing;
    return;
  }
  const SeenTriangle seen = visible.TriangleOf(id);
  starts->body[k] = static_cast<int32_t>(seen.body);
  starts->triangle[k] = static_cast<int32_t>(seen.triangle);
}

}  // namespace parallax
