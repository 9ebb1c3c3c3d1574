// The path tracer's steps at the surfaces that the rays met.
#include "worker/render/paths/irradiance_volume.h"
#include "worker/render/paths/path_state.h"

namespace parallax {
namespace {

constexpr int kMaxPassages = 32;  // Holes and thin panes that a path may pass.
constexpr int kGuideBounces = 1;  // Mirrors that the denoiser's guides follow.
constexpr float kRareWayWeight = 0.02f;
constexpr int kRouletteFrom = 2;  // First bounce that may end by chance.

// The albedo guide of the denoiser for the first surface.
Vec3x8 GuideAlbedo(const SurfaceSample8& s) {
  const Float8 opaque = 1.0f - s.transmission * (1.0f - s.metallic);
  const Float8 rest = 1.0f - opaque;
  const auto part = [&](Float8 color) { return Clamp(color * opaque + rest, 0.0f, 1.0f); };
  // A sheet's colour includes all light that it scatters, to either side.
  const Vec3x8 color = s.base_color + s.transmitted_color;
  return {part(color.x), part(color.y), part(color.z)};
}

// Whether most of the reflected light is scattered about equally in all directions.
Mask8 ScattersWidely(const SurfaceSample8& s) {
  constexpr float kWideRoughness = 0.4f;
  constexpr float kSharpShare = 0.35f;
  const Float8 plastic = (1.0f - s.metallic) * (1.0f - s.transmission);
  const Float8 base = Luminance(s.base_color);
  Float8 wide = plastic * (base + Luminance(s.transmitted_color));
  const Float8 sharp_coat = s.clearcoat_roughness < kWideRoughness ? Splat(1) : Splat(0);
  Float8 sharp = 0.06f * s.clearcoat * sharp_coat + (1.0f - s.metallic) * s.transmission;
  const Float8 gloss = s.metallic * base + plastic * 0.12f * s.specular;
  const Mask8 sharp_gloss = s.roughness < kWideRoughness;
  sharp += sharp_gloss ? gloss : Splat(0);
  wide += sharp_gloss ? Splat(0) : gloss;
  return sharp <= kSharpShare * (wide + sharp);
}

template <typename Function>
void ForEach(Mask8 lanes, Function function) {
  for (uint32_t left = BitsOf(lanes); left != 0; left &= left - 1) function(__builtin_ctz(left));
}

}  // namespace

// ---- Materials at the surfaces

void MaterialSamples::Put(const std::array<uint32_t, kLanes>& walks, int count,
                          const MaterialSample8& look) {
  const SurfaceSample8& s = look.surface;
  const Vec3x8& n = look.shading_normal;
  Float8 parts[kParts][kLanes] = {{s.base_color.x, s.base_color.y, s.base_color.z, s.metallic,
                                   s.roughness, s.specular, s.transmission, s.ior},
                                  {s.clearcoat, s.clearcoat_roughness, s.sheen, s.subsurface,
                                   s.opacity, s.emission.x, s.emission.y, s.emission.z},
                                  {(Float8)s.thin_walled, n.x, n.y, n.z, s.transmitted_color.x,
                                   s.transmitted_color.y, s.transmitted_color.z}};
  for (size_t part = 0; part < kParts; ++part) {
    Transpose(parts[part]);
    for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
      of_[walks[k] * kParts + part] = parts[part][k];
    }
  }
}

void MaterialSamples::Get(size_t first, SurfaceSample8* surface, Vec3x8* shading_normal) const {
  Float8 parts[kParts][kLanes];
  for (size_t part = 0; part < kParts; ++part) {
    for (size_t k = 0; k < kLanes; ++k) parts[part][k] = of_[(first + k) * kParts + part];
    Transpose(parts[part]);
  }
  const auto &a = parts[0], &b = parts[1], &c = parts[2];
  surface->base_color = {a[0], a[1], a[2]};
  surface->metallic = a[3];
  surface->roughness = a[4];
  surface->specular = a[5];
  surface->transmission = a[6];
  surface->ior = a[7];
  surface->clearcoat = b[0];
  surface->clearcoat_roughness = b[1];
  surface->sheen = b[2];
  surface->subsurface = b[3];
  surface->opacity = b[4];
  surface->emission = {b[5], b[6], b[7]};
  surface->thin_walled = (Mask8)c[0];
  *shading_normal = {c[1], c[2], c[3]};
  surface->transmitted_color = {c[4], c[5], c[6]};
}

