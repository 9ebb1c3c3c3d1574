#include "worker/render/path_tracer.h"

#include "worker/render/bsdf.h"

namespace parallax {
namespace {

constexpr int kMaxPassages = 32;  // Holes and thin panes that a path may pass.
constexpr int kGuideBounces = 3;  // Mirrors that the denoiser's guides follow.
constexpr float kRareWayWeight = 0.02f;
constexpr int kRouletteFrom = 2;  // First bounce that may end by chance.

// The shading normal on the viewer's side, bent just enough that the mirror direction does not dip
// below the surface (which would turn glossy relief black).
Vec3f UsableNormal(const Vec3f& shading, const Vec3f& geometric, const Vec3f& out) {
  Vec3f n = shading;
  const float facing = n.dot(out);
  if (facing < 0.01f) n = (n + out * (0.01f - facing) * 1.02f).normalized();
  const Vec3f mirrored = 2.0f * n.dot(out) * n - out;
  const float height = mirrored.dot(geometric);
  if (height < 0.01f) {
    const Vec3f lifted = (mirrored + geometric * (0.01f - height)).normalized();
    const Vec3f bisector = (lifted + out).normalized();
    if (bisector.dot(out) > 0.0f) n = bisector;
  }
  return n;
}

// Where a smooth mesh's face is lit from near its true horizon: rises from 0 to 1 within half the
// angle (its sine squared is `bend2`) by which the shading normal leans away from the true one. So
// coarse faces cast no hard edge, and little light is lost: a factor that reaches further down to
// the face (Chiang et al. 2019) took 0.7 % of a room's.
float TerminatorFactor(float true_cosine, float bend2) {
  if (4.0f * true_cosine * true_cosine >= bend2) return 1.0f;
  const float t = 2.0f * true_cosine / std::sqrt(bend2);
  return t * t * (3.0f - 2.0f * t);
}

Vec3f Clamped(const Vec3f& contribution, float limit) {
  if (limit <= 0.0f) return contribution;
  const float luminance = Luminance(contribution);
  return luminance > limit ? Vec3f(contribution * (limit / luminance)) : contribution;
}

// Density of a direction that is towards a bright spot now and then, else by the BSDF.
float Mixed(const SpotView& spots, const Vec3f& direction, float by_bsdf) {
  const float share = spots.share();
  return share > 0.0f ? share * spots.Pdf(direction) + (1.0f - share) * by_bsdf : by_bsdf;
}

// Light on its way from a lamp or the sky to a surface, should nothing stand between.
struct ShadowRay {
  Vec3f origin = Vec3f::Zero();
  Vec3f direction = Vec3f::UnitZ();
  float distance = 0;
  Vec3f contribution = Vec3f::Zero();  // To the path, if nothing weakens it.
  float limit = 0;                     // Luminance at which it is cut; 0 = never.
};

// It leaves from `start`, clear of the surface at `position`. It is aimed anew at the light's point
// and ends clear of that: the start is nearer to the light by more than a fixed part of a short
// way, and the light would shade itself. Distance 0: too short for anything to stand in it.
void Aim(const Vec3f& position, const Vec3f& start, const LightSample& light, ShadowRay* shadow) {
  shadow->origin = start;
  shadow->direction = light.direction;
  shadow->distance = light.distance;
  if (!std::isfinite(light.distance)) return;
  const Vec3f target = position + light.distance * light.direction;
  const Vec3f to = target - start;
  const float distance = to.norm();
  const float clear = 2.0f * OffsetDistance(target) + 1e-4f * distance;
  shadow->distance = std::max(0.0f, distance - clear);
  shadow->direction = to / distance;
}

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

class PathTracer::Walk {
 public:
  Walk(const PathTracer& tracer, Path* path) : tracer_(&tracer), path_(path), ray_(path->ray) {}

  // The steps, in their order; each begins to fetch what the next reads.
  static void IntersectAll(std::span<Walk* const> walks);
  void Identify();
  void Shade();
  void GatherLight();

  bool ended() const { return ended_; }

