// The page of `parallax preview --page`: the sheet, which the browser loads anew after each save.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"

namespace parallax::client {

// The page's words.
struct PreviewState {
  bool making = false;
  std::string text;   // "made at 12:03:04 in 6.1 s"
  std::string error;  // Lines; empty: none.
};

// Thread-safe.
class PreviewPage {
 public:
  // Serves the page of `file` on `listen` ("127.0.0.1:0": any free port) until the object is
  // destroyed. Only those who know link() see it: a port of this machine is open to all of its
  // users. Errors: kInvalidArgument for an address that other machines reach, or that is none;
  // those of WebServer::Bind.
  static absl::StatusOr<std::unique_ptr<PreviewPage>> Start(const std::string& listen,
                                                            const std::string& file);
  virtual ~PreviewPage() = default;

  virtual std::string link() const = 0;  // "http://127.0.0.1:PORT/SECRET/"
  virtual void Tell(PreviewState state) = 0;
  virtual void Show(std::string sheet_png) = 0;
};

}  // namespace parallax::client
