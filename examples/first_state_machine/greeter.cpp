// [listener]
// Runs the greeter for ten simulated seconds, as fast as possible. `greeter --dot | dot -Tsvg >
// greeter.svg` draws its state machine.

#include "greeter.hpp"

#include <iostream>
#include <string_view>

#include "musher/behavior/fsm/graph.hpp"

class Printer : public fsm::Listener {
 public:
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    std::cout << musher::ToMilliseconds(change.at) << " ms: " << machine.Name(change.from) << " -> "
              << machine.Name(change.to) << ", " << fsm::Name(change.cause) << "\n";
  }
};
// [listener end]

// [main]
int main(int argc, char** argv) {
  Robot robot;
  const auto machine = MakeGreeter(robot);
  if (const musher::Result<> built = machine->Build("IDLE"); !built) {
    std::cerr << built.error().message << "\n";
    return 1;
  }
  for (const std::string& warning : machine->warnings()) std::cerr << warning << "\n";
  if (argc > 1 && std::string_view(argv[1]) == "--dot") {
    std::cout << fsm::ToDot(machine->chart());
    return 0;
  }

  Printer printer;
  machine->Listen(&printer);
  musher::Time now{};
  if (!machine->Start(now)) return 1;
  while (machine->time() < std::chrono::seconds(10)) {
    robot.sees_person =
        machine->time() > std::chrono::seconds(1) && machine->time() < std::chrono::seconds(3);
    robot.person_is_too_close =
        machine->time() > std::chrono::seconds(7) && machine->time() < std::chrono::seconds(8);
    machine->RunOnce(now += std::chrono::milliseconds(20));
  }
  machine->Forget(&printer);
}
// [main end]