 private:
  // A surface as it is being shaded.
  struct Here {
    SurfaceHit hit;
    SurfaceSample surface;
    Vec3f out;
    Vec3f normal;  // Geometric, on the viewer's side.
    bool outside = true;
  };
  // How much of the light from a direction is admitted: none when shading and true normal see it on
  // different sides (it would leak or blacken), and less near the true horizon, so that the coarse
  // faces of smooth meshes cast no hard edge.
  struct Horizon {
    Vec3f normal;
    float bend2;
    float Admits(const Vec3f& world, const Vec3f& local) const {
      const float height = normal.dot(world);
      if ((height > 0.0f) != (local.z() > 0.0f)) return 0.0f;
      return local.z() > 0.0f ? TerminatorFactor(height, bend2) : 1.0f;
    }
  };

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
  void AskCache();
  bool EndInCache();
  Vec3f MeshLight(uint16_t slot, float cosine) const;
  void AddEmission(const Here& here);
  // Straight on through a hole or a thin pane.
  void Pass(const Here& here);
  Here Meet() const;
  void Remember(const Here& here, bool wide);
  void Guide(const Here& here, const Vec3f& normal);
  void Tint(const SurfaceSample& surface, const Bsdf& bsdf, const BsdfSample& next);
  void UseLight(const Here& here, const ShadingFrame& frame, const Bsdf& bsdf,
                const Horizon& horizon, const LightReceiver& receiver, const SpotView& spots,
                const LightSample& light);
  void Leave(const Here& here, const ShadingFrame& frame, const BsdfSample& next,
             const Horizon& horizon, float survival);
  std::optional<BsdfSample> SampleDirection(const ShadingFrame& frame, const Bsdf& bsdf,
                                            const SpotView& spots, float choice,
                                            const Vec2f& u) const;

  const PathTracer* tracer_;
  Path* path_;
  Ray ray_;
  Vec3f throughput_ = Vec3f::Ones();
  LightReceiver receiver_;  // The last vertex that gathered light.
  // With which the ray left it; infinity: no light sampling could have done this.
  float pdf_ = kInfinity;
  float min_alpha_ = 0;
  Vec3f tint_ = Vec3f::Ones();  // Of the mirrors and panes before the surface that guides.
  int bounce_ = 0, passages_ = 0;
  bool guided_ = false, ended_ = false;

