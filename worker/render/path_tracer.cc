#include "worker/render/path_tracer.h"

#include "worker/render/scatter.h"

namespace parallax {
namespace {

constexpr int kMaxPassages = 32;  // Holes and thin panes that a path may pass.
constexpr int kGuideBounces = 1;  // Mirrors that the denoiser's guides follow.
constexpr float kRareWayWeight = 0.02f;
constexpr int kRouletteFrom = 2;  // First bounce that may end by chance.

Vec3f Clamped(const Vec3f& contribution, float limit) {
  if (limit <= 0.0f) return contribution;
  const float luminance = Luminance(contribution);
  return luminance > limit ? Vec3f(contribution * (limit / luminance)) : contribution;
}

// Light on its way from a lamp or the sky to a surface, should nothing stand between.
struct ShadowRay {
  Vec3f origin = Vec3f::Zero();
  Vec3f direction = Vec3f::UnitZ();
  float distance = 0;
  Vec3f contribution = Vec3f::Zero();  // To the path, if nothing weakens it.
  float limit = 0;                     // Luminance at which it is cut; 0 = never.
};

// What the denoiser is told about the first surface.
Vec3f GuideAlbedo(const SurfaceSample& s) {
  const float opaque = 1.0f - s.transmission * (1.0f - s.metallic);
  return (s.base_color * opaque + Vec3f::Constant(1.0f - opaque)).cwiseMax(0.0f).cwiseMin(1.0f);
}

// Whether most of what it reflects goes about equally to all sides.
bool ScattersWidely(const SurfaceSample& s) {
  constexpr float kWideRoughness = 0.4f;
  constexpr float kSharpShare = 0.35f;
  const float plastic = (1.0f - s.metallic) * (1.0f - s.transmission);
  const float base = Luminance(s.base_color);
  float wide = plastic * base;
  float sharp = 0.06f * s.clearcoat * (s.clearcoat_roughness < kWideRoughness ? 1.0f : 0.0f) +
                (1.0f - s.metallic) * s.transmission;
  (s.roughness < kWideRoughness ? sharp : wide) += s.metallic * base + plastic * 0.12f * s.specular;
  return sharp <= kSharpShare * (wide + sharp);
}

}  // namespace

// ---- A path under way ----

// A surface as it is being shaded.
struct PathTracer::Here {
  SurfaceSample surface;
  Vec3f shading_normal;  // With relief, on the side of counter-clockwise winding.
  Vec3f out;
  Vec3f normal;  // Geometric, on the viewer's side.
  bool outside = true;
};

// Walks on the same material, to be looked at together.
struct PathTracer::Alike {
  int count = 0;
  std::array<Walk*, kLanes> walks;
};

// Where walks are, and the lights that they will look at.
struct PathTracer::Meeting {
  std::array<Here, kTogether> here;
  std::vector<Alike> alike;         // By material; empty between steps.
  std::vector<uint32_t> materials;  // That some wait at.
  LightSeekers8 seekers{};
  std::array<LightReceiver, kTogether> receivers;
  std::array<LightChoice, kTogether> lights;
  std::array<LightSample, kTogether> samples;
  std::vector<Float8> scratch;
};

// What a walk keeps of the surface that it has reached until it departs.
struct PathTracer::Reached {
  Walk* walk = nullptr;
  Vec3f position, normal;  // Geometric, on the viewer's side.
  Vec3f albedo;            // For the denoiser.
  bool transmits = false, thin = false;
  bool last = false;  // No light is gathered, and nothing but a thin wall leads on.
  bool lit = false;   // A light was chosen.
  float survival = 0;
  const LightReceiver* receiver = nullptr;
  const LightSample* light = nullptr;
};

// Walks that scatter together.
struct PathTracer::Group {
  Standing8 at{};
  Reached reached[kLanes];
  int size = 0;
};

class PathTracer::Walk {
 public:
  Walk(const PathTracer& tracer, Path* path) : tracer_(&tracer), path_(path), ray_(path->ray) {}

