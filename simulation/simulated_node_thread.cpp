#include "musher/simulation/simulated_node_thread.hpp"

#include <mutex>
#include <utility>
#include <vector>

#include "musher/base/check.hpp"

namespace musher::simulation {
namespace {

// The loop of a simulated node, which is not thread-safe, with an inbox for other threads.
class LoopWithInbox : public transport::EventLoop {
 public:
  explicit LoopWithInbox(transport::EventLoop& loop)
      : loop_(loop), timer_(loop_.Every(SimulatedNodeThread::kInboxPeriod, [this] { Empty(); })) {}

  Time Now() const override { return loop_.Now(); }
  void Post(std::function<void()> work) override {
    const std::lock_guard lock(mutex_);
    inbox_.push_back(std::move(work));
  }
  transport::LoopHandlePtr At(Time when, std::function<void()> callback) override {
    return loop_.At(when, std::move(callback));
  }
  transport::LoopHandlePtr Every(Duration period, std::function<void()> callback) override {
    return loop_.Every(period, std::move(callback));
  }
  transport::LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override {
    return loop_.WhenReadable(fd, std::move(callback));
  }
  void Run() override { loop_.Run(); }
  bool RunUntil(const std::function<bool()>& done, Time deadline) override {
    return loop_.RunUntil(done, deadline);
  }
  void Stop() override { loop_.Stop(); }

 private:
  void Empty() {
    std::vector<std::function<void()>> due;
    {
      const std::lock_guard lock(mutex_);
      due.swap(inbox_);
    }
    for (const auto& work : due) work();
  }

  transport::EventLoop& loop_;
  std::mutex mutex_;  // guards the inbox
  std::vector<std::function<void()>> inbox_;
  transport::LoopHandlePtr timer_;
};

}  // namespace

class SimulatedNodeThread::ThreadSafeNode : public transport::Node {
 public:
  explicit ThreadSafeNode(std::unique_ptr<transport::Node> node)
      : node_(std::move(node)), loop_(node_->loop()) {}

  transport::EventLoop& loop() override { return loop_; }
  transport::ParticipantId participant() const override { return node_->participant(); }
  Result<std::unique_ptr<transport::RawWriter>> MakeRawWriter(
      const std::string& topic, const std::string& type, const transport::Qos& qos,
      transport::WriterCallbacks callbacks) override {
    return node_->MakeRawWriter(topic, type, qos, std::move(callbacks));
  }
  Result<std::unique_ptr<transport::RawReader>> MakeRawReader(
      const std::string& topic, const std::string& type, const transport::Qos& qos,
      transport::ReaderCallbacks callbacks) override {
    return node_->MakeRawReader(topic, type, qos, std::move(callbacks));
  }

 private:
  const std::unique_ptr<transport::Node> node_;
  LoopWithInbox loop_;
};

SimulatedNodeThread::SimulatedNodeThread(transport::sim::Network& network, std::string host)
    : network_(network),
      host_(std::move(host)),
      node_(std::make_unique<ThreadSafeNode>(network_.MakeNode(host_))) {}

SimulatedNodeThread::~SimulatedNodeThread() = default;

void SimulatedNodeThread::RunOnLoop(const std::function<void()>& work) {
  CheckCaller();
  work();
}

void SimulatedNodeThread::WaitFor(Duration time) {
  CheckCaller();
  network_.RunFor(time);
}

// On a robot such a call would wait for ever.
void SimulatedNodeThread::CheckCaller() const {
  MUSHER_CHECK(!network_.running(), "called on the loop itself, by a handler or a timer");
}

Result<std::unique_ptr<transport::Node>> SimulatedNodeThread::MakeNode(
    const std::string& /*name_space*/, const std::string& /*name*/) {
  return std::unique_ptr<transport::Node>(
      std::make_unique<ThreadSafeNode>(network_.MakeNode(host_)));
}

transport::Node& SimulatedNodeThread::node() {
  return *node_;
}

}  // namespace musher::simulation