  // Of the step under way.
  bool met_ = false, shadowed_ = false;
  RawHit raw_;
  float width_ = 0;  // Of the ray's cone there.
  SurfaceId id_;
  CacheQuestion question_;
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
  question_ = {};
  if (options().cache) AskCache();
  if (!question_.asked()) scene().PrefetchVertices(raw_);
}

void PathTracer::Walk::Escape() {
  ended_ = true;
  if (!FoundByBsdf()) return;
  const Vec3f sky = lights().EscapeRadiance(receiver_, ray_.direction, MisPdf());
  Add(throughput_.cwiseProduct(sky));
  if (!guided_) result().albedo = sky.cwiseMin(1.0f).cwiseProduct(tint_);
}

void PathTracer::Walk::AskCache() {
  if (bounce_ < options().cache_from || !guided_) return path_->sampler.Skip();
  const Vec2f jitter = path_->sampler.Pair();
  if (scene().traits(id_.material).needs_tracing) return;
  const bool front = ray_.direction.dot(id_.geometric_normal) < 0.0f;
  const CachePlace place{raw_.position, front ? id_.geometric_normal : Vec3f(-id_.geometric_normal),
                         raw_.placed, id_.slot};
  question_ = options().cache->Ask(place, jitter, width_);
}

// With what the cache knows, if it does.
bool PathTracer::Walk::EndInCache() {
  Vec3f cached;
  if (!options().cache || !options().cache->Answer(question_, &cached)) return false;
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
  if (lights().IsMeshLight(here.hit.placed, here.hit.slot)) {
    if (!here.outside || !FoundByBsdf()) return;
    Add(throughput_.cwiseProduct(
        MeshLight(here.hit.slot, here.out.dot(here.hit.geometric_normal))));
  } else if (here.surface.emission.maxCoeff() > 0.0f) {
    Add(throughput_.cwiseProduct(here.surface.emission));
  }
}

void PathTracer::Walk::Pass(const Here& here) {
  ended_ = ++passages_ > kMaxPassages;
  ray_.origin = OffsetPoint(here.hit.position, -here.normal);
  ray_.width_m = width_;
}

void PathTracer::Walk::Guide(const Here& here, const Vec3f& normal) {
  result().albedo = GuideAlbedo(here.surface).cwiseProduct(tint_);
  result().normal = normal;
  guided_ = true;
}

// Where the surface is and which side is seen, not yet what it is like.
PathTracer::Walk::Here PathTracer::Walk::Meet() const {
  Here here;
  here.hit = scene().Resolve(raw_);
  here.out = -ray_.direction;
  here.outside = here.out.dot(here.hit.geometric_normal) > 0.0f;
  here.normal = here.outside ? here.hit.geometric_normal : Vec3f(-here.hit.geometric_normal);
  return here;
}

// For the cache's filler.
void PathTracer::Walk::Remember(const Here& here, bool wide) {
  PathTrail* trail = path_->trail;
  if (!trail || trail->size >= static_cast<int>(trail->vertices.size())) return;
  if (scene().traits(here.hit.material).needs_tracing) return;
  PathVertex& vertex = trail->vertices[static_cast<size_t>(trail->size++)];
  vertex = {{here.hit.position, here.normal, here.hit.placed, here.hit.slot},
            wide,
            throughput_,
            result().radiance,
            {}};
  trial_ = &vertex.trial;
}

// What the denoiser's guides make of a mirror or pane before the surface that guides.
// A pixel's few samples are shared out by chance between what a pane shows and what it mirrors;
// that of the two which most take guides.
void PathTracer::Walk::Tint(const SurfaceSample& surface, const Bsdf& bsdf,
                            const BsdfSample& next) {
  tint_ = tint_.cwiseProduct(next.weight.cwiseMin(1.0f));
  if (surface.transmission <= 0.0f) return;
  const bool passes = next.straight || next.direction.z() < 0.0f;
  if (passes != (bsdf.PassChance() >= 0.5f)) result().guide_weight *= kRareWayWeight;
}

void PathTracer::Walk::Shade() {
  shadowed_ = false;
  trial_ = nullptr;
  if (EndInCache()) return;
  Here here = Meet();
  // Lobe and Russian roulette; opacity and light; the light's point; the way on.
  const auto [choices, through, light_point, onward] = path_->sampler.FourPairs();
  const bool last = bounce_ >= options().max_bounces;
  const bool use_lights =
      options().direct != DirectLight::kBsdfSampling && !lights().empty() && !last;
  // While the surface is looked at, the light's memory is fetched.
  LightReceiver receiver;
  LightChoice light;
  if (use_lights) {
    LightImportances importances;
    receiver = lights().Receive(here.hit.position, here.normal, &importances);
    light = lights().Choose(receiver, importances, through.y(), light_point);
  }

  here.surface = scene().Evaluate(here.hit, width_);
  const SurfaceSample& surface = here.surface;
  AddEmission(here);
  if (surface.opacity < 1.0f && through.x() >= surface.opacity) return Pass(here);

  const Vec3f bumped = scene().BumpedNormal(here.hit, width_);
  const ShadingFrame frame(
      UsableNormal(here.outside ? bumped : Vec3f(-bumped), here.normal, here.out));
  const bool wide = ScattersWidely(surface);
  Remember(here, wide);
  const Bsdf bsdf(surface, frame.ToLocal(here.out), here.outside, min_alpha_);
  // What solid glass refracts is torn by its bumps: there the glass itself guides.
  const bool solid_glass = surface.transmission > 0.0f && !surface.thin_walled;
  if (!guided_ && (last || bounce_ >= kGuideBounces || !bsdf.mirror_like() || solid_glass)) {
    Guide(here, frame.z);
  }
  ended_ = last && !(surface.thin_walled && surface.transmission > 0.0f);
  if (ended_) return;

  const Horizon horizon{here.normal, 1.0f - Square(frame.z.dot(here.normal))};
  const bool gathers = use_lights && !bsdf.mirror_like();
  SpotView spots;
  if (gathers) {
    if (wide && receiver.enclosure) {
      spots = SpotView(receiver.enclosure->spots, here.hit.position, here.normal);
    }
    UseLight(here, frame, bsdf, horizon, receiver, spots,
             lights().Sample(receiver, light, light_point));
  }

  const std::optional<BsdfSample> next = SampleDirection(frame, bsdf, spots, choices.x(), onward);
  ended_ = !next || (last && !next->straight);
  if (next && !guided_) Tint(surface, bsdf, *next);
  if (ended_) return;
  if (next->straight) {
    throughput_ = throughput_.cwiseProduct(next->weight);
    return Pass(here);
  }
  Leave(here, frame, *next, horizon, choices.y());
  pdf_ = gathers ? next->pdf : kInfinity;
  receiver_ = receiver;
}

// Next-event estimation; the shadow ray waits for its turn.
void PathTracer::Walk::UseLight(const Here& here, const ShadingFrame& frame, const Bsdf& bsdf,
                                const Horizon& horizon, const LightReceiver& receiver,
                                const SpotView& spots, const LightSample& light) {
  const float irradiance =
      Luminance(light.radiance) * std::max(0.0f, here.normal.dot(light.direction));
  if (trial_ && !(irradiance > 0.0f)) *trial_ = lights().Trial(receiver, light, 0.0f);
  if (!(light.pdf > 0.0f) || light.radiance.isZero()) return;
  const Vec3f i = frame.ToLocal(light.direction);
  const float part = horizon.Admits(light.direction, i);
  if (part <= 0.0f) return;
  BsdfValue value = bsdf.Evaluate(i);
  value.pdf = Mixed(spots, light.direction, value.pdf);
  value.f_cos *= part;
  if (IsBlack(value.f_cos)) return;
  const float weight = light.ideal || options().direct == DirectLight::kLightSampling
                           ? 1.0f
                           : PowerHeuristic(light.pdf, value.pdf);
  shadow_.contribution =
      throughput_.cwiseProduct(value.f_cos).cwiseProduct(light.radiance) * (weight / light.pdf);
  if (!(shadow_.contribution.maxCoeff() > 1e-7f) || !shadow_.contribution.allFinite()) return;
  if (bounce_ > 0) shadow_.limit = options().clamp_luminance;
  const float leave = i.z() > 0.0f ? 1.0f : -1.0f;
  Aim(here.hit.position, OffsetPoint(here.hit.position, leave * here.normal), light, &shadow_);
  shadowed_ = true;
  if (trial_) *trial_ = lights().Trial(receiver, light, irradiance);
}

// Towards a bright spot or by the BSDF alone, with the density of that mixture.
std::optional<BsdfSample> PathTracer::Walk::SampleDirection(const ShadingFrame& frame,
                                                            const Bsdf& bsdf, const SpotView& spots,
                                                            float choice, const Vec2f& u) const {
  const float share = spots.share();
  if (choice < share) {
    const Vec3f world = spots.Sample(choice / share, u);
    BsdfSample sample;
    sample.direction = frame.ToLocal(world);
    sample.blur = 0.5f;
    const BsdfValue value = bsdf.Evaluate(sample.direction);
    if (IsBlack(value.f_cos)) return std::nullopt;
    sample.pdf = Mixed(spots, world, value.pdf);
    sample.weight = value.f_cos / sample.pdf;
    return sample;
  }
  std::optional<BsdfSample> sample = bsdf.Sample((choice - share) / (1.0f - share), u);
  if (!sample || sample->straight || share <= 0.0f) return sample;
  const float pdf = Mixed(spots, frame.ToWorld(sample->direction), sample->pdf);
  sample->weight *= sample->pdf / pdf;
  sample->pdf = pdf;
  return sample;
}

void PathTracer::Walk::GatherLight() {
  if (!shadowed_) return;
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
void PathTracer::Walk::Leave(const Here& here, const ShadingFrame& frame, const BsdfSample& next,
                             const Horizon& horizon, float survival) {
  const Vec3f direction = frame.ToWorld(next.direction).normalized();
  const float part = horizon.Admits(direction, next.direction);
  throughput_ = throughput_.cwiseProduct(next.weight) * part;
  ended_ = part <= 0.0f || !throughput_.allFinite() || IsBlack(throughput_);
  if (ended_) return;
  ++bounce_;
  if (bounce_ >= kRouletteFrom) {
    const float survive = std::min(0.95f, throughput_.maxCoeff());
    ended_ = survival >= survive;
    if (ended_) return;
    throughput_ /= survive;
  }
  if (options().regularise && next.blur > 0.1f) min_alpha_ = 0.09f;
  ray_.origin =
      OffsetPoint(here.hit.position, next.direction.z() > 0.0f ? here.normal : Vec3f(-here.normal));
  ray_.direction = direction;
  ray_.width_m = width_;
  ray_.spread = std::min(1.0f, ray_.spread + next.blur);
}

// ---- Many paths ----

PathTracer::PathTracer(const RenderScene& scene, const LightTable& lights,
                       const PathOptions& options)
    : scene_(scene), lights_(lights), options_(options) {}
PathTracer::~PathTracer() = default;

void PathTracer::Trace(std::span<Path> paths) {
  while (!paths.empty()) {
    const size_t count = std::min(paths.size(), kTogether);
    TraceTogether(paths.first(count));
    paths = paths.subspan(count);
  }
}

PathResult PathTracer::Trace(const Ray& ray, const Sampler& sampler) {
  Path path{ray, sampler, nullptr, {}};
  TraceTogether({&path, 1});
  return path.result;
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
    for (Walk* walk : under_way_) walk->Shade();
    for (Walk* walk : under_way_) walk->GatherLight();
    drop_ended();
  }
}

}  // namespace parallax
