// Which actuators have latched an emergency stop, from the statuses of actuators and controller.

#include "musher/controller/client/stop_latch.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <list>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli::stop_latch_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// An actuator as far as emergency stops go.
class Listener {
 public:
  Listener(transport::Node& node, std::string name) {
    status_.name = std::move(name);
    publisher_ = transport::MakePublisher<msg::ActuatorStatus>(
                     node, transport::ActuatorStatusTopic("pack"), transport::kLatchedQos)
                     .value();
    static_cast<void>(publisher_->Publish(status_));
    stops_ = transport::MakeSubscription<msg::EmergencyStop>(
                 node, transport::EmergencyStopTopic("pack"),
                 [this](const msg::EmergencyStop& stop, const transport::SampleInfo&) {
                   const bool meant = SameMachine({status_.machine, status_.machine_id},
                                                  {stop.machine, stop.machine_id});
                   if (meant && stop.engaged && !deaf_) Latch(stop.id);
                 },
                 transport::kLatchedFromManyQos)
                 .value();
  }

  void BelongTo(std::string machine, std::string id = "", std::string host = "") {
    status_.machine = std::move(machine);
    status_.machine_id = std::move(id);
    status_.host = std::move(host);
    static_cast<void>(publisher_->Publish(status_));
  }
  void Latch(std::uint64_t id) {
    if (status_.emergency_stop == 0) {
      status_.emergency_stop = id;
    } else if (status_.emergency_stop != id) {
      status_.other_stops.push_back(id);
    }
    static_cast<void>(publisher_->Publish(status_));
  }
  bool stopped() const { return status_.emergency_stop != 0; }
  void TurnDeaf() { deaf_ = true; }
  // It latches nothing from now on.
  void EndAfterTearDown() {
    deaf_ = true;
    status_.state = "TearDown";
    static_cast<void>(publisher_->Publish(status_));
  }
  // What it does at a stop fails, or has not ended; empty: it is done.
  void Report(const std::string& trouble) {
    status_.stop_trouble = trouble;
    static_cast<void>(publisher_->Publish(status_));
  }

 private:
  bool deaf_ = false;
  msg::ActuatorStatus status_;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> publisher_;
  std::unique_ptr<transport::Subscription> stops_;
};

class Stop : public ::testing::Test {
 protected:
  void Engage() {
    latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke"}).value();
  }
  EstopReport AfterASecond(const std::optional<msg::MachineStatus>& controller = {}) {
    network_.RunFor(std::chrono::seconds(1));
    return latch_->Report(controller);
  }
  // A controller that has both actuators and has taken the stop.
  static msg::MachineStatus Controller() {
    msg::MachineStatus status = RobotStatus();
    for (msg::ActuatorInfo& actuator : status.actuators) {
      actuator.presence = "present";
      actuator.health = "well";
    }
    status.emergency_stop = true;
    status.emergency_stop_by = "alice@desk";
    status.emergency_stop_reason = "smoke";
    status.stop_ids = {"0000000000000007"};
    return status;
  }

  transport::sim::Network network_{1};
  const std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  const std::unique_ptr<transport::Node> dog_ = network_.MakeNode("dog");
  std::optional<Listener> eyes_{std::in_place, *dog_, "eyes"};
  std::optional<Listener> legs_{std::in_place, *dog_, "legs"};
  std::unique_ptr<StopLatch> latch_;
};

TEST_F(Stop, ReachesAllActuatorsWithoutAController) {
  Engage();
  const EstopReport report = AfterASecond();
  EXPECT_TRUE(report.complete());
  EXPECT_FALSE(report.controller);
  EXPECT_FALSE(report.earlier);
  ASSERT_EQ(report.actuators.size(), 2U);
  EXPECT_TRUE(report.actuators[0].stopped && report.actuators[1].stopped);
  EXPECT_GT(report.actuators[0].after, Duration::zero());
  EXPECT_THAT(EstopText(report, false),
              HasSubstr("2 actuators are stopped; no controller leads here: `musher up FILE`"));
}

TEST_F(Stop, ReachesAnActuatorThatStartsLater) {
  legs_.reset();
  Engage();
  EXPECT_EQ(AfterASecond().actuators.size(), 1U);
  legs_.emplace(*dog_, "legs");
  const EstopReport report = AfterASecond();
  EXPECT_EQ(report.actuators.size(), 2U);
  EXPECT_TRUE(report.complete());
}

// The simulation found it: its host was rebooted, and the new process was switched on before it had
// received the stop.
TEST_F(Stop, IsNotConfirmedByTheStatusOfAnActuatorFromBeforeItsHostWasRebooted) {
  const auto listed_in = [](const std::string& boot) {
    msg::MachineStatus status = Controller();
    for (msg::ActuatorInfo& actuator : status.actuators) {
      if (actuator.name == "legs") actuator.host = boot;
    }
    return status;
  };
  legs_->BelongTo("", "", "boot 1");
  Engage();
  ASSERT_TRUE(AfterASecond(listed_in("boot 1")).complete());
  const EstopReport report = AfterASecond(listed_in("boot 2"));
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.Missing(), ElementsAre("legs"));
  legs_->BelongTo("", "", "boot 2");
  EXPECT_TRUE(AfterASecond(listed_in("boot 2")).complete());
}

// Two processes run as legs. The last status that arrived spoke for both.
TEST_F(Stop, IsNotConfirmedByOneOfTwoProcessesOfAnActuator) {
  legs_->BelongTo("", "", "boot 1");
  const auto cat = network_.MakeNode("cat");
  std::optional<Listener> second{std::in_place, *cat, "legs"};
  second->TurnDeaf();
  second->BelongTo("", "", "boot 2");
  Engage();
  EXPECT_FALSE(AfterASecond().complete());
  legs_->Report("");  // it publishes its status once more
  const EstopReport report = AfterASecond();
  EXPECT_THAT(report.Missing(), ElementsAre("legs"));
  EXPECT_THAT(EstopText(report, false), HasSubstr("several processes run as it"));
  second->Latch(7);
  EXPECT_TRUE(AfterASecond().complete());
}

