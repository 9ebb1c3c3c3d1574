// A deleter of std::unique_ptr for objects of C libraries.
#pragma once

namespace parallax {

// Calls `Free`: std::unique_ptr<BIO, FreeWith<BIO_free_all>>.
template <auto Free>
struct FreeWith {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};

}  // namespace parallax
