// The requests of the dog's app to its manager, and the replies by CyberDog's tables.

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/test/cyberdog/managed_robot.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service_names.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::requests_test {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::uint8_t kActiveNumber = 0, kProtectNumber = 1, kLowPowerNumber = 2, kOtaNumber = 3,
                       kShutdownNumber = 4, kSelfCheckNumber = 5, kDeActiveNumber = 6,
                       kErrorNumber = 7;

class CyberdogRequests : public ManagedRobot {
 protected:
  void SwitchTo(std::uint8_t number) {
    if (!switch_) switch_ = PublishFunction<msg::UInt8>("machine_state_switch");
    Settle();
    switch_({number});
    Settle();
  }
  std::function<void(const msg::UInt8&)> switch_;
};

TEST_F(CyberdogRequests, TheStateHasItsTextInEveryState) {
  BringUp();
  const std::pair<BuiltInState, const char*> kTexts[] = {
      {kActive, "active"},     {kProtected, "protected"}, {kLowPower, "lowpower"},  {kOta, "ota"},
      {kDeActive, "deactive"}, {kError, "error-state"},   {kSelfCheck, "selfcheck"}};
  for (const auto& [state, text] : kTexts) {
    Take(state);
    const auto answer = Trigger("machine_state_valget");
    EXPECT_TRUE(answer.success);
    EXPECT_EQ(answer.message, text);
  }
}

TEST_F(CyberdogRequests, TheTopicSwitchesDirectlyToEveryStateThatHasANumber) {
  BringUp();
  const std::pair<std::uint8_t, const char*> kNumbers[] = {
      {kProtectNumber, "Protected"},  {kLowPowerNumber, "LowPower"}, {kOtaNumber, "OTA"},
      {kActiveNumber, "Active"},      {kDeActiveNumber, "DeActive"}, {kErrorNumber, "Error"},
      {kSelfCheckNumber, "SelfCheck"}};
  for (const auto& [number, target] : kNumbers) {
    SwitchTo(number);
    EXPECT_EQ(state(), target);
  }
  SwitchTo(kShutdownNumber);
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_FALSE(robot_.IsAlive("a"));
}

TEST_F(CyberdogRequests, ANumberThatMeansNothingIsRefusedWithACodeAndARecord) {
  BringUp();
  Records();
  SwitchTo(8);
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(Records(), HasSubstr("110 machine_state_switch: 8 is not the number of a state"));
  const auto answer = Keep(255, 10);
  EXPECT_FALSE(answer.success);
  EXPECT_EQ(answer.code, kCodeParametersInvalid);
  EXPECT_THAT(Records(),
              HasSubstr("110 machine_state_switch_keep: 255 is not the number of a state"));
  EXPECT_FALSE(robot_.machine().policy.keep);
}

TEST_F(CyberdogRequests, ADirectSwitchOutsideTheFlowIsRefusedWithACodeAndARecord) {
  BringUp();
  Take("Error");
  Records();
  SwitchTo(kLowPowerNumber);
  EXPECT_EQ(state(), "Error");
  EXPECT_THAT(Records(), HasSubstr("103 switch to LowPower refused: "));
}

// CyberDog's table of rules: where the robot is, what is wanted, what comes of it.
struct StateRequest {
  const char* from;
  std::uint8_t number;
  const char* to;  // empty: refused
};

class StateRequestFrom : public CyberdogRequests,
                         public ::testing::WithParamInterface<StateRequest> {};

TEST_P(StateRequestFrom, IsExecutedOrRefusedAsInTheTable) {
  const auto [from, number, to] = GetParam();
  const bool refused = std::string(to).empty();
  BringUp();
  Take(State(from));
  const auto answer = Keep(number);
  EXPECT_EQ(answer.success, !refused);
  EXPECT_EQ(answer.code, refused ? kCodeStateInvalid : kCodeOk);
  EXPECT_EQ(state(), refused ? from : to);
}

INSTANTIATE_TEST_SUITE_P(Table, StateRequestFrom,
                         ::testing::Values(StateRequest{"OTA", kActiveNumber, ""},
                                           StateRequest{"OTA", kProtectNumber, ""},
                                           StateRequest{"OTA", kLowPowerNumber, ""},
                                           StateRequest{"OTA", kOtaNumber, "OTA"},
                                           StateRequest{"OTA", kShutdownNumber, ""},
                                           StateRequest{"LowPower", kActiveNumber, "Active"},
                                           StateRequest{"LowPower", kProtectNumber, "Protected"},
                                           StateRequest{"LowPower", kLowPowerNumber, "LowPower"},
                                           StateRequest{"LowPower", kOtaNumber, "OTA"},
                                           StateRequest{"LowPower", kShutdownNumber, "TearDown"},
                                           StateRequest{"Active", kActiveNumber, "Active"},
                                           StateRequest{"Active", kProtectNumber, "Protected"},
                                           StateRequest{"Active", kLowPowerNumber, "LowPower"},
                                           StateRequest{"Active", kOtaNumber, "OTA"},
                                           StateRequest{"Active", kShutdownNumber, "TearDown"},
                                           StateRequest{"Protected", kActiveNumber, "Active"},
                                           StateRequest{"Protected", kLowPowerNumber, "LowPower"},
                                           StateRequest{"Protected", kOtaNumber, "OTA"}),
                         [](const auto& request) {
                           return std::string(request.param.from) + "To" +
                                  std::to_string(request.param.number);
                         });

class CyberdogBusy : public ManagedRobot {
 protected:
  CyberdogBusy()
      : ManagedRobot(ManagedMachine(), [](const std::string&, const State& state) {
          simulation::Act act;
          if (state == "DeActive") act.takes = Milliseconds(90);
          return act;
        }) {}
  // A switch that takes a while has just begun.
  void BeginSwitch() {
    robot_.leader()->shell().SetState("DeActive", std::nullopt, [](const SwitchResult&) {});
    ASSERT_TRUE(robot_.machine().current);
  }
};

TEST_F(CyberdogBusy, EverythingIsRefusedDuringASwitch) {
  BringUp();
  auto keep = transport::MakeClient<msg::MachineState>(*app_, "dog/machine_state_switch_keep");
  auto ota = transport::MakeClient<msg::SetBool>(*app_, "dog/ota_state_switch");
  auto wake = transport::MakeClient<msg::Trigger>(*app_, "dog/low_power_exit");
  Settle();
  int refused = 0;
  BeginSwitch();
  for (std::uint8_t number = kActiveNumber; number <= kShutdownNumber; ++number) {
    keep.value()->Call({number, 0}, std::chrono::seconds(5), [&](const auto& answer) {
      refused += !answer.value().success && answer.value().code == kCodeTargetBusy ? 1 : 0;
    });
  }
  ota.value()->Call({true}, std::chrono::seconds(5), [&](const auto& answer) {
    EXPECT_THAT(answer.value().message, HasSubstr("(111 Robot: TargetBusy)"));
    refused += answer.value().success ? 0 : 1;
  });
  wake.value()->Call({}, std::chrono::seconds(5),
                     [&](const auto& answer) { refused += answer.value().success ? 0 : 1; });
  robot_.RunFor(Milliseconds(50));
  EXPECT_EQ(refused, 7);
  Settle();
  EXPECT_EQ(state(), "DeActive");
}

TEST_F(CyberdogRequests, KeepingHoldsTheStateUntilItsTimeIsOver) {
  BringUp();
  auto answer = Keep(kProtectNumber, 60);
  EXPECT_TRUE(answer.success);
  EXPECT_EQ(answer.code, 0);
  EXPECT_EQ(state(), "Protected");
  answer = Keep(kActiveNumber, 30);  // kept already: understood, and not done
  EXPECT_TRUE(answer.success);
  EXPECT_EQ(answer.code, -1);
  EXPECT_EQ(state(), "Protected");
  EXPECT_FALSE(Trigger("poweroff").success);
  EXPECT_FALSE(SetBool("ota_state_switch", true).success);
  robot_.RunFor(std::chrono::seconds(60));
  EXPECT_TRUE(SetBool("ota_state_switch", true).success);
}

TEST_F(CyberdogRequests, KeepingIsCalledOffByAnyStateAndZeroSeconds) {
  BringUp();
  ASSERT_TRUE(Keep(kProtectNumber, 60).success);
  const auto answer = Keep(99, 0);
  EXPECT_TRUE(answer.success);
  EXPECT_EQ(answer.code, 0);
  EXPECT_EQ(state(), "Protected") << "which stays";
  EXPECT_FALSE(robot_.machine().policy.keep);
}

TEST_F(CyberdogRequests, OtaIsEnteredAndLeftByItsOwnSwitch) {
  BringUp();
  EXPECT_TRUE(SetBool("ota_state_switch", true).success);
  EXPECT_EQ(state(), "OTA");
  EXPECT_TRUE(SetBool("ota_state_switch", true).success) << "it is there";
  EXPECT_TRUE(SetBool("ota_state_switch", false).success);
  EXPECT_EQ(state(), "Active");
  const auto again = SetBool("ota_state_switch", false);
  EXPECT_FALSE(again.success);
  EXPECT_THAT(again.message, HasSubstr("not in OTA"));
}

TEST_F(CyberdogRequests, LowPowerHasASwitchAndAWayOut) {
  BringUp();
  EXPECT_EQ(Trigger("low_power_switch_state"), (msg::Trigger::Response{false, "off"}));
  EXPECT_TRUE(SetBool("low_power_enable", true).success);
  EXPECT_EQ(Trigger("low_power_switch_state"), (msg::Trigger::Response{true, "on"}));
  EXPECT_TRUE(SetBool("low_power_onoff", false).success);
  EXPECT_EQ(Trigger("low_power_switch_state"), (msg::Trigger::Response{false, "off"}));
  const auto early = Trigger("low_power_exit");
  EXPECT_FALSE(early.success);
  EXPECT_THAT(early.message, HasSubstr("(103 Robot: StateInvalid)"));
  Take("LowPower");
  EXPECT_TRUE(Trigger("low_power_exit").success);
  EXPECT_EQ(state(), "Active");
}

TEST_F(CyberdogRequests, TheWakeWordWakesItFromLowPowerAsFarAsTheBatteryAllows) {
  BringUp();
  const auto wake = PublishFunction<msg::Bool>("dog_wakeup");
  Settle();
  SetBattery(80);
  Records();
  wake({true});
  Settle();
  EXPECT_THAT(Records(), Not(HasSubstr("wake"))) << "it is awake";
  Take("LowPower");
  wake({false});  // the word counts, not what the sample says
  Settle();
  EXPECT_EQ(state(), "Active");
  SetBattery(4);
  EXPECT_EQ(state(), "LowPower");
  wake({true});
  Settle();
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(Records(), HasSubstr("refused"));
}

TEST_F(CyberdogRequests, PowerOffAnswersAtOnceAndTearsDownAfterTwoSeconds) {
  BringUp();
  EXPECT_TRUE(Trigger("poweroff").success);
  robot_.RunFor(Milliseconds(1000));
  EXPECT_TRUE(robot_.IsAlive("a"));
  robot_.RunFor(std::chrono::seconds(6));
  EXPECT_FALSE(robot_.IsAlive("a"));
  EXPECT_THAT(Records(), HasSubstr("no command is configured"));
}

class RequestsOfALateApp : public ManagedRobot {
 protected:
  static MachineConfig PoweredOffAtOnce() {
    MachineConfig config = ManagedMachine();
    config.policy->power.delay = {};
    return config;
  }
  RequestsOfALateApp() : ManagedRobot(PoweredOffAtOnce()) {}
};

// On a busy host the reader of a reply is discovered after the request, and the machine is stopped
// sooner: the app got no answer.
TEST_F(RequestsOfALateApp, AreAnsweredAlsoWhereTheMachineIsStoppedBefore) {
  using transport::kDefaultQos;
  BringUp();
  const std::string type(msg::Trigger::kTypeName);
  const auto requests = app_->MakeRawWriter(transport::RequestTopic("dog/poweroff"),
                                            transport::RequestType(type), kDefaultQos, {});
  ASSERT_TRUE(robot_.RunUntil([&] { return requests.value()->MatchedReaders() == 1; }));
  ASSERT_TRUE(requests.value()->Write(
      transport::internal::EncodeEnvelope(msg::RequestId{1, 1}, msg::Trigger::Request{})));
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kStopped; }));
  robot_.RunFor(Milliseconds(1000));
  int replies = 0;
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = [&](std::span<const std::byte>, const transport::SampleInfo&) {
    ++replies;
  };
  const auto reader =
      app_->MakeRawReader(transport::ReplyTopic("dog/poweroff"), transport::ResponseType(type),
                          kDefaultQos, std::move(callbacks));
  robot_.RunFor(Milliseconds(1000));
  EXPECT_EQ(replies, 1);
}