PARALLAX_LANE_CLONES void PathTracer::DrawSamples() {
  State& state = *state_;
  WalkRows& walks = state.walks;
  for (size_t block = 0; block < blocks(); ++block) {
    const auto put = [&](size_t pair, Float8 u, Float8 v) {
      state.u[pair].At(block) = u;
      state.v[pair].At(block) = v;
    };
    const auto pairs = static_cast<uint32_t>(state.u.size());
    Sampler::Draw(walks.seed.At(block), walks.sample.At(block), walks.dimension.At(block), pairs,
                  put);
    walks.dimension.At(block) += pairs;
  }
}

Float8 PathTracer::State::Random(size_t block, Chance chance) const {
  return Sampler::Random(walks.seed.At(block), walks.sample.At(block), walks.dimension.At(block),
                         static_cast<uint32_t>(chance));
}

// Evaluates eight walks of one material at a time.
void PathTracer::EvaluateMaterials() {
  State& state = *state_;
  for (size_t walk = 0; walk < state.count; ++walk) {
    const auto material = static_cast<uint32_t>(state.hits.material[walk]);
    Alike& alike = state.alike[material];
    if (alike.count == 0) state.materials.push_back(material);
    alike.walks[static_cast<size_t>(alike.count++)] = static_cast<uint32_t>(walk);
    if (alike.count == kLanes) EvaluateMaterial(material);
  }
  for (const uint32_t material : state.materials) {
    if (state.alike[material].count > 0) EvaluateMaterial(material);
  }
  state.materials.clear();
}

void PathTracer::EvaluateMaterial(uint32_t material) {
  State& state = *state_;
  Alike& alike = state.alike[material];
  const HitRows& hits = state.hits;
  HitBatch8 batch;
  batch.count = std::exchange(alike.count, 0);
  for (int lane = 0; lane < kLanes; ++lane) {
    // Lanes beyond the last hold a copy of it.
    const int from = std::min(lane, batch.count - 1);
    const size_t walk = alike.walks[static_cast<size_t>(from)];
    batch.placed[lane] = hits.placed[walk];
    batch.triangle[lane] = hits.triangle[walk];
    batch.u[lane] = hits.u[walk];
    batch.v[lane] = hits.v[walk];
    batch.geometric_normal.Set(lane, hits.normal[walk]);
    batch.doubled_area[lane] = hits.doubled_area[walk];
    batch.footprint_m[lane] = hits.footprint_m[walk];
  }
  state.materials_seen.Put(alike.walks, batch.count, scene_.EvaluateMaterial(batch, material));
}

// ---- Choice of lights

void PathTracer::ChooseLights() {
  if (options_.only_guides) return;
  State& state = *state_;
  LightQueries8 queries;
  for (size_t block = 0; block < blocks(); ++block) {
    const Vec3x8 normal = state.hits.normal.At(block);
    const Mask8 outside = Inner(-state.walks.direction.At(block), normal) > 0.0f;
    queries.position = state.hits.position.At(block);
    queries.normal = Select(outside, normal, -normal);
    queries.choice = state.v[0].At(block);
    queries.count = static_cast<int>(std::min<size_t>(kLanes, state.count - block * kLanes));
    light_sampler_.Choose(queries, &state.scratch, &state.receivers[block], &state.lights[block]);
  }
  for (size_t block = 0; block < blocks(); ++block) {
    light_sampler_.Aim(state.u[1].At(block), &state.lights[block]);
  }
}

