#include "musher/transport/dds/node_thread.hpp"

#include <future>

namespace musher::transport {

Result<std::shared_ptr<NodeThread>> NodeThread::Start(const DdsOptions& options) {
  std::shared_ptr<NodeThread> started(new NodeThread);
  auto node = MakeDdsNode(started->loop_, options);
  if (!node) return node.error();
  started->options_ = options;
  started->options_.domain_id = DomainId(options).value();  // the environment may change
  started->node_ = std::move(node).value();
  started->thread_ = std::thread([loop = &started->loop_] { loop->Run(); });
  return started;
}

NodeThread::~NodeThread() {
  loop_.Stop();
  if (thread_.joinable()) thread_.join();
}

Result<std::unique_ptr<Node>> NodeThread::MakeNode(const std::string& name_space,
                                                   const std::string& name) {
  DdsOptions options = options_;
  options.name_space = name_space;
  options.node_name = name;
  std::promise<Result<std::unique_ptr<Node>>> node;
  RunOnLoop([&] { node.set_value(MakeDdsNode(loop_, options)); });
  return node.get_future().get();
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
