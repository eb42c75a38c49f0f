#pragma once
// An actuator that serves the action `fibonacci`.

#include "fibonacci_server.hpp"
#include "musher/actuator/machine_actuator.hpp"

class Desk : public musher::MachineActuator {
 public:
  Desk() : MachineActuator("desk") {
    RegisterStateCallback("SetUp", [this] {
      return OpenEndpoints([this](transport::Endpoints& topics) { server_.Open(topics); });
    });
    RegisterStateCallback([](const musher::State&) { return musher::Ok(); });  // all others
  }

 private:
  FibonacciServer server_;
};