void PathTracer::TraceShadowRays() {
  State& state = *state_;
  WalkRows& walks = state.walks;
  for (size_t block = 0; block < blocks(); ++block) {
    const ShadowRays8& shadow = state.shadows[block];
    const Shadow8& rays = shadow.rays;
    if (!Any(rays.lit)) continue;
    Vec3x8 light = rays.contribution;
    ForEach(rays.lit, [&](int lane) {
      const size_t walk = block * kLanes + static_cast<size_t>(lane);
      Vec3f arrived = light.Get(lane);
      if (rays.distance[lane] > 0.0f) {
        arrived = arrived.cwiseProduct(scene_.Transmittance(
            rays.origin.Get(lane), rays.direction.Get(lane), rays.distance[lane]));
        light.Set(lane, arrived);
      }
      if (state.learning && state.trials[walk]) {
        state.trials[walk]->gain *= Luminance(arrived) / Luminance(rays.contribution.Get(lane));
      }
    });
    walks.rays.At(block) -= rays.lit;  // One more of each that is lit.
    const Vec3x8 kept = Clamped(light, shadow.clamped, options_.clamp_luminance);
    walks.radiance.Put(block, walks.radiance.At(block) + Select(rays.lit, kept, Vec3x8::Zero()));
  }
}

// ---- Scattering

// Eight walks at the surfaces that they have reached.
struct PathTracer::PathVertex8 {
  const size_t block, first;  // Index of the block; of its first walk.
  Mask8 here;                 // Lanes that have not ended or passed on.
  Mask8 wide, transmits;      // By the material at the surface.
  Mask8 last;                 // The last vertex gathers no light.
  Mask8 lit{};                // Has a light sample;
  Mask8 gathers{};            // may also find its light by BSDF sampling.
  SurfaceInteraction8 at;

  PathVertex8(size_t which, Mask8 walks) : block(which), first(which * kLanes), here(walks) {}
  size_t Walk(int lane) const { return first + static_cast<size_t>(lane); }
  void Drop(Mask8 walks, PathTracer* tracer);  // Ends these walks.
};

void PathTracer::AddEmission(size_t block, const SurfaceInteraction8& at) {
  const HitRows& hits = state_->hits;
  const WalkRows& walks = state_->walks;
  const Mask8 lamp = hits.lamp.At(block) >= 0;
  const Mask8 shines = Live(block) & (lamp | (MaxCoeff(at.surface.emission) > 0.0f));
  ForEach(shines, [&](int lane) {
    const size_t walk = block * kLanes + static_cast<size_t>(lane);
    Vec3f emission = at.surface.emission.Get(lane);
    if (lamp[lane] != 0) {
      if (at.outside[lane] == 0 || !FoundByBsdf(walk)) return;
      emission = MeshLight(walk, (-walks.direction[walk]).dot(hits.normal[walk]));
    }
    Add(walk, walks.throughput[walk].cwiseProduct(emission));
  });
}

void PathTracer::ShadeSurfaces() {
  for (size_t block = 0; block < blocks(); ++block) ShadeBlock(block);
}

PARALLAX_LANE_CLONES void PathTracer::ShadeBlock(size_t block) {
  PathVertex8 vertex(block, Live(block));
  state_->shadows[block].rays.lit = Mask8{};
  LoadInteraction(&vertex);
  AddEmission(block, vertex.at);
  PassHoles(&vertex);
  if (state_->learning) RecordTrail(vertex);

  // The last vertex gathers no light, and only panes continue.
  const WalkRows& walks = state_->walks;
  const Mask8 done = vertex.last & ~(vertex.at.surface.thin_walled & vertex.transmits);
  vertex.Drop(vertex.here & done & walks.guided.At(block), this);
  if (!Any(vertex.here)) return;

  SampleLights(&vertex);
  const Scatter8 scatter(vertex.at);
  RecordGuides(vertex, scatter);
  vertex.Drop(vertex.here & (done | (options_.only_guides ? walks.guided.At(block) : Mask8{})),
              this);
  if (!Any(vertex.here)) return;

  vertex.gathers = vertex.here & vertex.lit & ~scatter.bsdf().mirror_like();
  if (Any(vertex.gathers)) MakeShadowRays(vertex, scatter);
  if (options_.volume) EndInVolume(&vertex, scatter);
  if (!Any(vertex.here)) return;
  const BsdfSample8 next = scatter.SampleBsdf();
  TintGuides(vertex, scatter, next);
  vertex.Drop(vertex.here & (~next.goes | (vertex.last & ~next.straight)), this);
  ContinuePaths(vertex, next);
}

