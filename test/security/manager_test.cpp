// Which identity may call which services of CyberDog's manager, if it has keys.

#include "musher/test/security/secured_machine.hpp"

namespace musher::testing::manager_test {

using ::testing::HasSubstr;
using ::testing::Not;

class SecuredManager : public SecuredMachine {
 protected:
  SecuredManager() { std::ofstream(config_, std::ios::app) << "[policy]\nmanager = true\n"; }
};

TEST_F(SecuredManager, AnswersOperatorsAndKeepsActuatorsFromTheSwitch) {
  Identity("spy", "actuator");
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto spy = Peer(keys_, "spy",
                        {"trigger:poweroff", "publish:machine_state_switch", "trigger:bms_info",
                         "publish:state_switch_status", "publish:motion_status",
                         "subscribe:motion_status", "trigger:low_power_exit"});
  ASSERT_NE(spy->LineWith("ready"), "");
  ASSERT_NE(spy->LineWith("answered"), "") << "by low_power_exit, which wakes the machine";
  const auto app = Peer(keys_, "operator", {"trigger:machine_state_valget"});
  ASSERT_NE(app->LineWith("answered"), "");
  spy->Signal(SIGTERM);
  const std::string said = spy->Wait().out;
  for (const char* refused :
       {"trigger:poweroff", "publish:machine_state_switch", "publish:state_switch_status"}) {
    EXPECT_THAT(said, HasSubstr("refused " + std::string(refused) + ": spy may not do that: "));
  }
  EXPECT_THAT(said, Not(HasSubstr("refused publish:motion_status"))) << "modules' topics are free";
  EXPECT_THAT(said, HasSubstr("received motion_status"));
  EXPECT_THAT(said, Not(HasSubstr("refused trigger:low_power_exit")));
}

TEST_F(SecuredManager, DoesNotListenToAnActuatorThatDisregardsItsPermissions) {
  Identity("spy", "actuator");
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto spy = Liar(keys_, "spy", {"trigger:poweroff"});
  ASSERT_NE(spy->LineWith("machine LowPower"), "");
  ExpectTheMachineIsSound();
  spy->Signal(SIGTERM);
  EXPECT_THAT(spy->Wait().out, Not(HasSubstr("answered")));
}

}  // namespace musher::testing::manager_test
