// Accepts the connections of a server's addresses, and keeps the port open whatever strangers do.
//
// A connection is a stranger's until the server says by Know() that it knows the caller. Strangers
// have few places, and a newcomer gets one: if all are taken, the oldest stranger goes that is not
// being answered, of the newcomer's own address first, else of the address that has most. So who
// keeps still or never proves a name shuts nobody out, and who proves one is not disturbed. The
// number of all connections is bounded too, so that the process keeps descriptors for its files; if
// they run out all the same, the listener goes on as soon as there are some.
//
// The server owns the descriptors that it is given and closes them. The listener notices that by
// the inode of the socket, without any call of the server.
//
// Thread-safe.
#pragma once

#include <sys/types.h>

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/address.h"

namespace parallax {

// Bounds on the number of connections.
struct ListenerLimits {
  size_t known = 60'000;             // Connections of known callers.
  size_t known_an_address = 45'000;  // One peer address leaves room to others.
  size_t strangers = 256;
  size_t strangers_an_address = 128;
};

class Listener {
 public:
  // Takes over a connected socket, non-blocking and closed on exec. `address` is the index of the
  // address that it came to; `peer` names the other side as gRPC does: "ipv4:10.0.0.7:4711",
  // "ipv6:%5B::1%5D:4711", or "unix:" for all of them.
  using Take = std::function<void(int fd, size_t address, const std::string& peer)>;

  // Binds all addresses or none, and accepts nothing yet. Ports are not shared with other
  // processes; a Unix socket that another process serves is left alone, and only its owner may
  // connect to ours. Callers on Unix sockets are known from the start. Errors: kAlreadyExists for
  // an address in use; kPermissionDenied, kNotFound and others of the socket, each naming the
  // address.
  static absl::StatusOr<std::unique_ptr<Listener>> Bind(const std::vector<RpcAddress>& addresses,
                                                        const ListenerLimits& limits = {});
  ~Listener();  // Stops.
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // Returns the addresses of Bind, with the actual port in place of port 0.
  const std::vector<RpcAddress>& addresses() const { return addresses_; }

  // Begins to accept. Call it once. `take` is called by the listener's own thread.
  void Start(Take take);
  // Closes the addresses; `take` is not called any more when it returns. Idempotent.
  void Stop();

  // Says that the caller of this connection is known. Returns false, and ends the connection, if
  // too many known callers are connected already.
  bool Know(std::string_view peer);
  // Takes that back: the connection is a stranger's again, as young as a new one.
  void Forget(std::string_view peer);
  // Says whether a connection is being answered. Meanwhile it makes no room for a newcomer, even if
  // it is a stranger's.
  void SetBusy(std::string_view peer, bool busy);
  // Keeps a place for a connection of this process that is about to come from `peer`.
  void Expect(const std::string& peer);

 private:
  struct Socket;  // One listening socket.
  struct Connection;
  using Connections = std::list<Connection>;

  Listener(std::vector<RpcAddress> addresses, const ListenerLimits& limits);
  absl::Status BindAddress(size_t index);
  void Loop();
  void AcceptAll(const Socket& socket);
  // Admits the connection, or closes it.
  void Admit(int fd, size_t address);
  void RunOutOfDescriptors(const Socket& socket, int error_number);
  // ---- These require mu_.
  // Makes a place for a stranger from `host`; false if none exists.
  bool MakeRoom(const std::string& host);
  // Moves a stranger to those that are known; false if they are too many.
  bool AddKnown(Connections::iterator at);
  // Drops the connections that their owner has closed, except `but`.
  void DropEnded(const Connection* but);

  std::vector<RpcAddress> addresses_;
  const ListenerLimits limits_;
  std::vector<Socket> sockets_;
  Take take_;
  int wake_ = -1;   // Readable: the thread has to end.
  int spare_ = -1;  // Given up for a moment to refuse a connection when no descriptor is left.
  std::thread thread_;

  std::mutex mu_;
  // Guarded by mu_.
  Connections strangers_;  // The oldest first.
  Connections known_;
  std::unordered_map<std::string, Connections::iterator> by_peer_;
  std::set<std::string> expected_;
  size_t drop_at_ = 64;  // Number of connections at which the ended ones are looked for.
};

}  // namespace parallax