  // The steps, in their order; each begins to fetch what the next reads. Walks that reach a
  // surface scatter there in groups.
  static void IntersectAll(std::span<Walk* const> walks);
  void Identify();
  static void AskCache(std::span<Walk* const> walks);
  // With what the cache knows, if it does.
  bool EndInCache();
  static void Draw(std::span<Walk* const> walks);
  // Where the surface is and which side is seen, not yet what it is like.
  void Meet(Here* here);
  // Chooses the light that each will take a sample of, for eight at a time.
  static void ChooseLights(std::span<Walk* const> walks, Meeting* meeting);
  // And takes it, once what it reads has come from memory.
  static void SampleLights(std::span<Walk* const> walks, Meeting* meeting);
  // True if it takes a lane of the group; else it has ended or passes straight on.
  bool Reach(const Meeting& meeting, size_t which, Group* group);
  void Depart(const Group& group, int lane, const Shadow8& shadow, const Onward8& onward,
              const Scatter8& scatter);
  void GatherLight();

  bool ended() const { return ended_; }
  Here* here() { return here_; }
  uint32_t material() const { return id_.material; }
  Sight sight() const { return {&raw_, &id_, width_}; }

 private:
  const RenderScene& scene() const { return tracer_->scene_; }
  const LightTable& lights() const { return tracer_->lights_; }
  const PathOptions& options() const { return tracer_->options_; }
  PathResult& result() { return path_->result; }

  void Add(const Vec3f& contribution) {
    if (!contribution.allFinite()) return;
    result().radiance +=
        bounce_ > 0 ? Clamped(contribution, options().clamp_luminance) : contribution;
  }
  // Density for MIS: single strategies either count whole or not at all.
  bool FoundByBsdf() const {
    return options().direct != DirectLight::kLightSampling || !std::isfinite(pdf_);
  }
  float MisPdf() const { return options().direct == DirectLight::kBsdfSampling ? kInfinity : pdf_; }

  bool GoesWith(const Walk& other) const;
  void Intersect();
  static void IntersectPacket(std::span<Walk* const> walks);
  void Met(bool met);
  void Escape();
  bool MayAskCache() const;
  CachePlace Place() const;
  Vec3f MeshLight(uint16_t slot, float cosine) const;
  void AddEmission(const Here& here);
  // Straight on through a hole or a thin pane.
  void Pass(const Vec3f& position, const Vec3f& normal);
  void Remember(const Here& here, bool wide);
  void Stand(const Here& here, const Reached& reached, Standing8* at, int lane) const;
  void Guide(const Vec3f& albedo, const Vec3f& normal);
  void Tint(const Reached& reached, int lane, const Onward8& onward, const Scatter8& scatter);
  void UseLight(const Reached& reached, int lane, const Shadow8& shadow);
  void Leave(const Reached& reached, int lane, const Onward8& onward);

  const PathTracer* tracer_;
  Path* path_;
  Ray ray_;
  Vec3f throughput_ = Vec3f::Ones();
  LightReceiver receiver_;  // The last vertex that gathered light.
  // With which the ray left it; infinity: no light sampling could have done this.
  float pdf_ = kInfinity;
  Vec3f tint_ = Vec3f::Ones();  // Of the mirrors and panes before the surface that guides.
  int bounce_ = 0, passages_ = 0;
  bool guided_ = false, ended_ = false;

