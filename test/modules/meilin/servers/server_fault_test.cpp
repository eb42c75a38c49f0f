// The actuator of a server under injected faults: goals are accepted in Active only, and never
// during an emergency stop.

#include "musher/modules/meilin/servers/server_actuator.hpp"
#include "musher/simulation/actuator_fault_test.hpp"

namespace musher::meilin::servers::server_fault_test {

TEST(AServer, AcceptsGoalsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  simulation::ActuatorFaultTest<ServerActuator> test;
  test.make = [] { return std::make_unique<ServerActuator>("arm", ServerConfig{}); };
  int accepted = 0;
  test.always = [&accepted](const ServerActuator& server, const ActuatorReport& report) {
    if (server.permitted()) ++accepted;
    EXPECT_FALSE(server.permitted() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  test.after_emergency_stop = [](const ServerActuator& server, const ActuatorReport&) {
    EXPECT_FALSE(server.permitted());
  };
  test.Run();
  EXPECT_GT(accepted, 100) << "or nothing has been tried";
}

}  // namespace musher::meilin::servers::server_fault_test
