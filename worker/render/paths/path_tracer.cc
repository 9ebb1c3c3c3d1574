// The path tracer's steps between surfaces: rays, hits, light met on the way, the radiance cache.
#include "worker/render/paths/path_tracer.h"

#include "worker/render/paths/path_state.h"

namespace parallax {

PathTracer::PathTracer(const RenderScene& scene, const LightTable& lights,
                       const PathOptions& options)
    : scene_(scene),
      lights_(lights),
      light_sampler_(lights, options.direct != DirectLight::kSunByLightSampling),
      options_(options),
      state_(std::make_unique<State>()) {
  state_->alike.resize(scene.geometry().materials.size());
}
PathTracer::~PathTracer() = default;

void PathTracer::Trace(std::span<const PathStarts8> starts, std::span<PathResult> results) {
  Begin(results);
  size_t next = 0;
  do {
    next = AddPaths(starts, next);
    Step();
  } while (state_->count > 0 || next < results.size());
}

void PathTracer::Trace(std::span<Path> paths) {
  State& state = *state_;
  WalkRows& walks = state.walks;
  for (; !paths.empty(); paths = paths.subspan(state.results.size())) {
    Begin(std::span(state.own_results).first(std::min(paths.size(), kTogether)));
    while (state.count < state.results.size()) AddPaths(state.count);
    for (size_t walk = 0; walk < state.count; ++walk) {
      const Path& path = paths[walk];
      walks.origin.Set(walk, path.ray.origin);
      walks.direction.Set(walk, path.ray.direction);
      walks.width_m[walk] = path.ray.width_m;
      walks.spread[walk] = path.ray.spread;
      walks.seed[walk] = path.sampler.seed();
      walks.sample[walk] = path.sampler.sample();
      walks.dimension[walk] = path.sampler.dimension();
      if (path.lights_sampled) walks.pdf[walk] = 1;
      state.trails[walk] = path.trail;
      state.learning |= path.trail != nullptr;
    }
    while (state.count > 0) Step();
    for (size_t i = 0; i < state.results.size(); ++i) paths[i].result = state.results[i];
  }
}

PathResult PathTracer::Trace(const Ray& ray, const Sampler& sampler) {
  Path path(sampler, ray);
  Trace({&path, 1});
  return path.result;
}

void PathTracer::Begin(std::span<PathResult> results) {
  State& state = *state_;
  state.results = results;
  state.count = 0;
  state.stays.fill(0);
  state.learning = false;
  std::fill(results.begin(), results.end(), PathResult());
}

size_t PathTracer::AddPaths(std::span<const PathStarts8> starts, size_t next) {
  constexpr size_t kWorthwhile = 64;  // Fewer would seldom go in packets.
  State& state = *state_;
  WalkRows& walks = state.walks;
  if (kMostWalks - state.count < kWorthwhile) return next;
  while (next < state.results.size() && state.count + kLanes <= kMostWalks) {
    const PathStarts8& start = starts[next / kLanes];
    const size_t walk = state.count;
    walks.origin.PutFrom(walk, start.rays.origin);
    walks.direction.PutFrom(walk, start.rays.direction);
    walks.width_m.PutFrom(walk, Splat(0));
    walks.spread.PutFrom(walk, start.spread);
    walks.seed.PutFrom(walk, start.seed);
    walks.sample.PutFrom(walk, start.sample);
    walks.dimension.PutFrom(walk, Bits8{} + start.dimension);
    AddPaths(next);
    walks.body.PutFrom(walk, start.body);
    walks.triangle.PutFrom(walk, start.triangle);
    next += kLanes;
  }
  return next;
}

void PathTracer::AddPaths(size_t path) {
  State& state = *state_;
  WalkRows& walks = state.walks;
  const size_t walk = state.count;
  walks.path.PutFrom(walk, Int8{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<int32_t>(path));
  for (Vec3Row* row : {&walks.throughput, &walks.tint}) {
    row->PutFrom(walk, Vec3x8::All(Splat(1)));
  }
  for (Vec3Row* row : {&walks.radiance, &walks.gathered_at}) row->PutFrom(walk, Vec3x8::Zero());
  walks.room.PutFrom(walk, ~Int8{});
  walks.transmittance.PutFrom(walk, Splat(1));
  walks.total.PutFrom(walk, Splat(0));
  walks.pdf.PutFrom(walk, Splat(kInfinity));
  for (Row<int32_t>* row :
       {&walks.cell, &walks.bounce, &walks.passages, &walks.rays, &walks.guided}) {
    row->PutFrom(walk, Int8{});
  }
  walks.body.PutFrom(walk, Int8{} + PathStarts8::kUnknown);
  state.count += std::min<size_t>(kLanes, state.results.size() - path);
  for (size_t block = walk / kLanes; block < blocks(); ++block) {
    const int before = static_cast<int>(std::max(walk, block * kLanes) - block * kLanes);
    state.stays[block] |= static_cast<uint8_t>(BitsOf(Live(block) & ~FirstLanes(before)));
  }
}

void PathTracer::Step() {
  Intersect();
  LoadHits();
  QueryCache();
  EndPathsInCache();
  CompactPaths(true);
  DrawSamples();
  EvaluateMaterials();
  ChooseLights();
  ShadeSurfaces();
  TraceShadowRays();
  CompactPaths(false);
}

size_t PathTracer::blocks() const { return (state_->count + kLanes - 1) / kLanes; }

Mask8 PathTracer::Live(size_t block) const {
  return FirstLanes(static_cast<int>(state_->count) - static_cast<int>(block * kLanes));
}

Mask8 PathTracer::Staying(size_t block) const {
  constexpr Int8 kBits = {1, 2, 4, 8, 16, 32, 64, 128};
  return (kBits & static_cast<int32_t>(state_->stays[block])) != 0;
}

void PathTracer::End(size_t block, Mask8 walks) {
  state_->stays[block] &= static_cast<uint8_t>(~BitsOf(walks));
}

void PathTracer::CompactPaths(bool all) {
  constexpr size_t kWorthwhile = 8;  // Compacts once 1 path in 8 has finished.
  State& state = *state_;
  size_t staying = 0;
  for (size_t block = 0; block < blocks(); ++block) {
    staying += static_cast<size_t>(__builtin_popcount(state.stays[block]));
  }
  const size_t leaving = state.count - staying;
  if (leaving == 0 || (!all && leaving * kWorthwhile < state.count)) return;
  for (size_t block = 0; block < blocks(); ++block) {
    uint32_t leave = BitsOf(Live(block) & ~Staying(block));
    for (; leave != 0; leave &= leave - 1) {
      const size_t walk = block * kLanes + static_cast<size_t>(__builtin_ctz(leave));
      PathResult& result = state.result(walk);
      result.radiance = state.walks.radiance[walk];
      result.rays = static_cast<uint32_t>(state.walks.rays[walk]);
    }
  }
  parallax::CompactRows(state.stays.data(), blocks(), &state.walks);
  if (all) parallax::CompactRows(state.stays.data(), blocks(), &state.hits);
  state.count = staying;
  for (size_t block = 0; block < kMostBlocks; ++block) {
    state.stays[block] = static_cast<uint8_t>(BitsOf(Live(block)));
  }
}

// ---- Light met by rays

void PathTracer::Add(size_t walk, const Vec3f& contribution) {
  if (!contribution.allFinite()) return;
  WalkRows& walks = state_->walks;
  const float limit = walks.bounce[walk] > 0 ? options_.clamp_luminance : 0.0f;
  const float luminance = Luminance(contribution);
  const Vec3f kept =
      limit > 0.0f && luminance > limit ? Vec3f(contribution * (limit / luminance)) : contribution;
  walks.radiance.Set(walk, walks.radiance[walk] + kept);
}

void PathTracer::Add(size_t block, Mask8 walks, const Vec3x8& contribution) {
  WalkRows& rows = state_->walks;
  const Vec3x8 kept = Clamped(contribution, rows.bounce.At(block) > 0, options_.clamp_luminance);
  rows.radiance.Put(block, rows.radiance.At(block) +
                               Select(walks & IsFinite(contribution), kept, Vec3x8::Zero()));
}

// Whether light met by BSDF sampling counts; with light sampling alone, only if that can't find it.
bool PathTracer::FoundByBsdf(size_t walk) const {
  return options_.direct == DirectLight::kBoth || options_.direct == DirectLight::kBsdfSampling ||
         !std::isfinite(state_->walks.pdf[walk]);
}

Mask8 PathTracer::FoundByBsdf8(size_t block) const {
  if (options_.direct == DirectLight::kBoth || options_.direct == DirectLight::kBsdfSampling) {
    return ~Mask8{};
  }
  return ~IsFinite(state_->walks.pdf.At(block));
}

float PathTracer::MisPdf(size_t walk) const {
  return options_.direct == DirectLight::kBsdfSampling ? kInfinity : state_->walks.pdf[walk];
}

LightReceiver PathTracer::ReceiverOf(size_t walk) const {
  const WalkRows& walks = state_->walks;
  return {walks.gathered_at[walk], walks.room[walk], walks.cell[walk], walks.total[walk]};
}

// Emission of a mesh light's face towards the ray that met it, weighted by MIS.
Vec3f PathTracer::MeshLight(size_t walk, float cosine) const {
  const HitRows& hits = state_->hits;
  const auto placed = static_cast<uint32_t>(hits.placed[walk]);
  const auto slot = static_cast<uint16_t>(hits.slot[walk]);
  const float pdf = state_->walks.pdf[walk];
  const Vec3f radiance = lights_.MeshRadiance(placed, slot);
  if (!std::isfinite(pdf) || options_.direct == DirectLight::kBsdfSampling) return radiance;
  const LightReceiver at = ReceiverOf(walk);
  const float distance = (hits.position[walk] - at.position).norm();
  return radiance * PowerHeuristic(pdf, light_sampler_.MeshPdf(at, placed, slot, distance, cosine));
}

// ---- Rays

// Rays of one eye with nearly the same direction go in packets. Hits that are known are not traced.
void PathTracer::Intersect() {
  constexpr float kAlike = 0.999f;  // Cosine of 2.5 degrees.
  State& state = *state_;
  WalkRows& walks = state.walks;
  for (size_t block = 0; block < blocks(); ++block) {
    const Rays8 rays{walks.origin.At(block), walks.direction.At(block)};
    const size_t first = block * kLanes;
    const Mask8 known = Staying(block) & (walks.body.At(block) != PathStarts8::kUnknown);
    const Mask8 lanes = Staying(block) & ~known;
    const Vec3x8 from = walks.origin[first], ahead = walks.direction[first];
    const Mask8 alike = (walks.bounce.At(block) == 0) & (rays.origin.x == from.x) &
                        (rays.origin.y == from.y) & (rays.origin.z == from.z) &
                        (Inner(rays.direction, ahead) > kAlike);
    const bool coherent = !Any(lanes & ~alike) && Any(lanes & ~FirstLanes(1));
    Hits8& hits = state.met[block];
    if (Any(lanes) || !Any(known)) {
      scene_.trees().Intersect(RayTrees::Tree::kFast, rays, lanes, coherent, &hits);
    }
    if (Any(known)) TakeKnownHits(block, rays, known);
    walks.rays.At(block) -= lanes;  // One more each.
    scene_.Prefetch(hits);
  }
}

void PathTracer::TakeKnownHits(size_t block, const Rays8& rays, Mask8 known) {
  WalkRows& walks = state_->walks;
  Hits8 seen;
  seen.placed = walks.body.At(block);
  seen.triangle = walks.triangle.At(block);
  seen.met = known & (seen.placed != PathStarts8::kNothing);
  scene_.HitTriangles(rays, &seen);
  state_->met[block] = Select(known, seen, state_->met[block]);
  walks.body.At(block) = Int8{} + PathStarts8::kUnknown;
}

void PathTracer::LoadHits() {
  State& state = *state_;
  const WalkRows& walks = state.walks;
  HitRows& rows = state.hits;
  for (size_t block = 0; block < blocks(); ++block) {
    const Hits8& hits = state.met[block];
    const Mask8 live = Staying(block);
    const size_t first = block * kLanes;
    const Float8 distance = hits.met ? hits.distance : Splat(kInfinity);
    const Mask8 spheres =
        live & FoundByBsdf8(block) & (walks.bounce.At(block) > 0) &
        light_sampler_.MeetSpheres(walks.origin.At(block), walks.direction.At(block), distance);
    const Mask8 escape = live & ~hits.met;
    for (size_t lane = 0; Any(spheres | escape) && lane < kLanes; ++lane) {
      const size_t walk = first + lane;
      if (spheres[lane] != 0) {
        const Vec3f seen =
            light_sampler_.SphereRadiance(ReceiverOf(walk), walks.origin[walk],
                                          walks.direction[walk], distance[lane], MisPdf(walk));
        Add(walk, walks.throughput[walk].cwiseProduct(seen));
      }
      if (escape[lane] != 0) Escape(walk);
    }
    End(block, escape);
    PassHaze(block, hits);
    const SurfaceIds8 ids = scene_.Identify(hits);
    rows.u.At(block) = hits.u;
    rows.v.At(block) = hits.v;
    rows.placed.At(block) = hits.placed;
    rows.triangle.At(block) = hits.triangle;
    rows.position.Put(block, hits.position);
    rows.footprint_m.At(block) = walks.width_m.At(block) + walks.spread.At(block) * hits.distance;
    rows.normal.Put(block, ids.geometric_normal);
    rows.doubled_area.At(block) = ids.doubled_area;
    rows.slot.At(block) = ids.slot;
    rows.material.At(block) = ids.material;
    for (size_t lane = 0; lane < kLanes; ++lane) {
      rows.lamp.At(block)[lane] = hits.met[lane]
                                      ? lights_.MeshLight(static_cast<uint32_t>(hits.placed[lane]),
                                                          static_cast<uint16_t>(ids.slot[lane]))
                                      : -1;
    }
  }
}

void PathTracer::Escape(size_t walk) {
  const bool sun = FoundByBsdf(walk);
  if (!sun && options_.direct != DirectLight::kSunByLightSampling) return;
  const WalkRows& walks = state_->walks;
  const Vec3f& direction = walks.direction[walk];
  Vec3f sky = Vec3f::Zero();
  if (sun) {
    sky = light_sampler_.EscapeRadiance(ReceiverOf(walk), direction, MisPdf(walk));
  } else if (lights_.sky().has_sky()) {
    sky = lights_.sky().Radiance(direction);
  }
  Add(walk, walks.throughput[walk].cwiseProduct(sky));
  if (walks.guided[walk]) return;
  state_->result(walk).albedo = sky.cwiseMin(1.0f).cwiseProduct(walks.tint[walk]);
}

// Records the distances of rays from the eye, and applies the haze to what they see.
void PathTracer::PassHaze(size_t block, const Hits8& hits) {
  State& state = *state_;
  WalkRows& walks = state.walks;
  const Mask8 from_eye = (walks.bounce.At(block) == 0) & ~IsFinite(walks.pdf.At(block));
  const Mask8 seen = Staying(block) & hits.met & from_eye;
  const Mask8 first = seen | (Live(block) & ~hits.met & from_eye);
  if (!Any(first)) return;
  for (uint32_t left = BitsOf(first); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    PathResult& result = state.result(block * kLanes + static_cast<size_t>(lane));
    if (result.met_pane) continue;
    result.distance = seen[lane] != 0 ? result.distance + hits.distance[lane] : 0.0f;
  }
  const Haze& haze = lights_.haze();
  if (haze.clear() || !Any(seen)) return;
  const Vec3x8 direction = walks.direction.At(block);
  const Float8 passes =
      haze.Transmittance(walks.origin.At(block), direction, hits.met ? hits.distance : Splat(0));
  walks.transmittance.At(block) = seen ? passes : walks.transmittance.At(block);
  if (options_.only_guides) return;
  const Vec3x8 throughput = walks.throughput.At(block);
  Add(block, seen, throughput * haze.Glow(lights_.sky(), direction) * (1.0f - passes));
  walks.throughput.Put(block, Select(seen, throughput * passes, throughput));
}

// ---- The radiance cache

CachePlace PathTracer::PlaceOf(size_t walk, const Vec3f& normal) const {
  const HitRows& hits = state_->hits;
  const auto slot = static_cast<uint16_t>(hits.slot[walk]);
  const CacheGroup& group = scene_.cache_group(static_cast<uint32_t>(hits.placed[walk]));
  return {hits.position[walk], normal, group.id, slot, group.Coarse(slot)};
}

// Walks that need no answer prefetch the data that shading reads.
PARALLAX_LANE_CLONES void PathTracer::QueryCache() {
  State& state = *state_;
  WalkRows& walks = state.walks;
  const HitRows& hits = state.hits;
  for (size_t block = 0; block < blocks(); ++block) {
    const size_t first = block * kLanes;
    const Mask8 may = (walks.bounce.At(block) >= options_.cache_from) & walks.guided.At(block);
    uint64_t* const keys = &state.questions[first];
    std::fill_n(keys, kLanes, uint64_t{0});
    const uint32_t asking = options_.cache ? BitsOf(may) & state.stays[block] : 0;
    if (asking != 0) {
      CacheQuestions8 questions;
      questions.group = Int8{};
      questions.coarse = Splat(1);
      Sampler::Pairs(walks.seed.At(block), walks.sample.At(block), walks.dimension.At(block),
                     &questions.jitter_u, &questions.jitter_v);
      questions.position = hits.position.At(block);
      const Vec3x8 normal = hits.normal.At(block);
      questions.normal = Select(Inner(walks.direction.At(block), normal) < 0.0f, normal, -normal);
      questions.slot = hits.slot.At(block);
      questions.widest_m = hits.footprint_m.At(block) / options_.cache_footprint;
      questions.asked = asking;
      for (uint32_t left = asking; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const auto material = static_cast<uint32_t>(hits.material.At(block)[lane]);
        if (scene_.traits(material).needs_tracing) questions.asked &= ~(1u << lane);
        const auto placed = static_cast<uint32_t>(hits.placed.At(block)[lane]);
        const CacheGroup& group = scene_.cache_group(placed);
        questions.group[lane] = static_cast<int32_t>(group.id);
        questions.coarse[lane] = group.Coarse(static_cast<uint16_t>(questions.slot[lane]));
      }
      options_.cache->Ask(questions, keys);
    }
    if (options_.cache) walks.dimension.At(block) += 1;
    for (uint32_t left = state.stays[block]; left != 0; left &= left - 1) {
      const size_t walk = first + static_cast<size_t>(__builtin_ctz(left));
      if (state.questions[walk] != 0) continue;
      scene_.PrefetchVertices(static_cast<uint32_t>(hits.placed[walk]),
                              static_cast<uint32_t>(hits.triangle[walk]));
    }
  }
}

void PathTracer::EndPathsInCache() {
  if (!options_.cache) return;
  State& state = *state_;
  const WalkRows& walks = state.walks;
  const HitRows& hits = state.hits;
  for (size_t block = 0; block < blocks(); ++block) {
    Vec3x8 cached = Vec3x8::Zero();
    Mask8 known{};
    for (uint32_t left = state.stays[block]; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const size_t walk = block * kLanes + static_cast<size_t>(lane);
      if (state.questions[walk] == 0) continue;
      const float cosine = -walks.direction[walk].dot(hits.normal[walk]);
      const Vec3f normal = cosine > 0.0f ? hits.normal[walk] : Vec3f(-hits.normal[walk]);
      Vec3f radiance;
      if (!options_.cache->Answer(state.questions[walk], PlaceOf(walk, normal), &radiance)) {
        continue;
      }
      if (cosine > 0.0f && FoundByBsdf(walk) && hits.lamp[walk] >= 0) {
        Add(walk, walks.throughput[walk].cwiseProduct(MeshLight(walk, cosine)));
      }
      cached.Set(lane, radiance);
      known[lane] = -1;
    }
    if (!Any(known)) continue;
    Add(block, known, walks.throughput.At(block) * cached);
    End(block, known);
  }
}

}  // namespace parallax
