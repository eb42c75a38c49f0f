#pragma once
// A node of a simulated network whose loop reads sockets, too: once in a millisecond of virtual
// time. What another node of the same thread has sent by the loopback is there by then.

#include <poll.h>

#include <memory>
#include <string>
#include <utility>

#include "musher/transport/node.hpp"

namespace musher::transport {

class SocketLoop : public EventLoop {
 public:
  explicit SocketLoop(EventLoop& loop) : loop_(loop) {}

  Time Now() const override { return loop_.Now(); }
  void Post(std::function<void()> work) override { loop_.Post(std::move(work)); }
  LoopHandlePtr At(Time when, std::function<void()> callback) override {
    return loop_.At(when, std::move(callback));
  }
  LoopHandlePtr Every(Duration period, std::function<void()> callback) override {
    return loop_.Every(period, std::move(callback));
  }
  LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override {
    return loop_.Every(Milliseconds(1), [fd, callback = std::move(callback)] {
      pollfd readable{fd, POLLIN, 0};
      if (poll(&readable, 1, 0) > 0) callback();
    });
  }
  void Run() override { loop_.Run(); }
  bool RunUntil(const std::function<bool()>& done, Time deadline) override {
    return loop_.RunUntil(done, deadline);
  }
  void Stop() override { loop_.Stop(); }

 private:
  EventLoop& loop_;
};

class SocketNode : public Node {
 public:
  explicit SocketNode(std::unique_ptr<Node> node) : node_(std::move(node)), loop_(node_->loop()) {}

  EventLoop& loop() override { return loop_; }
  ParticipantId participant() const override { return node_->participant(); }
  Result<std::unique_ptr<RawWriter>> MakeRawWriter(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   WriterCallbacks callbacks) override {
    return node_->MakeRawWriter(topic, type, qos, std::move(callbacks));
  }
  Result<std::unique_ptr<RawReader>> MakeRawReader(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   ReaderCallbacks callbacks) override {
    return node_->MakeRawReader(topic, type, qos, std::move(callbacks));
  }

 private:
  std::unique_ptr<Node> node_;
  SocketLoop loop_;
};

}  // namespace musher::transport