TEST_F(Stop, IsConfirmedOnceTheProcessOfAnActuatorThatIsNotStoppedHasEnded) {
  legs_->BelongTo("", "", "boot 1");
  const auto cat = network_.MakeNode("cat");
  std::optional<Listener> second{std::in_place, *cat, "legs"};
  second->TurnDeaf();
  second->BelongTo("", "", "boot 2");
  Engage();
  EXPECT_FALSE(AfterASecond().complete());
  second.reset();
  EXPECT_TRUE(AfterASecond().complete());
}

TEST_F(Stop, NamesThoseThatDoNotLatchIt) {
  eyes_->TurnDeaf();
  Engage();
  const EstopReport report = AfterASecond(Controller());
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.Missing(), ElementsAre("eyes"));
  EXPECT_THAT(EstopText(report, false), HasSubstr("eyes  stop not confirmed\n"));
  EXPECT_EQ(EstopError(report), "stop not confirmed: eyes");
}

// "stopped after 3 ms" was said of an actuator whose stop function had thrown, or still waited.
TEST_F(Stop, IsNotConfirmedByAnActuatorThatHasLatchedItAndNotDoneIt) {
  eyes_->Report("on_emergency_stop has not ended");
  Engage();
  const EstopReport report = AfterASecond(Controller());
  EXPECT_THAT(report.Missing(), ElementsAre("eyes"));
  EXPECT_FALSE(report.settled());
  EXPECT_THAT(EstopText(report, false), HasSubstr("eyes  on_emergency_stop has not ended\n"));
  eyes_->Report("");
  EXPECT_TRUE(AfterASecond(Controller()).complete());
}

TEST_F(Stop, IsNotCompleteWithoutAnActuatorThatOnlyTheControllerLists) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators[0].presence = "lost";
  controller.actuators[0].health = "hung";
  const EstopReport report = AfterASecond(controller);
  EXPECT_THAT(report.Missing(), ElementsAre("legs"));
  EXPECT_THAT(EstopText(report, false), HasSubstr("legs  hung\n"));
}

// A regression: beside a controller that had just started, a stop that had reached no actuator yet
// counted as confirmed by all.
TEST_F(Stop, IsNotCompleteWithoutAnActuatorThatANewControllerHasNotTakenControlOfYet) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators[0].presence = "starting";
  const EstopReport report = AfterASecond(controller);
  EXPECT_THAT(report.Missing(), ElementsAre("legs"));
  EXPECT_FALSE(report.complete());
}

// What a person on the robot has who types `musher estop`: no controller answers, and nothing in
// the environment names a profile.
StopView OnTheRobot(MachineHere machine) {
  StopView view;
  view.running_here = {"eyes", "legs"};
  view.machines = {std::move(machine)};
  return view;
}

TEST_F(Stop, IsNotCompleteWithoutALostActuatorThatIsNotKnownToHaveEnded) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  msg::ActuatorInfo& legs = controller.actuators[0];
  legs.presence = "lost";
  legs.pid = 4711;
  EXPECT_THAT(AfterASecond(controller).Missing(), ElementsAre("legs"));
  legs.pid = 0;
  legs.state = "DeActive";
  EXPECT_THAT(AfterASecond(controller).Missing(), IsEmpty()) << "its process has ended";
}

// `musher estop` ended with exit code 0 beside a motor that a crashed process had left on.
TEST_F(Stop, IsNotCompleteBesideAnActuatorWhoseProcessHasEndedWhileItWasOn) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  msg::ActuatorInfo& legs = controller.actuators[0];
  legs.presence = "lost";
  legs.pid = 0;
  for (const char* state : {"Active", "Protected", "Dancing"}) {
    legs.state = state;
    const EstopReport report = AfterASecond(controller);
    EXPECT_FALSE(report.complete());
    EXPECT_TRUE(report.settled()) << "it latches nothing, however long it is awaited";
    EXPECT_THAT(EstopText(report, false),
                HasSubstr("legs  its process has ended, and what it had switched on may be on: it "
                          "was in " +
                          std::string(state)));
  }
  legs.restarting = true;
  EXPECT_FALSE(AfterASecond(controller).settled()) << "its successor latches the stop";
  for (const char* state : {"Uninitialized", "SetUp", "SelfCheck", "LowPower", "TearDown"}) {
    legs.state = state;
    EXPECT_TRUE(AfterASecond(controller).complete()) << state;
  }
}

TEST_F(Stop, IsNotCompleteBesideAnActuatorThatWasLostOnAndIsNotStarted) {
  const MachineConfig config = RobotConfig();
  Machine machine = MakeMachine(config);
  KnownActuator& known = machine.actuators[*config.IndexOf("legs")];
  known.presence = Presence::kAbsent;
  known.lost_in = State("Active");
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  const msg::MachineStatus status = ToMessage(config, machine);
  controller.actuators[0] = status.actuators[(*config.IndexOf("legs")).value()];
  ASSERT_EQ(controller.actuators[0].name, "legs");
  EXPECT_FALSE(AfterASecond(controller).complete());
}

// Without a controller the state folder says so.
TEST_F(Stop, WithoutAControllerIsNotCompleteBesideAnActuatorThatIsStoredAsLost) {
  legs_.reset();
  Engage();
  AfterASecond();
  MachineHere machine{{"robot", ""}, false, {}, {"legs", "eyes"}};
  machine.lost = {{"legs", StaysDown::kNo, State("Active")}};
  StopView view = OnTheRobot(machine);
  view.running_here = {"eyes"};
  EXPECT_THAT(latch_->Report(view).Missing(), ElementsAre("legs"));
  EXPECT_TRUE(latch_->Report(view).settled());
  view.machines[0].lost[0].lost_in = State();
  EXPECT_THAT(EstopText(latch_->Report(view), false),
              HasSubstr("legs  its process has ended without a controller"));
  view.machines[0].lost[0].lost_in = State("LowPower");
  EXPECT_TRUE(latch_->Report(view).complete());
}

TEST_F(Stop, IsNotCompleteWithoutAnActuatorThatIsStoredAsRunningOnAnotherHost) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  msg::ActuatorInfo& legs = controller.actuators[0];
  legs.presence = "absent";
  legs.pid = 0;
  legs.host = "";
  EXPECT_THAT(AfterASecond(controller).Missing(), IsEmpty()) << "it was never there";
  legs.host = "boot/4026531836";
  EXPECT_THAT(AfterASecond(controller).Missing(), ElementsAre("legs"));
}

