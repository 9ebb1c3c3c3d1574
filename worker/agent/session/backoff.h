// Exponential back-off with full jitter: the n-th wait is drawn from [0, min(cap, base * 2^n)), so
// that a thousand workers that lost one coordinator do not return in one wave. Source: "Exponential
// Backoff And Jitter", AWS Architecture Blog, 2015.
#pragma once

#include <algorithm>
#include <chrono>

#include "common/base/rng.h"

namespace parallax {

// Not thread-safe.
class Backoff {
 public:
  using Seconds = std::chrono::duration<double>;

  Backoff(Rng rng, Seconds base, Seconds cap) : rng_(rng), base_(base), cap_(cap), ceiling_(base) {}

  // Returns the next wait.
  Seconds Next() {
    const Seconds wait = ceiling_ * rng_.Uniform();
    ceiling_ = std::min(cap_, ceiling_ * 2);
    return wait;
  }
  // Starts again at the shortest wait.
  void Reset() { ceiling_ = base_; }

 private:
  Rng rng_;
  Seconds base_;
  Seconds cap_;
  Seconds ceiling_;
};

}  // namespace parallax
