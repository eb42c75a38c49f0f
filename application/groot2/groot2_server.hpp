#pragma once
// Serves a tree to Groot2 on TCP, by ZeroMQ: requests on a port, and on the next one a publisher of
// the breakpoints that are reached. Every program that reaches the port can read the tree and its
// blackboards; with ServeOptions::hooks it can also hold nodes and replace their results, and thus
// move the robot.
//
// The hooks of a client are removed once it has sent no request for ServeOptions::silence (the
// protocol has no end of a connection; Groot2 requests the status several times a second); one that
// connects again is another client. Where one of them was enabled, reached or
// not, ServeOptions::on_lost halts the tree. Hooks also end when another tree is loaded, and when
// the endpoints are closed. A tree that leaves Active is halted with its held nodes as always.
//
//   void OpenTopics(transport::Endpoints& topics) override {
//     auto served = groot2::Serve(topics, {.port = 1667, .on_lost = [this] { Halt(); }},
//                                 [this] { return view(); }, factory());
//     if (!served) Log(served.error());
//   }
//
// Threads: requests are received on a thread of the server. Each is replied to by a piece of work
// on the loop, between two handlers, so that a tick takes no lock and costs nothing more.

#include <functional>
#include <string>

#include "musher/application/tree_report.hpp"
#include "musher/base/result.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::groot2 {

struct ServeOptions {
  int port = 1667;                    // 1 to 65534
  std::string address = "127.0.0.1";  // of this host; "*": all
  bool hooks = false;                 // a client may hold and replace nodes
  Duration silence = std::chrono::seconds(5);
  // A client is lost that had an enabled hook: halt the tree, so that nothing moves because a
  // connection has ended. Called on the loop, after its hooks were removed. Null: a hook that holds
  // or replaces a node then stays, until any client removes it or releases the node.
  std::function<void()> on_lost{};
};

// The endpoints keep the server; what `view` and `factory` refer to must outlive them. Loop thread
// only. Fails when a port is taken.
Result<> Serve(transport::Endpoints& topics, const ServeOptions& options,
               std::function<TreeView()> view, const tree::Factory& factory);

}  // namespace musher::groot2
