#pragma once
// A node with its loop on a thread of its own, for programs that use their main thread otherwise.
// All actuators of a process may share one. In a fault-injection test the node is a simulated one
// (simulation/simulated_node_thread.hpp).
//
// Threads: any except the loop's; node() and its endpoints on the loop only, so use RunOnLoop().

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::transport {

class NodeThread {
 public:
  // On DDS.
  static Result<std::shared_ptr<NodeThread>> Start(const DdsOptions& options = {});
  // Everything made from the node must be dropped before. From any thread except the loop's.
  virtual ~NodeThread() = default;
  NodeThread(const NodeThread&) = delete;
  NodeThread& operator=(const NodeThread&) = delete;

  // Runs `work` on the loop and waits for it. From any thread except the loop's.
  virtual void RunOnLoop(const std::function<void()>& work) = 0;

  // Blocks the calling thread for so long of the loop's time, while the loop continues. From any
  // thread except the loop's.
  virtual void WaitFor(Duration time) = 0;

  // Another node of the same loop and participant, which ROS 2 lists by a name of its own: for an
  // actuator that shares this thread. From any thread but the loop's; it goes on the loop.
  virtual Result<std::unique_ptr<Node>> MakeNode(const std::string& name_space,
                                                 const std::string& name) = 0;

  // The node and its loop: on the loop only, except for EventLoop::Post().
  virtual Node& node() = 0;
  EventLoop& loop() { return node().loop(); }
  // nullopt: without [security].
  virtual const std::optional<Credentials>& credentials() const = 0;

 protected:
  NodeThread() = default;
};

}  // namespace musher::transport
