#include "worker/render/film/denoiser.h"

#include <cmath>
#include <string>

// The few entry points of Open Image Denoise 2.x that are called here, as its reference declares
// them: the wheel that carries the library has no header.
extern "C" {
using OIDNDevice = struct OIDNDeviceImpl*;
using OIDNFilter = struct OIDNFilterImpl*;
using OIDNProgressMonitorFunction = bool (*)(void* user, double fraction);
OIDNDevice oidnNewDevice(int type);
void oidnCommitDevice(OIDNDevice device);
void oidnReleaseDevice(OIDNDevice device);
void oidnSetDeviceBool(OIDNDevice device, const char* name, bool value);
int oidnGetDeviceError(OIDNDevice device, const char** message);
OIDNFilter oidnNewFilter(OIDNDevice device, const char* type);
void oidnReleaseFilter(OIDNFilter filter);
void oidnSetSharedFilterImage(OIDNFilter filter, const char* name, void* data, int format,
                              size_t width, size_t height, size_t byte_offset, size_t pixel_stride,
                              size_t row_stride);
void oidnSetFilterBool(OIDNFilter filter, const char* name, bool value);
void oidnSetFilterInt(OIDNFilter filter, const char* name, int value);
void oidnSetFilterProgressMonitorFunction(OIDNFilter filter, OIDNProgressMonitorFunction function,
                                          void* user);
void oidnCommitFilter(OIDNFilter filter);
void oidnExecuteFilter(OIDNFilter filter);
}

namespace parallax {
namespace {

constexpr int kDeviceCpu = 1;
constexpr int kFloat3 = 3;
enum OidnError { kNone = 0, kOutOfMemory = 4, kCancelledByUser = 6 };

// Converts the library's pending error to a status.
absl::Status TakeError(OIDNDevice device) {
  const char* message = nullptr;
  const int error = oidnGetDeviceError(device, &message);
  const std::string text = std::string("denoise: ") + (message ? message : "unknown error");
  switch (error) {
    case kNone:
      return absl::OkStatus();
    case kCancelledByUser:
      return Cancelled("render: cancelled");
    case kOutOfMemory:
      return ResourceExhausted("{}", text);
    default:
      return Internal("{}", text);
  }
}

bool KeepGoing(void* cancel, double /*fraction*/) {
  return !static_cast<const CancelToken*>(cancel)->cancelled();
}

}  // namespace

struct Denoiser::State {
  OIDNDevice device = nullptr;
  OIDNFilter filter = nullptr;
  // Filter inputs keep their addresses, so that the network is set up once for each size.
  ImageF3 color, albedo, normal;

  ~State() {
    if (filter) oidnReleaseFilter(filter);
    if (device) oidnReleaseDevice(device);
  }
  void Bind(const char* name, ImageF3& image) const {
    oidnSetSharedFilterImage(filter, name, image.data(), kFloat3,
                             static_cast<size_t>(image.width()),
                             static_cast<size_t>(image.height()), 0, 0, 0);
  }
};

Denoiser::Denoiser(std::unique_ptr<State> state) : state_(std::move(state)) {}
Denoiser::~Denoiser() = default;

absl::StatusOr<std::unique_ptr<Denoiser>> Denoiser::Create(DenoiseQuality quality) {
  auto state = std::make_unique<State>();
  state->device = oidnNewDevice(kDeviceCpu);
  if (!state->device) {
    RETURN_IF_ERROR(TakeError(nullptr));
    return Internal("denoise: no CPU device");
  }
  // Threads stay where the system puts them: pinned ones would compete with other workers
  // here.
  oidnSetDeviceBool(state->device, "setAffinity", false);
  oidnCommitDevice(state->device);
  RETURN_IF_ERROR(TakeError(state->device));
  state->filter = oidnNewFilter(state->device, "RT");
  RETURN_IF_ERROR(TakeError(state->device));
  oidnSetFilterBool(state->filter, "hdr", true);
  oidnSetFilterBool(state->filter, "cleanAux", true);
  oidnSetFilterInt(state->filter, "quality", static_cast<int>(quality));
  RETURN_IF_ERROR(TakeError(state->device));
  return std::unique_ptr<Denoiser>(new Denoiser(std::move(state)));
}

absl::Status Denoiser::Execute(const CancelToken& cancel, const ImageF3& albedo,
                               const ImageF3& normal, ImageF3* color) {
  State& state = *state_;
  const bool resized =
      state.color.width() != color->width() || state.color.height() != color->height();
  if (resized) {
    state.color = ImageF3(color->width(), color->height());
    state.albedo = state.color;
    state.normal = state.color;
    state.Bind("color", state.color);
    state.Bind("albedo", state.albedo);
    state.Bind("normal", state.normal);
    state.Bind("output", state.color);
  }
  state.color.values() = color->values();
  state.albedo.values() = albedo.values();
  state.normal.values() = normal.values();
  CancelToken token = cancel;
  oidnSetFilterProgressMonitorFunction(state.filter, &KeepGoing, &token);
  oidnCommitFilter(state.filter);
  oidnExecuteFilter(state.filter);
  RETURN_IF_ERROR(TakeError(state.device));
  for (size_t i = 0; i < color->values().size(); ++i) {
    const float value = state.color.values()[i];
    color->values()[i] = std::isfinite(value) ? std::max(value, 0.0f) : 0.0f;
  }
  return absl::OkStatus();
}

}  // namespace parallax
