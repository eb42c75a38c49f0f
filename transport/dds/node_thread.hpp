#pragma once
// A DDS node with its loop on a thread of its own, for programs that use their main thread
// otherwise. All actuators of a process may share one.
//
// Threads: any except the loop's; node() and its endpoints on the loop only, so use RunOnLoop().

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport {

class NodeThread {
 public:
  static Result<std::shared_ptr<NodeThread>> Start(const DdsOptions& options = {});
  // Everything made from the node must be dropped before. From any thread except the loop's.
  ~NodeThread();
  NodeThread(const NodeThread&) = delete;
  NodeThread& operator=(const NodeThread&) = delete;

  // Runs `work` on the loop and waits for it. From any thread except the loop's.
  void RunOnLoop(const std::function<void()>& work);

  // Another node of the same loop and participant, which ROS 2 lists by a name of its own: for an
  // actuator that shares this thread. From any thread but the loop's; it goes on the loop.
  Result<std::unique_ptr<Node>> MakeNode(const std::string& name_space, const std::string& name);

  // The node and its loop: on the loop only, except for EventLoop::Post().
  Node& node() { return *node_; }
  EventLoop& loop() { return loop_; }
  const std::optional<Credentials>& credentials() const { return options_.credentials; }

 private:
  NodeThread() = default;

  DdsOptions options_;
  LinuxEventLoop loop_;
  std::unique_ptr<Node> node_;
  std::thread thread_;
};

}  // namespace musher::transport