TEST_F(Stop, OfAMachineOfOneHostIsCompleteWithTheActuatorsOfItsConfigThatRunHere) {
  Engage();
  AfterASecond();
  const MachineHere machine{{"robot", ""}, false, {}, {"legs", "eyes", "arm"}};
  EXPECT_TRUE(latch_->Report(OnTheRobot(machine)).complete()) << "arm does not run";
}

TEST_F(Stop, OfAMachineOfTheProfileLanNamesTheActuatorsThatMayRunOnOtherHosts) {
  Engage();
  AfterASecond();
  const MachineHere machine{{"robot", ""}, true, {}, {"legs", "eyes", "arm"}};
  const EstopReport report = latch_->Report(OnTheRobot(machine));
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.Missing(), ElementsAre("arm"));
  EXPECT_THAT(EstopText(report, false),
              HasSubstr("arm   not found here, it may run on another host\n"));
  EXPECT_THAT(EstopError(report), HasSubstr("stop not confirmed: arm; no controller answers, so "
                                            "the actuators of other hosts are not known"));
}

TEST_F(Stop, OfAMachineOfTheProfileLanIsNotCompleteThoughAllOfItsConfigHaveStopped) {
  Engage();
  AfterASecond();
  const MachineHere machine{{"robot", ""}, true, {}, {"legs", "eyes"}};
  const EstopReport report = latch_->Report(OnTheRobot(machine));
  EXPECT_THAT(report.Missing(), IsEmpty());
  EXPECT_FALSE(report.complete()) << "its config may have been changed since the start";
}

// By what the last controller has stored, whatever the profile.
TEST_F(Stop, NamesAnActuatorThatIsStoredAsRunningOnAnotherHostWithoutAController) {
  Engage();
  AfterASecond();
  const MachineHere machine{{"robot", ""}, false, {}, {"legs", "eyes", "arm"}, {"arm"}};
  EXPECT_THAT(latch_->Report(OnTheRobot(machine)).Missing(), ElementsAre("arm"));
  EXPECT_TRUE(latch_->Report(OnTheRobot(machine)).found());
}

TEST_F(Stop, FindsNothingWhereOnlyFilesOfAMachineAreLeft) {
  eyes_.reset();
  legs_.reset();
  Engage();
  AfterASecond();
  StopView view = OnTheRobot({{"robot", ""}, true, {}, {"legs", "eyes"}});
  view.running_here.clear();
  EXPECT_FALSE(latch_->Report(view).found());
  EXPECT_FALSE(latch_->Report(view).complete());
}

TEST_F(Stop, DoesNotTakeTheFilesOfAnotherMachineForItsOwn) {
  Engage();
  legs_->BelongTo("dog");
  eyes_->BelongTo("dog");
  AfterASecond();
  StopView view = OnTheRobot({{"dog", ""}, false, {}, {"legs", "eyes"}});
  view.machines.push_back({{"cat", ""}, true, {}, {"tail"}, {"tail"}});
  EXPECT_TRUE(latch_->Report(view).complete());
}

TEST_F(Stop, IsNotHeldUpByOldFilesOfALanMachineOfWhichNothingRuns) {
  Engage();
  AfterASecond();
  StopView view = OnTheRobot({{"robot", ""}, false, {}, {"legs", "eyes"}});
  view.machines.push_back({{"old", ""}, true, {}, {"arm"}, {"arm"}});
  EXPECT_TRUE(latch_->Report(view).complete());
}

// By the config in the working directory the machine had no other hosts: the stop was reported as
// complete, while its actuators there moved.
TEST_F(Stop, IsNotCompleteWhereTheProcessesOfAnActuatorMayNotBeRead) {
  Engage();
  AfterASecond();
  StopView view = OnTheRobot({{"robot", ""}, false, {}, {"legs", "eyes"}});
  ASSERT_TRUE(latch_->Report(view).complete());
  MachineHere hidden{{}, true, {}, {"legs"}};
  hidden.unread = "legs runs as a process of another user";
  view.machines.push_back(hidden);
  const EstopReport report = latch_->Report(view);
  EXPECT_FALSE(report.complete());
  EXPECT_EQ(report.unknown,
            "no controller answers, and legs runs as a process of another user, so the machine may "
            "have actuators on other hosts");
  view.controller = Controller();
  view.controller->host = HostId();
  EXPECT_TRUE(latch_->Report(view).complete()) << "the controller knows its actuators";
}

// It may be of another machine, which is in range.
TEST_F(Stop, IsNotCompleteByAControllerOfAnotherHostWithoutWhatRunsHere) {
  Engage();
  StopView view = OnTheRobot({{"robot", ""}, false, {}, {"legs", "eyes", "arm"}});
  view.running_here.push_back("arm");
  AfterASecond();
  view.controller = Controller();
  view.controller->host = "another";
  EXPECT_THAT(latch_->Report(view).Missing(), ElementsAre("arm"));
}

// The config of its controller has them no longer: the stop was complete beside one that hung.
TEST_F(Stop, IsNotCompleteWithoutAProcessOfThisHostThatTheControllerDoesNotList) {
  msg::EmergencyStop stop{7, true, "alice@desk", "smoke"};
  stop.machine = "robot";
  latch_ = StopLatch::Begin(*desk_, "pack", stop).value();
  StopView view = OnTheRobot({{"robot", ""}, false, {}, {"legs", "eyes"}});
  view.running_here.push_back("arm");
  AfterASecond();
  view.controller = Controller();
  view.controller->host = HostId();
  EXPECT_THAT(latch_->Report(view).Missing(), ElementsAre("arm"));
  EXPECT_FALSE(latch_->Report(view).settled());
  Listener arm(*dog_, "arm");
  arm.BelongTo("another", "", "another host");
  AfterASecond();
  EXPECT_THAT(latch_->Report(view).Missing(), ElementsAre("arm")) << "one of another host";
  arm.BelongTo("another", "", HostId());
  AfterASecond();
  EXPECT_TRUE(latch_->Report(view).complete()) << "it answers as an actuator of another machine";
}

