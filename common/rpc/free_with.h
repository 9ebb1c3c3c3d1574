// How a std::unique_ptr gives an object of a C library back.
#pragma once

namespace parallax {

// The deleter that calls `Free`: std::unique_ptr<BIO, FreeWith<BIO_free_all>>.
template <auto Free>
struct FreeWith {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};

}  // namespace parallax
