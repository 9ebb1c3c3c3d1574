// A store of objects on an S3 server: AWS, MinIO, Ceph... libcurl signs the requests with SigV4;
// only this folder uses libcurl. s3_options.h has the URI and the environment.
//
// S3 promises that an object is there whole or not at all, and durable when Put returns. The server
// checks each object's SHA-256. Files larger than 64 MiB are sent in parts. Answers 429, 5xx and
// RequestTimeout and broken connections are retried after a growing pause.
#pragma once

#include <memory>

#include "common/store/s3_options.h"
#include "common/store/store.h"

namespace parallax {

// Opens the store and tries it at once by a small write, or by a listing with `store.read_only`, so
// that a wrong bucket or key is found here. Errors: those of that first call.
absl::StatusOr<std::unique_ptr<Store>> OpenS3Store(const S3Options& options,
                                                   const StoreOptions& store = {});

}  // namespace parallax