TEST_F(Stop, IsNotCompleteBesideALostActuatorThatTheControllerDoesNotList) {
  Engage();
  AfterASecond();
  StopView view = OnTheRobot({{"robot", ""}, false, {}, {"legs", "eyes"}});
  view.controller = Controller();
  view.controller->host = HostId();
  view.machines[0].lost = {{"arm", StaysDown::kNo, State("Active")},
                           {"legs", StaysDown::kNo, State("Active")}};
  const EstopReport report = latch_->Report(view);
  EXPECT_THAT(report.Missing(), ElementsAre("arm")) << "the controller knows of the other one";
  EXPECT_TRUE(report.settled()) << "it latches nothing, however long it is awaited";
  view.machines[0].lost[0].lost_in = State("LowPower");
  EXPECT_TRUE(latch_->Report(view).complete());
}

TEST_F(Stop, IsNotCompleteWhereTheConfigOfAnActuatorIsNotKnown) {
  Engage();
  AfterASecond();
  const EstopReport report = latch_->Report(OnTheRobot({{"robot", ""}, false, {}, {"legs"}}));
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.unknown, HasSubstr("no config of a machine with eyes is found on this host"));
}

// A regression: of two robots with actuators of the same names the last status of a name counted,
// so the stop was confirmed while one of them moved.
TEST_F(Stop, ThatDoesNotNameItsMachineIsNotConfirmedBesideASecondMachine) {
  Engage();
  legs_->BelongTo("dog");
  eyes_->BelongTo("dog");
  AfterASecond();
  EXPECT_TRUE(latch_->Report(StopView{}).complete());
  Listener others(*dog_, "legs");
  others.BelongTo("cat");
  network_.RunFor(std::chrono::seconds(1));
  const EstopReport report = latch_->Report(StopView{});
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.unknown, HasSubstr("several machines have received the stop (dog, cat); "
                                        "`musher estop --machine NAME` stops one of them"));
}

// It advised to stop one of them by the name that both have.
TEST_F(Stop, OfTwoMachinesOfOneNameIsConfirmedByAnIdAlone) {
  Engage();
  legs_->BelongTo("dog", "5982c7ee-dog");
  eyes_->BelongTo("dog", "5984a000-dog");
  AfterASecond();
  EXPECT_THAT(latch_->Report(StopView{}).unknown,
              AllOf(HasSubstr("dog (id 5982c7ee)"), HasSubstr("`musher estop --machine ID`")));
}

// A command line that ended before left the robot with "voice had latched it" for a reason.
TEST_F(Stop, IsNotSettledBeforeAControllerThatReceivedItFromAnActuatorReceivesItsOrigin) {
  Engage();
  msg::MachineStatus controller = Controller();
  controller.emergency_stop_by = "";
  controller.emergency_stop_reason = "eyes had latched it";
  EXPECT_FALSE(AfterASecond(controller).settled());
  EXPECT_TRUE(AfterASecond(Controller()).settled());
}

TEST_F(Stop, IsSettledThoughTheOriginOfAnEarlierStopIsUnknown) {
  eyes_->Latch(3);
  Engage();
  msg::MachineStatus controller = Controller();
  controller.emergency_stop_by = "";
  controller.stop_ids = {"0000000000000003", "0000000000000007"};
  EXPECT_TRUE(AfterASecond(controller).settled());
}

// The command ended with success while its stop was lost on the way: the release of the earlier one
// let the machine go.
TEST_F(Stop, BesideAnEarlierOneIsNotConfirmedBeforeItHasArrivedItself) {
  for (auto* one : {&*legs_, &*eyes_}) {
    one->Latch(3);
    one->TurnDeaf();
  }
  Engage();
  EXPECT_FALSE(AfterASecond().settled());
  msg::MachineStatus controller = Controller();
  controller.emergency_stop_by = "bob@dog";
  controller.stop_ids = {"0000000000000003"};
  const EstopReport report = AfterASecond(controller);
  EXPECT_THAT(report.Missing(), IsEmpty());
  EXPECT_FALSE(report.settled());
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(EstopError(report), HasSubstr("only an earlier one holds the machine"));
  controller.stop_ids.emplace_back("0000000000000007");
  EXPECT_TRUE(AfterASecond(controller).settled());
  EXPECT_TRUE(AfterASecond(controller).complete());
}

// The earlier stop was released just before, and the newer status of an actuator was late: it was
// reported as stopped before, and could move.
TEST_F(Stop, IsNotConfirmedByAnActuatorOfWhichOnlyAReleasedStopIsKnown) {
  legs_->Latch(3);
  legs_->TurnDeaf();
  Engage();
  EXPECT_THAT(AfterASecond(Controller()).Missing(), ElementsAre("legs"));
  EXPECT_FALSE(AfterASecond(Controller()).settled());
  EXPECT_THAT(EstopText(AfterASecond(Controller()), false),
              HasSubstr("only an earlier stop of it is known"));
  legs_->Latch(7);
  EXPECT_TRUE(AfterASecond(Controller()).complete());
}

// A person types it twice: the controller keeps the newer one. The first command waited in vain and
// ended with an empty sentence.
TEST_F(Stop, ThatANewerOneOfTheSamePersonHasReplacedIsConfirmedByItsActuators) {
  Engage();
  msg::MachineStatus controller = Controller();
  controller.stop_ids = {"0000000000000009"};
  for (auto* one : {&*legs_, &*eyes_}) one->Latch(9);
  EXPECT_TRUE(AfterASecond(controller).complete());
}

// The simulation found it: they had ended, and nothing had the stop when it was confirmed.
TEST_F(Stop, BesideAnEarlierOneIsNotConfirmedByActuatorsThatTheControllerHasLost) {
  Engage();
  msg::MachineStatus controller = Controller();
  controller.stop_ids = {"0000000000000009"};
  for (auto* one : {&*legs_, &*eyes_}) one->Latch(9);
  ASSERT_TRUE(AfterASecond(controller).complete());
  for (msg::ActuatorInfo& actuator : controller.actuators) {
    actuator.presence = "lost";
    actuator.health = "crashed";
  }
  EXPECT_FALSE(AfterASecond(controller).complete());
}

TEST_F(Stop, IsNotConfirmedBesideAControllerWithoutActuatorsThatDoesNotListIt) {
  legs_.reset();
  eyes_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators.clear();
  controller.stop_ids = {"0000000000000003"};
  EXPECT_FALSE(AfterASecond(controller).complete());
  EXPECT_NE(EstopError(AfterASecond(controller)), "");
}

