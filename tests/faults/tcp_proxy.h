// A TCP proxy on loopback that does to connections what networks do: it stalls them, swallows one
// direction, cuts them, and - knowing enough of HTTP/2 to find a reply - loses single gRPC replies
// after the call has been done.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace parallax::faults {

enum class Weather {
  kClear,
  kStall,      // Nothing passes, nothing is lost: it comes later.
  kDeafUp,     // Swallows what clients send; replies pass (half-open).
  kDeafDown,   // The other way round.
  kPartition,  // New connections are refused and the old ones cut.
};

struct LossRates {
  double unary = 0;   // Share of replies that are lost; the caller is told that the stream broke.
  double stream = 0;  // Share of a server's stream messages that are lost; the stream breaks.
};

// Thread-safe. Its own threads; ends all connections when destroyed.
class TcpProxy {
 public:
  // Forwards to `target` ("127.0.0.1:PORT"), which may come and go.
  TcpProxy(const std::string& target, const LossRates& losses, uint64_t seed);
  ~TcpProxy();

  std::string address() const;
  void Set(Weather weather);
  void CutAll();  // Once, without a change of weather.

  struct Counts {
    int64_t replies = 0;  // Replies and messages that came by.
    int64_t lost = 0;     // And were lost.
    int64_t connections = 0;
    int64_t cut = 0;
  };
  Counts counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax::faults
