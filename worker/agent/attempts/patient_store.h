// A store for jobs that outlives a restart of the coordinator: calls that a store can't answer now
// are repeated.
#pragma once

#include <functional>
#include <memory>

#include "common/base/cancel.h"
#include "common/store/store.h"

namespace parallax {

// Returns a store that repeats reads and puts of `store` while it can't be reached or is busy, and
// puts also while it is full, with pauses of up to 5 s. Reads end after ten minutes, puts only by
// `cancel`, because finished work must not be lost. Each call is tried once even after `cancel`.
// `alive` is called before each try, from the caller's thread. Removals and CheckMarker are not
// repeated. Returns `store` itself if it is null or a folder of this machine, whose errors do not
// pass. Thread-safe if `alive` is. Errors: those of `store`.
std::shared_ptr<Store> MakePatientStore(std::shared_ptr<Store> store, const CancelToken& cancel,
                                        std::function<void()> alive);

}  // namespace parallax
