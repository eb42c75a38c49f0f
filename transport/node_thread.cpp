#include "musher/transport/node_thread.hpp"

#include <future>

namespace musher::transport {

Result<std::shared_ptr<NodeThread>> NodeThread::Start(const DdsOptions& options) {
  std::shared_ptr<NodeThread> started(new NodeThread);
  auto node = MakeDdsNode(started->loop_, options);
  if (!node) return node.error();
  started->credentials_ = options.credentials;
  started->node_ = std::move(node).value();
  started->thread_ = std::thread([loop = &started->loop_] { loop->Run(); });
  return started;
}

NodeThread::~NodeThread() {
  loop_.Stop();
  if (thread_.joinable()) thread_.join();
}

void NodeThread::RunOnLoop(const std::function<void()>& work) {
  std::promise<void> done;
  loop_.Post([&] {
    work();
    done.set_value();
  });
  done.get_future().wait();
}

}  // namespace musher::transport
