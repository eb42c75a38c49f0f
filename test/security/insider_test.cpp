// Insiders: an actuator of the machine, "spy", that exceeds its permissions. A modified plugin
// (lying_plugin.c) switches off the checks in its own process: here the other participants have to
// reject it.

#include "musher/test/security/secured_machine.hpp"

namespace musher::testing::insider_test {

using ::testing::HasSubstr;
using ::testing::Not;

class Insiders : public SecuredMachine {
 protected:
  static void AwaitItHasMetTheMachine(Process& liar) {
    ASSERT_NE(liar.LineWith("machine LowPower"), "");
    ASSERT_NE(liar.LineWith("heartbeat legs"), "");
  }
  static std::string EndOf(Process& liar) {
    liar.Signal(SIGTERM);
    return liar.Wait().out;
  }

  void SetUp() override {
    Identity("spy", "actuator");
    ASSERT_NO_FATAL_FAILURE(Start());
  }
};

TEST_F(Insiders, GetALocalErrorForWhatTheirPermissionsForbid) {
  const auto spy = Peer(keys_, "spy",
                        {"announce", "command:legs", "pose:legs:legs", "pose:spy:spy",
                         "publish:chat", "publish:musher/machine_status"});
  ASSERT_NE(spy->LineWith("ready"), "");
  const std::string said = EndOf(*spy);
  for (const char* refused :
       {"announce", "command:legs", "pose:legs:legs", "publish:musher/machine_status"}) {
    EXPECT_THAT(said, HasSubstr("refused " + std::string(refused) + ": spy may not do that: "));
  }
  EXPECT_THAT(said, Not(HasSubstr("refused pose:spy:spy")));
  EXPECT_THAT(said, Not(HasSubstr("refused publish:chat")));
}

TEST_F(Insiders, CannotAnnounceThemselvesAsControllerNorCommandAnActuator) {
  const auto spy =
      Liar(keys_, "spy", {"announce", "command:legs", "publish:musher/emergency_stop:x"});
  ASSERT_NO_FATAL_FAILURE(AwaitItHasMetTheMachine(*spy));
  ExpectTheMachineIsSound();
  const std::string said = EndOf(*spy);
  EXPECT_THAT(said, Not(HasSubstr("answered")));
  EXPECT_THAT(said, Not(HasSubstr("refused")));  // on its own side all was allowed
}

TEST_F(Insiders, CannotPublishTheStatusOfAnotherActuator) {
  const auto spy =
      Liar(keys_, "spy", {"pose:legs:legs", "pose:legs", "pose:legs:*", "pose:legs:spy"});
  ASSERT_NO_FATAL_FAILURE(AwaitItHasMetTheMachine(*spy));
  ExpectTheMachineIsSound();
  EXPECT_THAT(EndOf(*spy), Not(HasSubstr("refused")));
}

// The last action above is permitted as far as DDS goes: its own partition, another's name. So the
// machine must receive what the spy publishes under its own name, else the test above shows
// nothing.
TEST_F(Insiders, CanPublishUnderTheirOwnName) {
  const auto spy = Liar(keys_, "spy", {"publish:musher/actuator_status:spy"});
  const auto subscriber = Peer(keys_, "operator", {"subscribe:musher/actuator_status:*"});
  EXPECT_NE(subscriber->LineWith("received musher/actuator_status spy"), "");
}

TEST_F(Insiders, CannotReadCommandsToAnother) {
  const auto spy = Liar(keys_, "spy", {"subscribe:chat"});
  ASSERT_NO_FATAL_FAILURE(AwaitItHasMetTheMachine(*spy));
  const auto reader = Liar(keys_, "spy", {"serve:legs"});
  ASSERT_NO_FATAL_FAILURE(AwaitItHasMetTheMachine(*reader));
  ExpectTheMachineIsSound();
  const std::string said = EndOf(*reader);
  EXPECT_THAT(said, Not(HasSubstr("called")));
  EXPECT_THAT(said, Not(HasSubstr("refused")));
}

TEST_F(Insiders, AsObserversCannotStopOrSwitchTheMachine) {
  Identity("visitor", "observer");
  const auto visitor = Liar(keys_, "visitor", {"stop", "set:Active"});
  ASSERT_NE(visitor->LineWith("machine LowPower"), "");
  ExpectTheMachineIsSound();
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], false);
  EXPECT_THAT(EndOf(*visitor), Not(HasSubstr("answered")));
}

TEST_F(Insiders, AsOperatorsCallTheControllerAndCommandNoActuator) {
  const auto operating = Liar(keys_, "operator", {"command:legs", "announce"});
  ASSERT_NO_FATAL_FAILURE(AwaitItHasMetTheMachine(*operating));
  ExpectTheMachineIsSound();
  EXPECT_THAT(EndOf(*operating), Not(HasSubstr("answered")));
}

TEST_F(Insiders, AsActuatorsMayEngageTheEmergencyStop) {
  const auto spy = Peer(keys_, "spy", {"stop"});
  AwaitStatus([](const auto& status) { return status["emergency_stop"]["engaged"] == true; });
}

}  // namespace musher::testing::insider_test
