#pragma once
// A thread of real nodes on a computer that the test suspends.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::testing {

class SuspendedThread : public transport::NodeThread {
 public:
  void RunOnLoop(const std::function<void()>& work) override { real_->RunOnLoop(work); }
  void WaitFor(Duration time) override { real_->WaitFor(time); }
  Result<std::unique_ptr<transport::Node>> MakeNode(const std::string& name_space,
                                                    const std::string& name) override {
    auto made = real_->MakeNode(name_space, name);
    if (!made) return made.error();
    auto node = std::make_unique<SuspendedNode>(std::move(made).value());
    loop_ = &node->loop();
    return std::unique_ptr<transport::Node>(std::move(node));
  }
  transport::Node& node() override { return real_->node(); }
  const std::optional<transport::Credentials>& credentials() const override {
    return real_->credentials();
  }

  // Once; what runs and has run meanwhile is unchanged.
  void Suspend(Duration duration) {
    RunOnLoop([&] { loop_->suspended += duration; });
  }
  // For so long before each request that arrives.
  void SuspendEachTime(Duration duration) {
    RunOnLoop([&] { loop_->each_look = duration; });
  }

 private:
  const std::shared_ptr<transport::NodeThread> real_ = transport::NodeThread::Start().value();
  SuspendedLoop* loop_ = nullptr;
};

}  // namespace musher::testing
