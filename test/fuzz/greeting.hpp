#pragma once
// A machine for the fuzzers of recordings and snapshots: the first state machine of the guide.

#include "first_state_machine/greeter.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::fuzz {

struct Greeter {
  Greeter() : machine(MakeGreeter(robot)) {
    Require(machine->Build("IDLE").ok(), "the machine builds");
  }

  Result<> Apply(std::string_view name, std::string_view text) {
    if (name == "sees") robot.sees_person = text == "yes";
    if (name == "close") robot.person_is_too_close = text == "yes";
    return Ok();
  }

  Robot robot;
  std::unique_ptr<fsm::Machine> machine;
};

}  // namespace musher::fuzz
