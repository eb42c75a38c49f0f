#pragma once
// A loop and a node that pass everything on to another one; what derives from them changes a part.

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "musher/transport/node.hpp"

namespace musher::testing {

class WrappedLoop : public transport::EventLoop {
 public:
  explicit WrappedLoop(transport::EventLoop& loop) : loop_(loop) {}

  Time Now() const override { return loop_.Now(); }
  void Post(std::function<void()> work) override { loop_.Post(std::move(work)); }
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
  transport::EventLoop& loop_;
};

class WrappedNode : public transport::Node {
 public:
  explicit WrappedNode(std::unique_ptr<transport::Node> node) : node_(std::move(node)) {}

  transport::EventLoop& loop() override { return node_->loop(); }
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
  transport::Node& simulated() { return *node_; }

 private:
  const std::unique_ptr<transport::Node> node_;
};

}  // namespace musher::testing
