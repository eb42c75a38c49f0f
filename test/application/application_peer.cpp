// An application in a process of its own that blocks or fails on command.

#include <unistd.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "musher/application/fsm_actuator.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher {
namespace {

class Work : public fsm::State {
 public:
  explicit Work(const std::string& order) : order_(order) {}

  void Declare(fsm::Transitions& transitions) override {
    transitions.To("WORK", "never");
    transitions.On("go");
  }
  void Run(const fsm::Tick&) override {
    if (order_ == "fail") throw std::runtime_error("the lamp is broken");
    while (order_ == "block") pause();
  }

 private:
  const std::string& order_;
};

class Peer : public FsmActuator {
 public:
  Peer() : FsmActuator("show", {.rate_hz = 100}) {}

 private:
  Result<> BuildMachine(fsm::Machine& machine) override {
    machine.AddEvent("go");
    machine.Add("WORK", std::make_unique<Work>(order_));
    return machine.Build("WORK");
  }
  void OpenTopics(transport::Endpoints& topics) override {
    topics.Subscribe<msg::String>("order",
                                  [this](const msg::String& order) { order_ = order.data; });
  }

  std::string order_;
};

}  // namespace
}  // namespace musher

int main() {
  musher::Peer peer;
  return peer.Run();
}
