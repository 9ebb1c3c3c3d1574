// Move-only owners of Embree's devices, scenes and geometries.
#pragma once

#include <embree3/rtcore.h>

#include <utility>

namespace parallax {

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

}  // namespace parallax