TEST_F(CyberdogRequests, RebootIsAnotherWayToTheSameEnd) {
  BringUp();
  EXPECT_TRUE(Trigger("reboot").success);
  const auto off = Trigger("poweroff");
  EXPECT_FALSE(off.success);
  EXPECT_THAT(off.message, HasSubstr("about to reboot"));
  robot_.RunFor(std::chrono::seconds(7));
  EXPECT_FALSE(robot_.IsAlive("a"));
}

TEST_F(CyberdogRequests, PowerOffIsRefusedInOta) {
  BringUp();
  Take("OTA");
  for (const char* name : {"poweroff", "reboot"}) {
    const auto answer = Trigger(name);
    EXPECT_FALSE(answer.success);
    EXPECT_THAT(answer.message, HasSubstr("OTA"));
  }
  robot_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(state(), "OTA");
}

// Another robot of the same image in reach, whose device manager is `app_`: each request of its
// power key, its touch pad and its wake word arrives here, too, and names no machine.
class CyberdogRequestsOfAnotherRobot : public CyberdogRequests {
 protected:
  void PublishStatus(const std::string& machine) {
    ActuatorReport report;
    report.state = State(kActive);
    report.incarnation = Incarnation(99);
    report.pid = 4711;
    report.host = "another host";
    msg::ActuatorStatus status = transport::ToMessage("device_manager", report);
    status.machine = machine;
    status.participant = app_->participant().value();
    if (!statuses_) {
      statuses_ = transport::MakePublisher<msg::ActuatorStatus>(
                      *app_, transport::ActuatorStatusTopic("dog"), transport::kLatchedQos)
                      .value();
    }
    ASSERT_TRUE(statuses_->Publish(status));
    Settle();
  }
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> statuses_;
};

