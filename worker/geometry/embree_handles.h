// Move-only owners of Embree's devices, scenes and geometries, and a constructor of its rays.
#pragma once

#include <embree3/rtcore.h>

#include <string>
#include <utility>

#include "common/math/types.h"

namespace parallax {

// Releases the handle when it is destroyed.
template <typename Handle, void (*release)(Handle)>
class EmbreeHandle {
 public:
  explicit EmbreeHandle(Handle handle = nullptr) : handle_(handle) {}
  ~EmbreeHandle() {
    if (handle_) release(handle_);
  }
  EmbreeHandle(EmbreeHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  EmbreeHandle& operator=(EmbreeHandle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  Handle get() const { return handle_; }

 private:
  Handle handle_;
};

using EmbreeDevice = EmbreeHandle<RTCDevice, rtcReleaseDevice>;
using EmbreeScene = EmbreeHandle<RTCScene, rtcReleaseScene>;
using EmbreeGeometry = EmbreeHandle<RTCGeometry, rtcReleaseGeometry>;

// Makes a device; `more` are further settings of Embree's ("threads=1"). Without a cache for
// subdivision surfaces, which no scene has: each device would hold 128 MB of address space for it,
// and where that can't be had Embree's lock of the cache stays locked.
inline EmbreeDevice MakeEmbreeDevice(const char* more = "") {
  return EmbreeDevice(rtcNewDevice((std::string("tessellation_cache_size=0,") + more).c_str()));
}

// Returns a ray over distances `near` to `far` along `direction`, with all mask bits set.
inline RTCRay MakeRay(const Vec3f& origin, const Vec3f& direction, float near, float far) {
  return {.org_x = origin.x(),
          .org_y = origin.y(),
          .org_z = origin.z(),
          .tnear = near,
          .dir_x = direction.x(),
          .dir_y = direction.y(),
          .dir_z = direction.z(),
          .time = 0,
          .tfar = far,
          .mask = ~0u,
          .id = 0,
          .flags = 0};
}

}  // namespace parallax