TEST_F(Stop, WithoutAControllerIsConfirmedByActuatorsThatLatchItBesideAnEarlierOne) {
  for (auto* one : {&*legs_, &*eyes_}) one->Latch(3);
  Engage();
  EXPECT_TRUE(AfterASecond().complete());
}

TEST_F(Stop, NamesAnActuatorWhoseProtocolHasNoStopAndDoesNotWaitForIt) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators[0].protocol = "cyberdog";
  const EstopReport report = AfterASecond(controller);
  EXPECT_TRUE(report.settled());
  EXPECT_FALSE(report.complete()) << "it may move";
  EXPECT_THAT(EstopText(report, false),
              HasSubstr("legs  emergency stop not supported (cyberdog)\n"));
}

TEST_F(Stop, DoesNotWaitForACrashedActuator) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators[0].presence = "lost";
  controller.actuators[0].health = "crashed";
  controller.actuators[0].pid = 0;  // its process is known to have ended
  EXPECT_TRUE(AfterASecond(controller).settled());
}

// A frozen process of another host is as silent as one that has exited, and may go on.
TEST_F(Stop, IsNotCompleteBesideAnActuatorWhoseExitIsNotKnown) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  controller.actuators[0].presence = "lost";
  controller.actuators[0].health = "crashed";
  controller.actuators[0].pid = 4321;
  const EstopReport report = AfterASecond(controller);
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(report.Missing(), ElementsAre("legs"));
  EXPECT_THAT(EstopText(report, false), HasSubstr("its exit is not known: it may still run"));
}

// It was torn down alone, and its process runs on for another actuator: no stop was confirmed.
TEST_F(Stop, DoesNotWaitForAnActuatorThatIsTornDown) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  msg::ActuatorInfo& legs = controller.actuators[0];
  legs.presence = "lost";
  legs.health = "crashed";
  legs.pid = 4321;
  legs.state = "TearDown";
  legs.target = "";
  EXPECT_TRUE(AfterASecond(controller).complete());
  legs.target = "Active";
  EXPECT_FALSE(AfterASecond(controller).complete());
  legs.target = "";
  legs.presence = "starting";
  EXPECT_FALSE(AfterASecond(controller).complete()) << "it is its successor";
}

TEST_F(Stop, DoesNotWaitForTheStatusThatATearDownHasLeftBehind) {
  legs_->EndAfterTearDown();
  Engage();
  EXPECT_TRUE(AfterASecond().complete());
  legs_->Report("its command is under way");
  EXPECT_FALSE(AfterASecond().complete());
}

// It would be forgotten by the next start of the machine.
TEST_F(Stop, IsNotConfirmedByTornDownActuatorsAlone) {
  legs_->EndAfterTearDown();
  eyes_->EndAfterTearDown();
  Engage();
  EXPECT_FALSE(AfterASecond().found());
}

// Its program is missing, and it is not started again.
TEST_F(Stop, DoesNotWaitForAnActuatorOfTheControllersHostThatHasEnded) {
  legs_.reset();
  Engage();
  msg::MachineStatus controller = Controller();
  msg::ActuatorInfo& legs = controller.actuators[0];
  legs.presence = "absent";
  legs.health = "crashed";
  legs.pid = 0;
  legs.host = controller.host;
  EXPECT_TRUE(AfterASecond(controller).complete());
  legs.host = "another";
  EXPECT_FALSE(AfterASecond(controller).complete());
}

TEST_F(Stop, ForgetsALostActuator) {
  legs_->TurnDeaf();
  Engage();
  EXPECT_THAT(AfterASecond().Missing(), ElementsAre("legs"));
  legs_.reset();
  EXPECT_TRUE(AfterASecond().complete());
}

TEST_F(Stop, IsNotCompleteBeforeTheControllerHasTakenIt) {
  Engage();
  msg::MachineStatus controller = Controller();
  controller.emergency_stop = false;
  const EstopReport report = AfterASecond(controller);
  EXPECT_THAT(report.Missing(), IsEmpty());
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(EstopError(report), HasSubstr("the controller has not latched the stop"));
}

TEST_F(Stop, ReportsTheOriginOfAnEarlierStop) {
  legs_->Latch(3);
  Engage();
  EstopReport report = AfterASecond();
  ASSERT_TRUE(report.earlier);
  EXPECT_THAT(EstopText(report, false), HasSubstr("an emergency stop was already engaged\n"));
  msg::MachineStatus controller = Controller();
  controller.emergency_stop_by = "bob@dog";
  controller.emergency_stop_reason = "a child";
  report = AfterASecond(controller);
  EXPECT_EQ(EstopText(report, false),
            "an emergency stop was already engaged by bob@dog: a child\n"
            "legs  stopped before\n"
            "eyes  stopped after " +
                std::to_string(ToMilliseconds(report.actuators[1].after)) +
                " ms\n"
                "2 actuators are stopped; no upward switch until `musher estop --release`\n");
}

TEST_F(Stop, IsPrintedAsJson) {
  legs_->Latch(3);
  eyes_.reset();
  Engage();
  EXPECT_EQ(EstopJson(AfterASecond(Controller())),
            R"({"engaged":true,"by":"alice@desk","reason":"smoke","complete":false,)"
            R"("controller":true,"earlier":{"by":"alice@desk","reason":"smoke"},"actuators":{)"
            R"("legs":{"stopped":true,"before":true,"after_ms":0.0,"trouble":null},)"
            R"("eyes":{"stopped":false,"before":false,"after_ms":null,"trouble":null}},)"
            R"("machines":[]})");
}

// With two robots in range a person did not know which one had stopped.
TEST_F(Stop, WithoutAControllerNamesTheMachinesThatHaveReceivedIt) {
  legs_->BelongTo("dog", "5982c7ee-dog");
  eyes_->BelongTo("dog", "5982c7ee-dog");
  Engage();
  EXPECT_THAT(EstopText(AfterASecond(), false),
              HasSubstr("emergency stop engaged by alice@desk: smoke\n"
                        "machine: dog (id 5982c7ee)\n"));
  Listener tail(*dog_, "tail");
  tail.BelongTo("cat");
  const EstopReport report = AfterASecond();
  EXPECT_THAT(EstopText(report, false), HasSubstr("machines: dog (id 5982c7ee), cat\n"));
  EXPECT_THAT(EstopJson(report),
              HasSubstr(R"("machines":[{"machine":"dog","machine_id":"5982c7ee-dog"},)"
                        R"({"machine":"cat","machine_id":null}])"));
}