// Adds the light of the volume to walks at rough surfaces, and ends them. Sharp gloss goes on as a
// ray, which the next rough surface ends.
void PathTracer::EndInVolume(PathVertex8* vertex, const Scatter8& scatter) {
  constexpr float kSharp = 0.3f;      // Roughness.
  constexpr float kMuchGloss = 0.1f;  // Share of reflected light.
  const State& state = *state_;
  const size_t block = vertex->block;
  const SurfaceSample8& surface = vertex->at.surface;
  const AmbientParts8 parts = scatter.bsdf().Ambient();
  const Mask8 sharp = ((surface.roughness < kSharp) & (Luminance(parts.gloss) > kMuchGloss)) |
                      vertex->transmits | scatter.bsdf().mirror_like();
  const Mask8 asking = vertex->here & ~sharp;
  if (!Any(asking)) return;
  // Leaves need no jitter: neighbours share no surface on which the cells' edges could be seen.
  Mask8 sheets{};
  ForEach(asking, [&](int lane) {
    const CacheGroup& group =
        scene_.cache_group(static_cast<uint32_t>(state.hits.placed.At(block)[lane]));
    if (group.Sheet(static_cast<uint16_t>(state.hits.slot.At(block)[lane]))) sheets[lane] = -1;
  });
  const Vec3x8 jitter{state.u[0].At(block) - 0.5f, state.u[2].At(block) - 0.5f,
                      state.v[2].At(block) - 0.5f};
  const IncomingLight8 light =
      options_.volume->At(vertex->at.position, Select(sheets, Vec3x8::Zero(), jitter), asking);
  const Vec3x8& normal = scatter.normal();
  const Vec3x8 mirrored = normal * (2.0f * Dot(normal, vertex->at.out)) - vertex->at.out;
  Vec3x8 arrived =
      light.Irradiance(normal) * kInvPi * parts.above + light.RadianceAbout(mirrored) * parts.gloss;
  if (Any(scatter.bsdf().translucent())) {
    arrived = arrived + light.Irradiance(-normal) * kInvPi * parts.below;
  }
  Add(block, light.known, vertex->at.throughput * arrived);
  vertex->Drop(light.known, this);
}

void PathTracer::PathVertex8::Drop(Mask8 walks, PathTracer* tracer) {
  tracer->End(block, walks);
  here &= ~walks;
}

void PathTracer::LoadInteraction(PathVertex8* vertex) const {
  const State& state = *state_;
  const size_t block = vertex->block;
  SurfaceInteraction8& at = vertex->at;
  state.materials_seen.Get(vertex->first, &at.surface, &at.shading);
  at.position = state.hits.position.At(block);
  at.out = -state.walks.direction.At(block);
  const Vec3x8 geometric = state.hits.normal.At(block);
  at.outside = Inner(at.out, geometric) > 0.0f;
  at.normal = Select(at.outside, geometric, -geometric);
  at.shading = Select(at.outside, at.shading, -at.shading);
  at.throughput = state.walks.throughput.At(block);
  at.spot_share = Splat(0);
  at.choice = state.u[0].At(block);
  at.u = state.u[2].At(block);
  at.v = state.v[2].At(block);
  vertex->wide = ScattersWidely(at.surface);
  vertex->transmits = at.surface.transmission > 0.0f;
  vertex->last = state.walks.bounce.At(block) >= options_.max_bounces;
}

void PathTracer::PassHoles(PathVertex8* vertex) {
  const Float8 opacity = vertex->at.surface.opacity;
  Mask8 holes = vertex->here & (opacity < 1.0f);
  if (!Any(holes)) return;
  holes &= state_->Random(vertex->block, State::Chance::kHole) >= opacity;
  Pass(vertex->block, holes, vertex->at.normal);
  vertex->here &= ~holes;
}

// Continues straight through a hole or a thin pane.
void PathTracer::Pass(size_t block, Mask8 passing, const Vec3x8& normal) {
  WalkRows& walks = state_->walks;
  const HitRows& hits = state_->hits;
  walks.passages.At(block) -= passing;
  End(block, passing & (walks.passages.At(block) > kMaxPassages));
  walks.origin.Put(block, Select(passing, OffsetPoint(hits.position.At(block), -normal),
                                 walks.origin.At(block)));
  walks.width_m.At(block) = passing ? hits.footprint_m.At(block) : walks.width_m.At(block);
}