  // Of the step under way.
  // Lobe and Russian roulette; opacity and light; the light's point; the way on.
  std::array<Vec2f, 4> numbers_;
  bool met_ = false, shadowed_ = false;
  RawHit raw_;
  float width_ = 0;  // Of the ray's cone there.
  SurfaceId id_;
  uint64_t question_ = 0;  // To the cache.
  Here* here_ = nullptr;
  ShadowRay shadow_;
  LightTrial* trial_ = nullptr;  // Where the cache's filler wants to know of it.
};

// Those of an eye that look about the same way go in packets.
void PathTracer::Walk::IntersectAll(std::span<Walk* const> walks) {
  while (!walks.empty()) {
    const auto packet = walks.first(std::min<size_t>(walks.size(), RayTrees::kPacket));
    const bool coherent = packet.size() > 1 &&
                          std::all_of(packet.begin(), packet.end(),
                                      [&](const Walk* walk) { return walk->GoesWith(*packet[0]); });
    if (coherent) {
      IntersectPacket(packet);
    } else {
      for (Walk* walk : packet) walk->Intersect();
    }
    walks = walks.subspan(packet.size());
  }
}

bool PathTracer::Walk::GoesWith(const Walk& other) const {
  constexpr float kAlike = 0.999f;  // Cosine of 2.5 degrees.
  return bounce_ == 0 && ray_.origin == other.ray_.origin &&
         ray_.direction.dot(other.ray_.direction) > kAlike;
}

void PathTracer::Walk::Intersect() {
  Met(scene().trees().Intersect(RayTrees::Tree::kFast, ray_, 0.0f, &raw_));
}

void PathTracer::Walk::IntersectPacket(std::span<Walk* const> walks) {
  std::array<const Ray*, RayTrees::kPacket> rays{};
  std::array<RawHit*, RayTrees::kPacket> hits{};
  for (size_t k = 0; k < walks.size(); ++k) {
    rays[k] = &walks[k]->ray_;
    hits[k] = &walks[k]->raw_;
  }
  const uint32_t met = walks[0]->scene().trees().Intersect(
      RayTrees::Tree::kFast, rays.data(), hits.data(), static_cast<int>(walks.size()));
  for (size_t k = 0; k < walks.size(); ++k) walks[k]->Met((met >> k & 1) != 0);
}

void PathTracer::Walk::Met(bool met) {
  ++result().rays;
  met_ = met;
  if (met_) scene().Prefetch(raw_);
}

void PathTracer::Walk::Identify() {
  if (bounce_ > 0 && FoundByBsdf()) {
    const Vec3f spheres = lights().SphereRadiance(receiver_, ray_.origin, ray_.direction,
                                                  met_ ? raw_.distance : kInfinity, MisPdf());
    if (!spheres.isZero()) Add(throughput_.cwiseProduct(spheres));
  }
  if (!met_) return Escape();
  width_ = ray_.width_m + ray_.spread * raw_.distance;
  id_ = scene().Identify(raw_);
}

void PathTracer::Walk::Escape() {
  ended_ = true;
  if (!FoundByBsdf()) return;
  const Vec3f sky = lights().EscapeRadiance(receiver_, ray_.direction, MisPdf());
  Add(throughput_.cwiseProduct(sky));
  if (!guided_) result().albedo = sky.cwiseMin(1.0f).cwiseProduct(tint_);
}

CachePlace PathTracer::Walk::Place() const {
  const bool front = ray_.direction.dot(id_.geometric_normal) < 0.0f;
  return {raw_.position, front ? id_.geometric_normal : Vec3f(-id_.geometric_normal), raw_.placed,
          id_.slot};
}

bool PathTracer::Walk::MayAskCache() const {
  return options().cache && bounce_ >= options().cache_from && guided_;
}

// By eights. Those that need no answer begin to fetch what shading reads.
void PathTracer::Walk::AskCache(std::span<Walk* const> walks) {
  CacheQuestions8 questions;
  Walk* asking[kLanes];
  Sampler* samplers[kLanes];
  const auto ask = [&] {
    if (questions.count == 0) return;
    Sampler::Pairs(samplers, questions.count, &questions.jitter_u, &questions.jitter_v);
    uint64_t keys[kLanes];
    asking[0]->options().cache->Ask(questions, keys);
    for (int k = 0; k < questions.count; ++k) {
      asking[k]->question_ = keys[k];
      if (keys[k] == 0) asking[k]->scene().PrefetchVertices(asking[k]->raw_);
    }
    questions.count = 0;
  };
  for (Walk* walk : walks) {
    walk->question_ = 0;
    if (!walk->MayAskCache()) {
      if (walk->options().cache) walk->path_->sampler.Skip();
      walk->scene().PrefetchVertices(walk->raw_);
      continue;
    }
    const int lane = questions.count++;
    asking[lane] = walk;
    samplers[lane] = &walk->path_->sampler;
    const CachePlace place = walk->Place();
    questions.position.Set(lane, place.position);
    questions.normal.Set(lane, place.normal);
    questions.placed[lane] = place.placed;
    questions.slot[lane] = place.slot;
    questions.widest_m[lane] = walk->scene().traits(walk->id_.material).needs_tracing
                                   ? 0.0f
                                   : walk->width_ / walk->options().cache_footprint;
    if (questions.count == kLanes) ask();
  }
  ask();
}

bool PathTracer::Walk::EndInCache() {
  Vec3f cached;
  if (question_ == 0 || !options().cache->Answer(question_, Place(), &cached)) return false;
  const float cosine = -ray_.direction.dot(id_.geometric_normal);
  if (cosine > 0.0f && FoundByBsdf() && lights().IsMeshLight(raw_.placed, id_.slot)) {
    Add(throughput_.cwiseProduct(MeshLight(id_.slot, cosine)));
  }
  Add(throughput_.cwiseProduct(cached));
  ended_ = true;
  return true;
}

// What a light's face that the ray met sends back along it, weighted by MIS.
Vec3f PathTracer::Walk::MeshLight(uint16_t slot, float cosine) const {
  const Vec3f radiance = lights().MeshRadiance(raw_.placed, slot);
  if (!std::isfinite(pdf_) || options().direct == DirectLight::kBsdfSampling) return radiance;
  const float distance = (raw_.position - receiver_.position).norm();
  const float light_pdf = lights().MeshPdf(receiver_, raw_.placed, slot, distance, cosine);
  return radiance * PowerHeuristic(pdf_, light_pdf);
}

void PathTracer::Walk::AddEmission(const Here& here) {
  if (lights().IsMeshLight(raw_.placed, id_.slot)) {
    if (!here.outside || !FoundByBsdf()) return;
    Add(throughput_.cwiseProduct(MeshLight(id_.slot, here.out.dot(id_.geometric_normal))));
  } else if (here.surface.emission.maxCoeff() > 0.0f) {
    Add(throughput_.cwiseProduct(here.surface.emission));
  }
}

void PathTracer::Walk::Pass(const Vec3f& position, const Vec3f& normal) {
  ended_ = ++passages_ > kMaxPassages;
  ray_.origin = OffsetPoint(position, -normal);
  ray_.width_m = width_;
}

void PathTracer::Walk::Guide(const Vec3f& albedo, const Vec3f& normal) {
  result().albedo = albedo.cwiseProduct(tint_);
  result().normal = normal;
  guided_ = true;
}

void PathTracer::Walk::Draw(std::span<Walk* const> walks) {
  for (size_t first = 0; first < walks.size(); first += kLanes) {
    const auto some = walks.subspan(first, std::min<size_t>(kLanes, walks.size() - first));
    Sampler* samplers[kLanes];
    for (size_t k = 0; k < some.size(); ++k) samplers[k] = &some[k]->path_->sampler;
    for (size_t pair = 0; pair < 4; ++pair) {
      Float8 u, v;
      Sampler::Pairs(samplers, static_cast<int>(some.size()), &u, &v);
      for (size_t k = 0; k < some.size(); ++k) some[k]->numbers_[pair] = {u[k], v[k]};
    }
  }
}

void PathTracer::Walk::Meet(Here* here) {
  here_ = here;
  here->out = -ray_.direction;
  here->outside = here->out.dot(id_.geometric_normal) > 0.0f;
  here->normal = here->outside ? id_.geometric_normal : Vec3f(-id_.geometric_normal);
}

// For the cache's filler.
void PathTracer::Walk::Remember(const Here& here, bool wide) {
  PathTrail* trail = path_->trail;
  if (!trail || trail->size >= static_cast<int>(trail->vertices.size())) return;
  if (scene().traits(id_.material).needs_tracing) return;
  PathVertex& vertex = trail->vertices[static_cast<size_t>(trail->size++)];
  vertex = {{raw_.position, here.normal, raw_.placed, id_.slot},
            wide,
            throughput_,
            result().radiance,
            {}};
  trial_ = &vertex.trial;
}

void PathTracer::Walk::ChooseLights(std::span<Walk* const> walks, Meeting* meeting) {
  if (walks.empty() || walks[0]->options().only_guides) return;
  const LightTable& lights = walks[0]->lights();
  LightSeekers8& seekers = meeting->seekers;
  for (size_t first = 0; first < walks.size(); first += kLanes) {
    seekers.count = static_cast<int>(std::min<size_t>(kLanes, walks.size() - first));
    for (int k = 0; k < seekers.count; ++k) {
      const Walk& walk = *walks[first + static_cast<size_t>(k)];
      seekers.position.Set(k, walk.raw_.position);
      seekers.normal.Set(k, walk.here_->normal);
      seekers.choice[k] = walk.numbers_[1].y();
    }
    LightChoice* choices = &meeting->lights[first];
    lights.Choose(seekers, &meeting->scratch, &meeting->receivers[first], choices);
    for (int k = 0; k < seekers.count; ++k) {
      lights.Aim(walks[first + static_cast<size_t>(k)]->numbers_[2], &choices[k]);
    }
  }
}

void PathTracer::Walk::SampleLights(std::span<Walk* const> walks, Meeting* meeting) {
  if (walks.empty() || walks[0]->options().only_guides) return;
  for (size_t first = 0; first < walks.size(); first += kLanes) {
    const int count = static_cast<int>(std::min<size_t>(kLanes, walks.size() - first));
    Float8 u = Splat(0), v = u;
    for (int k = 0; k < count; ++k) {
      const Vec2f& point = walks[first + static_cast<size_t>(k)]->numbers_[2];
      u[k] = point.x();
      v[k] = point.y();
    }
    walks[0]->lights().Sample(&meeting->receivers[first], &meeting->lights[first], count, u, v,
                              &meeting->samples[first]);
  }
}

bool PathTracer::Walk::Reach(const Meeting& meeting, size_t which, Group* group) {
  trial_ = nullptr;
  const Here& here = *here_;
  const Vec2f &choices = numbers_[0], &through = numbers_[1];
  const int lane = group->size;
  Reached& reached = group->reached[lane];
  reached.last = bounce_ >= options().max_bounces;
  reached.lit = options().direct != DirectLight::kBsdfSampling && !lights().empty() &&
                !reached.last && !options().only_guides;
  static const LightReceiver kNowhere;
  static const LightSample kNoLight;
  reached.receiver = reached.lit ? &meeting.receivers[which] : &kNowhere;
  reached.light = reached.lit ? &meeting.samples[which] : &kNoLight;

  const SurfaceSample& surface = here.surface;
  AddEmission(here);
  if (surface.opacity < 1.0f && through.x() >= surface.opacity) {
    Pass(raw_.position, here.normal);
    return false;
  }
  const bool wide = ScattersWidely(surface);
  Remember(here, wide);
  reached.transmits = surface.transmission > 0.0f;
  reached.thin = surface.thin_walled;
  ended_ = reached.last && guided_ && !(reached.thin && reached.transmits);
  if (ended_) return false;

  reached.walk = this;
  reached.position = raw_.position;
  reached.normal = here.normal;
  reached.albedo = GuideAlbedo(surface);
  reached.survival = choices.y();
  Stand(here, reached, &group->at, lane);
  if (reached.lit && wide && reached.receiver->enclosure) {
    SpotView& spots = group->at.spots[lane];
    spots.Look(reached.receiver->enclosure->spots, raw_.position, here.normal);
    group->at.spot_share[lane] = spots.share();
  }
  return true;
}

// Takes its lane.
void PathTracer::Walk::Stand(const Here& here, const Reached& reached, Standing8* at,
                             int lane) const {
  at->position.Set(lane, raw_.position);
  at->out.Set(lane, here.out);
  at->normal.Set(lane, here.normal);
  at->shading.Set(lane, here.outside ? here.shading_normal : Vec3f(-here.shading_normal));
  at->outside[lane] = here.outside ? -1 : 0;
  at->surface.Set(lane, here.surface);
  at->throughput.Set(lane, throughput_);
  at->choice[lane] = numbers_[0].x();
  at->u[lane] = numbers_[3].x();
  at->v[lane] = numbers_[3].y();
  at->spot_share[lane] = 0;
  at->light_direction.Set(lane, reached.light->direction);
  at->light_radiance.Set(lane, reached.light->radiance);
  at->light_distance[lane] = reached.light->distance;
  at->light_pdf[lane] = reached.light->pdf;
  at->ideal[lane] = reached.light->ideal ? -1 : 0;
}

void PathTracer::Walk::Depart(const Group& group, int lane, const Shadow8& shadow,
                              const Onward8& onward, const Scatter8& scatter) {
  const Reached& reached = group.reached[lane];
  const bool mirror_like = scatter.bsdf().mirror_like()[lane] != 0;
  // What solid glass refracts is torn by its bumps: there the glass itself guides.
  const bool solid_glass = reached.transmits && !reached.thin;
  if (!guided_ && (reached.last || bounce_ >= kGuideBounces || !mirror_like || solid_glass)) {
    Guide(reached.albedo, scatter.normal().Get(lane));
  }
  ended_ =
      (reached.last && !(reached.thin && reached.transmits)) || (guided_ && options().only_guides);
  if (ended_) return;
  const bool gathers = reached.lit && !mirror_like;
  if (gathers) UseLight(reached, lane, shadow);

  const bool goes = onward.goes[lane] != 0, straight = onward.straight[lane] != 0;
  if (goes && !guided_) Tint(reached, lane, onward, scatter);
  ended_ = !goes || (reached.last && !straight);
  if (ended_) return;
  throughput_ = throughput_.cwiseProduct(onward.weight.Get(lane));
  if (straight) return Pass(reached.position, reached.normal);
  Leave(reached, lane, onward);
  pdf_ = gathers ? onward.pdf[lane] : kInfinity;
  receiver_ = *reached.receiver;
}

// What the denoiser's guides make of a mirror or pane before the surface that guides.
// A pixel's few samples are shared out by chance between what a pane shows and what it mirrors;
// that of the two which most take guides.
void PathTracer::Walk::Tint(const Reached& reached, int lane, const Onward8& onward,
                            const Scatter8& scatter) {
  tint_ = tint_.cwiseProduct(onward.weight.Get(lane).cwiseMin(1.0f));
  if (!reached.transmits) return;
  const bool mostly_passes = scatter.bsdf().PassChance()[lane] >= 0.5f;
  if ((onward.passes[lane] != 0) != mostly_passes) result().guide_weight *= kRareWayWeight;
}

// Next-event estimation; the shadow ray waits for its turn.
void PathTracer::Walk::UseLight(const Reached& reached, int lane, const Shadow8& shadow) {
  shadowed_ = shadow.lit[lane] != 0;
  if (shadowed_) {
    shadow_ = {shadow.origin.Get(lane), shadow.direction.Get(lane), shadow.distance[lane],
               shadow.contribution.Get(lane), bounce_ > 0 ? options().clamp_luminance : 0.0f};
  }
  if (!trial_) return;
  const LightSample& light = *reached.light;
  const float irradiance =
      Luminance(light.radiance) * std::max(0.0f, reached.normal.dot(light.direction));
  if (shadowed_ || !(irradiance > 0.0f)) {
    *trial_ = lights().Trial(*reached.receiver, light, irradiance);
  }
}

void PathTracer::Walk::GatherLight() {
  if (!std::exchange(shadowed_, false)) return;
  ++result().rays;
  Vec3f light = shadow_.contribution;
  if (shadow_.distance > 0.0f) {
    light = light.cwiseProduct(
        scene().Transmittance(shadow_.origin, shadow_.direction, shadow_.distance));
  }
  if (trial_) trial_->gain *= Luminance(light) / Luminance(shadow_.contribution);
  result().radiance += Clamped(light, shadow_.limit);
}

// Along the sampled direction, if chance lets it live.
void PathTracer::Walk::Leave(const Reached& reached, int lane, const Onward8& onward) {
  ended_ = !throughput_.allFinite() || IsBlack(throughput_);
  if (ended_) return;
  ++bounce_;
  if (bounce_ >= kRouletteFrom) {
    const float survive = std::min(0.95f, throughput_.maxCoeff());
    ended_ = reached.survival >= survive;
    if (ended_) return;
    throughput_ /= survive;
  }
  ray_.origin = onward.origin.Get(lane);
  ray_.direction = onward.direction.Get(lane);
  ray_.width_m = width_;
  ray_.spread = std::min(1.0f, ray_.spread + onward.blur[lane]);
}

// ---- Many paths ----

PathTracer::PathTracer(const RenderScene& scene, const LightTable& lights,
                       const PathOptions& options)
    : scene_(scene),
      lights_(lights),
      options_(options),
      meeting_(std::make_unique<Meeting>()),
      group_(std::make_unique<Group>()) {
  meeting_->alike.resize(scene.geometry().materials.size());
}
PathTracer::~PathTracer() = default;

void PathTracer::Trace(std::span<Path> paths) {
  while (!paths.empty()) {
    const size_t count = std::min(paths.size(), kTogether);
    TraceTogether(paths.first(count));
    paths = paths.subspan(count);
  }
}

PathResult PathTracer::Trace(const Ray& ray, const Sampler& sampler) {
  Path path(sampler, ray);
  TraceTogether({&path, 1});
  return path.result;
}

// By eights of one material.
void PathTracer::LookAtSurfaces() {
  std::vector<Alike>& waiting = meeting_->alike;
  for (Walk* walk : under_way_) {
    const uint32_t material = walk->material();
    Alike& alike = waiting[material];
    if (alike.count == 0) meeting_->materials.push_back(material);
    alike.walks[static_cast<size_t>(alike.count++)] = walk;
    if (alike.count == kLanes) Look(&alike);
  }
  for (const uint32_t material : meeting_->materials) {
    if (waiting[material].count > 0) Look(&waiting[material]);
  }
  meeting_->materials.clear();
}

void PathTracer::Look(Alike* alike) {
  const int count = std::exchange(alike->count, 0);
  Sight sights[kLanes];
  for (int k = 0; k < count; ++k) sights[k] = alike->walks[static_cast<size_t>(k)]->sight();
  const Look8 look = scene_.Look({sights, static_cast<size_t>(count)});
  for (int k = 0; k < count; ++k) {
    Here* here = alike->walks[static_cast<size_t>(k)]->here();
    here->surface = look.surface.Get(k);
    here->shading_normal = look.shading_normal.Get(k);
  }
}

void PathTracer::ScatterGroup() {
  if (group_->size == 0) return;
  const Scatter8 scatter(group_->at);
  Shadow8 shadow{};
  Onward8 onward{};
  // Where only guides are wanted, only mirrors lead on.
  if (!options_.only_guides || Any(scatter.bsdf().mirror_like())) {
    shadow = scatter.Light(options_.direct == DirectLight::kBoth);
    onward = scatter.Onward();
  }
  for (int lane = 0; lane < group_->size; ++lane) {
    group_->reached[lane].walk->Depart(*group_, lane, shadow, onward, scatter);
  }
  group_->size = 0;
}

void PathTracer::TraceTogether(std::span<Path> paths) {
  walks_.clear();
  for (Path& path : paths) walks_.emplace_back(*this, &path);
  under_way_.clear();
  for (Walk& walk : walks_) under_way_.push_back(&walk);
  const auto drop_ended = [&] { std::erase_if(under_way_, [](Walk* w) { return w->ended(); }); };
  while (!under_way_.empty()) {
    Walk::IntersectAll(under_way_);
    for (Walk* walk : under_way_) walk->Identify();
    drop_ended();
    Walk::AskCache(under_way_);
    std::erase_if(under_way_, [](Walk* walk) { return walk->EndInCache(); });
    Walk::Draw(under_way_);
    for (size_t k = 0; k < under_way_.size(); ++k) under_way_[k]->Meet(&meeting_->here[k]);
    LookAtSurfaces();
    Walk::ChooseLights(under_way_, meeting_.get());
    Walk::SampleLights(under_way_, meeting_.get());
    for (size_t k = 0; k < under_way_.size(); ++k) {
      if (!under_way_[k]->Reach(*meeting_, k, group_.get())) continue;
      if (++group_->size == kLanes) ScatterGroup();
    }
    ScatterGroup();
    for (Walk* walk : under_way_) walk->GatherLight();
    drop_ended();
  }
}

}  // namespace parallax