// `musher estop --machine 5982`: it named a machine 5982, and reached none.
class StopById : public Stop {
 protected:
  void EngageFor(const std::string& word) {
    eyes_->BelongTo("dog", "5982c7ee-dog");
    legs_->BelongTo("cat", "5984a000-cat");
    latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke", word, ""}).value();
    latch_->AddBeginningOfId(word);
  }
  std::vector<std::string> Stopped() {
    std::vector<std::string> stopped;
    for (const EstopReport::Actuator& one : AfterASecond().actuators) {
      if (one.stopped) stopped.push_back(one.name);
    }
    return stopped;
  }
};

TEST_F(StopById, ReachesTheMachineWhoseIdBeginsSoAlone) {
  EngageFor("5982");
  EXPECT_THAT(Stopped(), ElementsAre("eyes"));
  EXPECT_TRUE(latch_->Report(StopView{}).complete());
}

TEST_F(StopById, ReachesThatMachineWhenItComesIntoRange) {
  EngageFor("5990");
  EXPECT_THAT(Stopped(), IsEmpty());
  Listener head(*dog_, "head");
  head.BelongTo("fox", "5990ffff-fox");
  EXPECT_THAT(Stopped(), ElementsAre("head"));
}

TEST_F(StopById, StopsEachMachineWhoseIdBeginsSoAndNamesThem) {
  EngageFor("5982");
  legs_->BelongTo("cat", "5982a000-cat");
  EXPECT_THAT(Stopped(), ElementsAre("eyes", "legs"));
  EXPECT_THAT(latch_->Report(StopView{}).unknown,
              HasSubstr("several machines have received the stop (dog (id 5982c7ee), cat (id "
                        "5982a000))"));
}

TEST_F(StopById, ReachesAKnownMachineBeforeAnythingOfItIsReceived) {
  std::vector<std::string> ids;
  const auto stops = transport::MakeSubscription<msg::EmergencyStop>(
                         *dog_, transport::EmergencyStopTopic("pack"),
                         [&ids](const msg::EmergencyStop& stop, const transport::SampleInfo&) {
                           ids.push_back(stop.machine_id);
                         },
                         transport::kLatchedFromManyQos)
                         .value();
  latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke", "5982", ""}).value();
  latch_->AddBeginningOfId("5982", {{"dog", "5982c7ee-dog"}});
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(ids, ElementsAre("", "5982c7ee-dog", "5982c7ee-dog"))
      << "by the writer that is matched already, and by the one that stays";
}

TEST_F(StopById, NeedsFourCharactersOfAnIdAndStopsAMachineOfThatName) {
  EngageFor("598");
  EXPECT_THAT(Stopped(), IsEmpty());
  Listener head(*dog_, "head");
  head.BelongTo("598", "1111");
  EXPECT_THAT(Stopped(), ElementsAre("head"));
}

// It stopped each robot of the name for a minute, also the robot of the next test.
class StopByName : public Stop {
 protected:
  StopByName() {
    eyes_.reset();
    legs_.reset();
  }
  void EngageFor(const std::string& id, StopOptions options = {}) {
    latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke", "dog", id},
                              std::move(options))
                 .value();
  }
  // Whether a robot of that name which is there from now on is stopped.
  bool Stops(const std::string& id, const std::string& host) {
    Listener& legs = robots_.emplace_back(*dog_, "legs of " + id + host);
    legs.BelongTo("dog", id, host);
    network_.RunFor(Milliseconds(500));
    return legs.stopped();
  }
  void Pass(Duration time) { network_.RunFor(time); }
  void EndRobots() { robots_.clear(); }

  std::list<Listener> robots_;
};

TEST_F(StopByName, ReachesARobotThatAppearsWhileNoneWasFound) {
  EngageFor("");
  Pass(std::chrono::seconds(50));
  EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
}

TEST_F(StopByName, ReachesEachRobotThatIsFoundInTimeAndNoLaterOne) {
  EngageFor("");
  EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
  EXPECT_TRUE(Stops("5984a000-dog", "another boot/1"));
  Pass(std::chrono::seconds(1));
  EXPECT_FALSE(Stops("77770000-dog", "third boot/1"));
  EXPECT_THAT(latch_->Report(StopView{}).unknown, Not(HasSubstr("77770000")));
  EXPECT_EQ(latch_->Report(StopView{}).actuators.size(), 2U);
}

TEST_F(StopByName, WaitsLongerForTheRobotsOfOtherHosts) {
  EngageFor("", {false, /*lan=*/true, {}, {}});
  EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
  Pass(std::chrono::seconds(8));
  EXPECT_TRUE(Stops("5984a000-dog", "another boot/1"));
  Pass(std::chrono::seconds(2));
  EXPECT_FALSE(Stops("77770000-dog", "third boot/1"));
}

TEST_F(StopByName, ReachesTheRobotThatWasFoundAlsoAfterItsRestart) {
  EngageFor("");
  EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
  EndRobots();
  Pass(std::chrono::seconds(50));
  EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/2"));
}

// It was started from another state folder: it has another id, and it is the same body.
TEST_F(StopByName, ReachesARobotOfTheNameOnTheHostOfAFoundRobot) {
  for (const std::string id : {"", "5982c7ee-dog"}) {
    EngageFor(id);
    EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
    EndRobots();
    Pass(std::chrono::seconds(50));
    EXPECT_TRUE(Stops("5984a000-dog", "one boot/1")) << id;
    EXPECT_FALSE(Stops("77770000-dog", "third boot/1")) << id;
    EndRobots();
  }
}

TEST_F(StopByName, ReachesEveryRobotOfTheNameWhereThereAreTooManyToAddress) {
  EngageFor("");
  for (int i = 0; i < 9; ++i) {
    robots_.emplace_back(*dog_, "legs " + std::to_string(i)).BelongTo("dog", std::to_string(i));
  }
  Pass(std::chrono::seconds(5));
  for (const Listener& robot : robots_) EXPECT_TRUE(robot.stopped());
  EXPECT_TRUE(Stops("77770000-dog", "third boot/1"));
}

