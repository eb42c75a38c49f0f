#pragma once
// Serves a tree to Groot2 on TCP, by ZeroMQ: requests on a port, and a publisher of breakpoints,
// which has none, on the next one. Every program that reaches the port can read the tree and its
// blackboards, and nothing else.
//
//   void OpenTopics(transport::Endpoints& topics) override {
//     auto served = groot2::Serve(topics, {.port = 1667}, [this] { return view(); }, factory());
//     if (!served) Log(served.error());
//   }
//
// Threads: requests are received on a thread of the server. Each is replied to by a piece of work
// on the loop, between two handlers, so that a tick takes no lock and costs nothing more.

#include <functional>
#include <string>

#include "musher/application/groot2/groot2_reply.hpp"
#include "musher/base/result.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::groot2 {

struct ServeOptions {
  int port = 1667;                    // 1 to 65534
  std::string address = "127.0.0.1";  // of this host; "*": all
};

// The endpoints keep the server; what `view` and `factory` refer to must outlive them. Loop thread
// only. Fails when a port is taken.
Result<> Serve(transport::Endpoints& topics, const ServeOptions& options,
               std::function<TreeView()> view, const tree::Factory& factory);

}  // namespace musher::groot2