TEST_F(CyberdogRequestsOfAnotherRobot, DoNotPowerThisOneOff) {
  BringUp();
  PublishStatus("another dog");
  Records();
  for (const char* name : {"poweroff", "reboot"}) {
    const auto answer = Trigger(name);
    EXPECT_FALSE(answer.success);
    EXPECT_THAT(answer.message, HasRefusal(Refusal::kRequestOfOtherMachine));
  }
  SwitchTo(kShutdownNumber);
  EXPECT_FALSE(Keep(kLowPowerNumber).success);
  robot_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(Records(), HasSubstr("another dog"));
}

TEST_F(CyberdogRequestsOfAnotherRobot, DoNotWakeThisOne) {
  BringUp();
  const auto wake = PublishFunction<msg::Bool>("dog_wakeup");
  PublishStatus("another dog");
  Take("LowPower");
  EXPECT_FALSE(Trigger("low_power_exit").success);
  wake({true});
  Settle();
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(CyberdogRequestsOfAnotherRobot, AreThoseOfThisOneOnceItsActuatorIs) {
  BringUp();
  PublishStatus("another dog");
  PublishStatus(robot_.identity().name);
  Take("LowPower");
  EXPECT_TRUE(Trigger("low_power_exit").success);
}

// They waited in the kernel while the manager was stopped: who made them has long gone.
class CyberdogRequestsThatWaited : public CyberdogRequests {
 protected:
  void WhileStopped(const std::function<void()>& request) {
    Settle();  // who requests has discovered the manager
    robot_.FreezeController();
    request();
    robot_.RunFor(std::chrono::seconds(9));
    robot_.ThawController();
    Settle();
  }
  template <msg::Service S>
  std::unique_ptr<transport::Client<S>> Client(const std::string& name) {
    return transport::MakeClient<S>(*app_, "dog/" + name).value();
  }
};

TEST_F(CyberdogRequestsThatWaited, LeadOutOfNothing) {
  BringUp();
  const auto wake_word = PublishFunction<msg::Bool>("dog_wakeup");
  const auto switch_topic = PublishFunction<msg::UInt8>("machine_state_switch");
  const auto wake = Client<msg::Trigger>("low_power_exit");
  const auto ota = Client<msg::SetBool>("ota_state_switch");
  const auto keep = Client<msg::MachineState>("machine_state_switch_keep");
  Take("LowPower");
  std::optional<msg::Trigger::Response> left;
  std::optional<msg::SetBool::Response> entered;
  std::optional<msg::MachineState::Response> kept;
  Records();
  WhileStopped([&] {
    const Duration minute = std::chrono::minutes(1);
    wake->Call({}, minute, [&left](const auto& reply) { left = reply.value(); });
    ota->Call({true}, minute, [&entered](const auto& reply) { entered = reply.value(); });
    keep->Call({kProtectNumber, 60}, minute, [&kept](const auto& reply) { kept = reply.value(); });
    wake_word({true});
    switch_topic({kActiveNumber});
  });
  ASSERT_TRUE(left && entered && kept);
  EXPECT_FALSE(left->success);
  EXPECT_THAT(left->message, HasRefusal(Refusal::kMayBeLate));
  EXPECT_FALSE(entered->success);
  EXPECT_THAT(entered->message, HasRefusal(Refusal::kMayBeLate));
  EXPECT_FALSE(kept->success);
  EXPECT_EQ(kept->code, FormOf(Refusal::kMayBeLate).code);
  EXPECT_EQ(state(), "LowPower");
  const std::string records = Records();
  EXPECT_THAT(records, HasRefusal(Refusal::kMayBeLate));
  for (const char* what :
       {"wake-up", "OTA entry", "keep in Protected for 60 s", "switch to Active"}) {
    EXPECT_THAT(records, HasSubstr(std::string(what) + " refused: this controller could not run"));
  }
  robot_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(state(), "LowPower");
  EXPECT_TRUE(Trigger("low_power_exit").success) << "it is a new one";
  EXPECT_EQ(state(), "Active");
}

TEST_F(CyberdogRequestsThatWaited, StillLowerIt) {
  BringUp();
  const auto switch_topic = PublishFunction<msg::UInt8>("machine_state_switch");
  WhileStopped([&] { switch_topic({kLowPowerNumber}); });
  EXPECT_TRUE(robot_.RunUntil([&] { return state() == "LowPower"; }, std::chrono::seconds(5)));
}

TEST_F(CyberdogRequestsThatWaited, StillCallOffKeeping) {
  BringUp();
  const auto keep = Client<msg::MachineState>("machine_state_switch_keep");
  ASSERT_TRUE(Keep(kProtectNumber, 600).success);
  std::optional<msg::MachineState::Response> called_off;
  WhileStopped([&] {
    keep->Call({kProtectNumber, 0}, std::chrono::minutes(1),
               [&called_off](const auto& reply) { called_off = reply.value(); });
  });
  ASSERT_TRUE(called_off);
  EXPECT_TRUE(called_off->success);
  EXPECT_FALSE(robot_.machine().policy.keep);
}

TEST_F(CyberdogRequests, NoServiceIsOfferedWithoutAManagerInTheConfig) {
  MachineConfig config = ManagedMachine();
  config.policy->manager = false;
  simulation::SimRobot robot(1, config);
  const auto app = robot.network().MakeNode("app");
  auto client = transport::MakeClient<msg::Trigger>(*app, "dog/poweroff").value();
  robot.StartController();
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_FALSE(client->Ready());
}

}  // namespace musher::testing::requests_test