// Records the vertices for the cache's filler.
void PathTracer::RecordTrail(const PathVertex8& vertex) {
  State& state = *state_;
  for (size_t lane = 0; lane < kLanes; ++lane) state.trials[vertex.first + lane] = nullptr;
  ForEach(vertex.here, [&](int lane) {
    const size_t walk = vertex.Walk(lane);
    PathTrail* trail = state.trails[state.path(walk)];
    if (!trail || trail->size >= static_cast<int>(trail->vertices.size())) return;
    if (scene_.traits(static_cast<uint32_t>(state.hits.material[walk])).needs_tracing) return;
    PathVertex& entry = trail->vertices[static_cast<size_t>(trail->size++)];
    entry = {PlaceOf(walk, vertex.at.normal.Get(lane)),
             vertex.wide[lane] != 0,
             state.walks.throughput[walk],
             state.walks.radiance[walk],
             {}};
    state.trials[walk] = &entry.trial;
  });
}

// Samples the light that each walk has chosen, and finds the bright spots as seen from there.
void PathTracer::SampleLights(PathVertex8* vertex) const {
  const bool lights =
      options_.direct != DirectLight::kBsdfSampling && !lights_.empty() && !options_.only_guides;
  vertex->lit = lights ? vertex->here & ~vertex->last : Mask8{};
  if (!Any(vertex->lit)) return;
  const State& state = *state_;
  const size_t block = vertex->block;
  const LightReceivers8& receivers = state.receivers[block];
  light_sampler_.Sample(receivers, state.lights[block], state.u[1].At(block), state.v[1].At(block),
                        &vertex->at.light);
  ForEach(vertex->lit & vertex->wide & (receivers.room >= 0), [&](int lane) {
    SpotView& spots = vertex->at.spots[lane];
    spots.Look(lights_.EnclosureAt(receivers.room[lane])->spots,
               state.hits.position[vertex->Walk(lane)], vertex->at.normal.Get(lane));
    vertex->at.spot_share[lane] = spots.share();
  });
}

// Bumps tear what solid glass refracts into noise: there the glass itself guides.
void PathTracer::RecordGuides(const PathVertex8& vertex, const Scatter8& scatter) {
  WalkRows& walks = state_->walks;
  const Mask8 solid_glass = vertex.transmits & ~vertex.at.surface.thin_walled;
  const Mask8 shows_another = scatter.bsdf().mirror_like() & ~solid_glass & ~vertex.last &
                              (walks.bounce.At(vertex.block) < kGuideBounces);
  const Mask8 guides = vertex.here & ~walks.guided.At(vertex.block) & ~shows_another;
  if (!Any(guides)) return;
  // Haze fades the guides into the sky's as it fades the picture: else the denoiser draws the noise
  // of an edge that is hardly to be seen.
  const Float8 clear = walks.transmittance.At(vertex.block);
  const Vec3x8 albedo = GuideAlbedo(vertex.at.surface) * walks.tint.At(vertex.block);
  const Vec3x8 guide = albedo * clear + Vec3x8::All(1.0f - clear),
               normal = scatter.normal() * clear;
  ForEach(guides, [&](int lane) {
    PathResult& result = state_->result(vertex.Walk(lane));
    result.albedo = guide.Get(lane);
    result.normal = normal.Get(lane);
  });
  walks.guided.At(vertex.block) |= guides;
}

// Next-event estimation: makes the shadow rays, which are traced later.
void PathTracer::MakeShadowRays(const PathVertex8& vertex, const Scatter8& scatter) {
  State& state = *state_;
  ShadowRays8& shadow = state.shadows[vertex.block];
  scatter.Light(options_.direct == DirectLight::kBoth, &shadow.rays);
  shadow.rays.lit &= vertex.gathers;
  shadow.clamped = state.walks.bounce.At(vertex.block) > 0;
  if (!state.learning) return;
  const LightSamples8& light = vertex.at.light;
  const Float8 cosine = Inner(vertex.at.normal, light.direction);
  const Float8 facing = scatter.bsdf().translucent() ? Abs(cosine) : Max(cosine, 0.0f);
  const Float8 irradiance = Luminance(light.radiance) * facing;
  ForEach(vertex.gathers & (shadow.rays.lit | ~(irradiance > 0.0f)), [&](int lane) {
    LightTrial* trial = state.trials[vertex.Walk(lane)];
    if (!trial) return;
    *trial = TrialOf(lights_, state.receivers[vertex.block].Get(lane),
                     state.lights[vertex.block].light[lane], light.pdf[lane], irradiance[lane]);
  });
}