// Notes of a latch, as its publisher's process gets them.
class ContinuedStop : public StopByName {
 protected:
  // From the process of a publisher, which writes them.
  static DetachedPublisher::Notes NotesTo(const std::function<void(DetachedPublisher&)>& program) {
    int ends[2];
    EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
    UniqueFd read_end(ends[0]);
    UniqueFd write_end(ends[1]);
    {
      DetachedPublisher publisher([&](const DetachedPublisher::Notes& notes) {
        for (const std::string& note : notes) {
          const auto size = static_cast<std::uint16_t>(note.size());
          [[maybe_unused]] auto written = write(write_end.get(), &size, sizeof size);
          written = write(write_end.get(), note.data(), note.size());
        }
        [[maybe_unused]] const auto written = write(write_end.get(), "\0\0", 2);
        return true;
      });
      program(publisher);
    }
    write_end = {};
    DetachedPublisher::Notes notes;
    for (std::uint16_t size = 0; read(read_end.get(), &size, sizeof size) == sizeof size;) {
      if (size == 0) return notes;
      std::string note(size, '\0');
      EXPECT_EQ(read(read_end.get(), note.data(), size), size);
      notes.push_back(note);
    }
    notes.emplace_back("it did not publish");
    return notes;
  }
};

TEST_F(ContinuedStop, GoesToTheRobotsThatItsProgramFoundAndNotByTheirName) {
  EngageFor("");
  const auto notes = NotesTo([&](DetachedPublisher& publisher) {
    latch_->ContinueWith(publisher);
    EXPECT_TRUE(Stops("5982c7ee-dog", "one boot/1"));
    Pass(std::chrono::seconds(2));
    latch_ = nullptr;
    EndRobots();
  });
  ASSERT_EQ(notes.size(), 1U);
  EngageFor("", {false, false, {}, notes});
  EXPECT_FALSE(Stops("77770000-dog", "third boot/1"));
  EXPECT_TRUE(Stops("5982c7ee-dog", "two boot/1"));
  EXPECT_TRUE(Stops("5984a000-dog", "one boot/1"));
}

TEST_F(ContinuedStop, GoesByTheNameWhereItsProgramHasFoundNoneOrEndedBeforeTheTimeForOthers) {
  for (const bool finds : {false, true}) {
    EngageFor("");
    const auto notes = NotesTo([&](DetachedPublisher& publisher) {
      latch_->ContinueWith(publisher);
      EXPECT_TRUE(!finds || Stops("5982c7ee-dog", "one boot/1"));
      latch_ = nullptr;
      EndRobots();
    });
    EXPECT_THAT(notes, IsEmpty());
    EngageFor("", {false, false, {}, notes});
    EXPECT_TRUE(Stops("77770000-dog", "third boot/1"));
    EndRobots();
  }
}

// It ended, where the network could not be joined in that moment.
TEST_F(ContinuedStop, IsPublishedByTheNextProcessWhereOneCannot) {
  const TempFolder folder;
  const std::string lost = folder / "lost";
  std::ofstream(lost) << "";
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  const UniqueFd read_end(ends[0]);
  UniqueFd write_end(ends[1]);
  DetachedPublisher publisher([&](const DetachedPublisher::Notes&) {
    return unlink(lost.c_str()) != 0 && write(write_end.get(), "x", 1) == 1;
  });
  publisher.Begin();
  write_end = {};
  char published = 0;
  EXPECT_EQ(read(read_end.get(), &published, 1), 1);
}

TEST_F(ContinuedStop, IsNotPublishedByAProcessThatIsCancelled) {
  EXPECT_THAT(NotesTo([](DetachedPublisher& publisher) { publisher.Cancel(); }),
              ElementsAre("it did not publish"));
}

// A controller as far as releases go: it publishes the release, and its heartbeat.
class Releaser {
 public:
  Releaser(transport::sim::Network& network, const std::string& name, std::string machine)
      : machine_(std::move(machine)), node_(network.MakeNode(name)) {
    heartbeats_ = transport::MakePublisher<msg::ControllerHeartbeat>(
                      *node_, transport::ControllerHeartbeatTopic("pack"), transport::kLatchedQos)
                      .value();
    stops_ = transport::MakePublisher<msg::EmergencyStop>(
                 *node_, transport::EmergencyStopTopic("pack"), transport::kLatchedQos)
                 .value();
  }

  void Release(std::uint64_t id) {
    static_cast<void>(stops_->Publish({id, false, "bob", "", machine_, ""}));
  }
  void SendHeartbeat() { SendHeartbeatOf(*this); }
  // As a bridge repeats it.
  void SendHeartbeatOf(const Releaser& other) {
    msg::ControllerHeartbeat heartbeat;
    heartbeat.machine = other.machine_;
    heartbeat.participant = other.node_->participant().value();
    static_cast<void>(heartbeats_->Publish(heartbeat));
  }

 private:
  const std::string machine_;
  const std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
};

class ReleasedStop : public Stop {
 protected:
  // It is published, and both actuators of the machine have latched it.
  void EngageFor(const std::string& machine) {
    latch_ =
        StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke", machine, ""}).value();
    for (auto* actuator : {&eyes_, &legs_}) (*actuator)->BelongTo("dog");
    network_.RunFor(std::chrono::seconds(1));
  }
  bool Withdrawn() {
    network_.RunFor(std::chrono::seconds(1));
    return latch_->withdrawn();
  }

  Releaser dog_controller_{network_, "dog controller", "dog"};
  Releaser cat_controller_{network_, "cat controller", "cat"};
};

TEST_F(ReleasedStop, OfAControllerOfItsMachineIsPublishedNoLonger) {
  EngageFor("dog");
  dog_controller_.SendHeartbeat();
  EXPECT_FALSE(Withdrawn());
  dog_controller_.Release(6);
  EXPECT_FALSE(Withdrawn()) << "another stop";
  dog_controller_.Release(7);
  EXPECT_TRUE(Withdrawn());
  legs_.emplace(*dog_, "legs");
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(latch_->Report(std::nullopt).Missing(), ElementsAre("legs"))
      << "a restarted module latched the released stop";
}