// The tint that a mirror or pane gives to the guides of the surface behind it. A pixel's few
// samples are split at random between what a pane shows and what it mirrors; of the two, the one
// that most samples take guides.
void PathTracer::TintGuides(const PathVertex8& vertex, const Scatter8& scatter,
                            const BsdfSample8& next) {
  WalkRows& walks = state_->walks;
  const Mask8 tinted = vertex.here & next.goes & ~walks.guided.At(vertex.block);
  if (!Any(tinted)) return;
  const Vec3x8 tint = walks.tint.At(vertex.block), &weight = next.weight;
  const Vec3x8 part(Min(weight.x, 1.0f), Min(weight.y, 1.0f), Min(weight.z, 1.0f));
  walks.tint.Put(vertex.block, Select(tinted, tint * part, tint));
  const Mask8 mostly_passes = scatter.bsdf().PassChance() >= 0.5f;
  ForEach(tinted & vertex.transmits & (next.passes ^ mostly_passes),
          [&](int lane) { state_->result(vertex.Walk(lane)).guide_weight *= kRareWayWeight; });
}

void PathTracer::ContinuePaths(const PathVertex8& vertex, const BsdfSample8& next) {
  WalkRows& walks = state_->walks;
  const Vec3x8 throughput = walks.throughput.At(vertex.block);
  walks.throughput.Put(vertex.block, Select(vertex.here, throughput * next.weight, throughput));
  const Mask8 straight = vertex.here & next.straight;
  if (Any(straight)) Pass(vertex.block, straight, vertex.at.normal);
  ForEach(straight, [&](int lane) { state_->result(vertex.Walk(lane)).met_pane = true; });
  SpawnRays(vertex, vertex.here & ~straight, next);
}

// Makes the next rays along the sampled directions, with Russian roulette.
void PathTracer::SpawnRays(const PathVertex8& vertex, Mask8 leaving, const BsdfSample8& next) {
  State& state = *state_;
  const size_t block = vertex.block;
  WalkRows& walks = state.walks;
  const Vec3x8 throughput = walks.throughput.At(block);
  const Mask8 lost = leaving & (~IsFinite(throughput) | ~(MaxCoeff(throughput) > 0.0f));
  walks.bounce.At(block) -= leaving & ~lost;
  const Float8 survive = Min(MaxCoeff(throughput), 0.95f);
  const Mask8 chanced = leaving & (walks.bounce.At(block) >= kRouletteFrom);
  Mask8 killed{};
  if (Any(chanced)) killed = chanced & (state.Random(block, State::Chance::kRoulette) >= survive);
  End(block, lost | killed);
  walks.throughput.Put(block, Select(chanced, throughput / survive, throughput));
  const auto set = [&](Float8& to, Float8 value) { to = leaving ? value : to; };
  const auto put = [&](Vec3Row& to, const Vec3x8& value) {
    to.Put(block, Select(leaving, value, to.At(block)));
  };
  put(walks.origin, next.origin);
  put(walks.direction, next.direction);
  set(walks.width_m.At(block), state.hits.footprint_m.At(block));
  set(walks.spread.At(block), Min(walks.spread.At(block) + next.blur, 1.0f));
  set(walks.pdf.At(block), vertex.gathers ? next.pdf : Splat(kInfinity));
  const LightReceivers8& receivers = state.receivers[block];
  put(walks.gathered_at, receivers.position);
  set(walks.total.At(block), vertex.lit ? receivers.total : Splat(0));
  walks.room.At(block) = leaving ? receivers.room : walks.room.At(block);
  walks.cell.At(block) = leaving ? receivers.cell : walks.cell.At(block);
}

}  // namespace parallax