TEST_F(ReleasedStop, IsPublishedNoLongerAlsoWhereTheHeartbeatOfTheControllerComesLater) {
  EngageFor("dog");
  dog_controller_.Release(7);
  EXPECT_FALSE(Withdrawn()) << "anything may have published that";
  dog_controller_.SendHeartbeat();
  EXPECT_TRUE(Withdrawn());
}

TEST_F(ReleasedStop, StaysPublishedThoughAPanelABridgeOrAnotherMachineReleasesIt) {
  EngageFor("dog");
  dog_controller_.SendHeartbeat();
  Releaser panel(network_, "panel", "dog");
  panel.Release(7);
  EXPECT_FALSE(Withdrawn());
  panel.SendHeartbeatOf(dog_controller_);
  EXPECT_FALSE(Withdrawn());
  cat_controller_.SendHeartbeat();
  cat_controller_.Release(7);
  EXPECT_FALSE(Withdrawn());
}

TEST_F(ReleasedStop, ThatNamesTheBeginningOfAnIdIsPublishedUntilThatMachineReleasesIt) {
  latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke", "5982", ""}).value();
  latch_->AddBeginningOfId("5982");
  for (auto* actuator : {&eyes_, &legs_}) (*actuator)->BelongTo("dog", "5982c7ee");
  cat_controller_.SendHeartbeat();
  cat_controller_.Release(7);
  EXPECT_FALSE(Withdrawn());
  dog_controller_.SendHeartbeat();
  dog_controller_.Release(7);
  EXPECT_TRUE(Withdrawn());
}

// The program that had engaged it did, once it ended: an hour after the release, too.
TEST_F(ReleasedStop, IsNotPublishedAfterItsProgramEither) {
  DetachedPublisher publisher([](const DetachedPublisher::Notes&) { return true; });
  EngageFor("dog");
  latch_->ContinueWith(publisher);
  dog_controller_.SendHeartbeat();
  EXPECT_FALSE(Withdrawn());
  EXPECT_NE(publisher.pid(), 0);
  dog_controller_.Release(7);
  EXPECT_TRUE(Withdrawn());
  EXPECT_EQ(publisher.pid(), 0);
}

TEST_F(ReleasedStop, ThatGoesToTheRobotsThatWereFoundIsPublishedNoLonger) {
  EngageFor("dog");
  for (auto* actuator : {&eyes_, &legs_}) (*actuator)->BelongTo("dog", "5982c7ee", "one boot/1");
  network_.RunFor(std::chrono::seconds(10));
  dog_controller_.SendHeartbeat();
  EXPECT_FALSE(Withdrawn());
  dog_controller_.Release(7);
  EXPECT_TRUE(Withdrawn());
  legs_.emplace(*dog_, "legs");
  legs_->BelongTo("dog", "5982c7ee", "one boot/1");
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(legs_->stopped());
}

// The machine that is meant may still be out of range.
TEST_F(ReleasedStop, ThatNamesNoMachineStaysPublishedAfterEachReleaseWhereNoneRunsHere) {
  EngageFor("");
  for (Releaser* controller : {&dog_controller_, &cat_controller_}) {
    controller->SendHeartbeat();
    controller->Release(7);
  }
  EXPECT_FALSE(Withdrawn()) << "before the time to find others is over";
  network_.RunFor(std::chrono::seconds(10));
  EXPECT_FALSE(Withdrawn());
}

// On a robot whose controller had ended it was published for a minute after its release.
TEST_F(ReleasedStop, ThatNamesNoMachineIsPublishedUntilTheOneHereAndEachOtherHaveReleasedIt) {
  EngageFor("");
  for (auto* actuator : {&eyes_, &legs_}) (*actuator)->BelongTo("dog", "", HostId());
  Listener tail(*dog_, "tail");
  tail.BelongTo("cat");
  dog_controller_.SendHeartbeat();
  dog_controller_.Release(6);
  EXPECT_FALSE(Withdrawn()) << "another stop";
  dog_controller_.Release(7);
  EXPECT_FALSE(Withdrawn()) << "the cat has received it, too";
  cat_controller_.Release(7);
  EXPECT_FALSE(Withdrawn()) << "anything may have published that";
  cat_controller_.SendHeartbeat();
  EXPECT_TRUE(Withdrawn());
}

TEST_F(ReleasedStop, ThatNamesNoMachineStaysPublishedUntilTheTimeToFindOthersIsOver) {
  latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke"},
                            {false, /*lan=*/true, {}, {}})
               .value();
  for (auto* actuator : {&eyes_, &legs_}) (*actuator)->BelongTo("dog", "", HostId());
  dog_controller_.SendHeartbeat();
  dog_controller_.Release(7);
  network_.RunFor(std::chrono::seconds(8));
  EXPECT_FALSE(Withdrawn());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_TRUE(Withdrawn());
}

// Of a robot that only its program has found, its process would not wait for the release.
TEST_F(ContinuedStop, ThatNamesNoMachineGoesOnUntilEachRobotThatItsProgramFoundHasReleasedIt) {
  const auto engage = [this](DetachedPublisher::Notes notes) {
    latch_ = StopLatch::Begin(*desk_, "pack", {7, true, "alice@desk", "smoke"},
                              {false, false, {}, std::move(notes)})
                 .value();
  };
  engage({});
  const auto notes = NotesTo([&](DetachedPublisher& publisher) {
    latch_->ContinueWith(publisher);
    Listener tail(*dog_, "tail");
    tail.BelongTo("cat", "5984a000-cat");
    Pass(std::chrono::seconds(1));
    latch_ = nullptr;
  });
  ASSERT_EQ(notes.size(), 1U);
  engage(notes);
  Listener legs(*dog_, "legs");
  legs.BelongTo("dog", "", HostId());
  Releaser dog_controller(network_, "dog controller", "dog");
  dog_controller.SendHeartbeat();
  dog_controller.Release(7);
  Pass(std::chrono::seconds(5));
  EXPECT_FALSE(latch_->withdrawn());
  Releaser cat_controller(network_, "cat controller", "cat");
  cat_controller.SendHeartbeat();
  cat_controller.Release(7);
  Pass(std::chrono::seconds(1));
  EXPECT_TRUE(latch_->withdrawn());
}

}  // namespace musher::cli::stop_latch_test
