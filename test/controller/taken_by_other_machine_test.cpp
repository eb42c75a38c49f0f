// An actuator on another host follows the controller of another machine, which has begun there: the
// controller that it followed before loses this actuator, and leads the others on.

#include <gmock/gmock.h>

#include "musher/controller/link/musher_link.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::taken_by_other_machine_test {

using ::testing::HasSubstr;

constexpr std::size_t kBoard = 1;  // its host; the controller of the robot is on host 0

simulation::Layout WithABoard() {
  simulation::Layout layout;
  layout.hosts = {"robot", "board"};
  layout.host_of = PerActuator<std::size_t>(2, 0);
  layout.host_of[1] = kBoard;
  layout.machine_id = "11111111-0000-4000-8000-000000000000";
  return layout;
}

// Actuator b runs on the board, where it was started by hand.
class TakenByOtherMachine : public ::testing::Test {
 protected:
  TakenByOtherMachine() : config_(Robot()), hosts_(network_, layout_.hosts) {
    processes_.make_module = [](const std::string&) { return std::make_unique<Free>(); };
    processes_.on_end = [this](std::size_t host, std::int32_t pid, const ProcessExit& exit) {
      for (const auto& controller : {robot_.get(), other_.get()}) {
        if (controller != nullptr) controller->OnEnd(host, pid, exit);
      }
    };
    processes_.leads_on = [this](std::size_t host, std::int32_t pid) {
      return other_ && other_->host() == host && other_->pid() == pid;
    };
    processes_.Launch("b");
    robot_ = Open("robot", 0, layout_.machine_id, robot_disk_);
    robot_->Begin(true);
    EXPECT_TRUE(RunUntil([this] { return machine().phase == Phase::kRunning; }));
    EXPECT_EQ(machine().state, kActive);
  }
  ~TakenByOtherMachine() override { processes_.on_end = {}; }

  std::unique_ptr<simulation::SimulatedController> Open(const std::string& endpoint,
                                                        std::size_t host, const std::string& id,
                                                        simulation::Disk& disk) {
    return std::make_unique<simulation::SimulatedController>(
        network_, endpoint, host, hosts_, config_, id, processes_, disk,
        simulation::SimulatedController::Hooks{});
  }
  // A person starts the same config on the board, where no state folder knows the machine's id.
  void TheBoardBeginsAMachineOfItsOwn() {
    other_disk_.epoch = 100;
    other_ = Open("other", kBoard, "22222222-0000-4000-8000-000000000000", other_disk_);
    network_.RunFor(std::chrono::seconds(1));
    other_->Begin(true);
    ASSERT_TRUE(RunUntil([this] { return Other().Of("b").presence == Presence::kPresent; }));
  }
  SwitchResult Set(const State& target) {
    std::optional<SwitchResult> reply;
    robot_->shell().SetState(target, std::nullopt,
                             [&reply](const SwitchResult& result) { reply = result; });
    EXPECT_TRUE(RunUntil([&] { return reply.has_value(); }));
    return reply.value_or(SwitchResult{});
  }
  bool RunUntil(const std::function<bool()>& done) {
    return network_.RunUntil(done, network_.now() + std::chrono::minutes(1));
  }
  struct Known {
    const MachineConfig& config;
    const Machine& machine;
    const KnownActuator& Of(const std::string& name) const {
      return machine.actuators[*config.IndexOf(name)];
    }
  };
  const Machine& machine() const { return robot_->shell().machine(); }
  Known Ours() const { return {config_, machine()}; }
  Known Other() const { return {config_, other_->shell().machine()}; }

  transport::sim::Network network_{1};
  MachineConfig config_;
  const simulation::Layout layout_ = WithABoard();
  simulation::Hosts hosts_;
  simulation::SimulatedProcesses processes_{network_, config_, hosts_, layout_};
  simulation::Disk robot_disk_;
  simulation::Disk other_disk_;
  std::unique_ptr<simulation::SimulatedController> robot_;
  std::unique_ptr<simulation::SimulatedController> other_;

 private:
  class Free : public simulation::Module {
   public:
    simulation::Act Run(const State&) override { return {Milliseconds(5), {kCodeOk, ""}}; }
  };
  static MachineConfig Robot() {
    MachineConfig config = MachineOf(2);
    config.transport = TransportProfile::kLan;
    config.actuators[0].command = {"run", "a"};
    return config;
  }
};

TEST_F(TakenByOtherMachine, IsLostAndNamesThatMachine) {
  TheBoardBeginsAMachineOfItsOwn();
  ASSERT_TRUE(RunUntil([this] { return Ours().Of("b").presence == Presence::kLost; }));
  network_.RunFor(std::chrono::seconds(10));
  EXPECT_EQ(Ours().Of("b").presence, Presence::kLost) << "its heartbeats are received";
  ASSERT_TRUE(Ours().Of("b").fault);
  EXPECT_THAT(Ours().Of("b").fault->message, HasSubstr("follows another machine now"));
  EXPECT_THAT(Ours().Of("b").fault->message, HasSubstr("22222222"));
}

// It was taken in a cut in which its writer was lost: with its first heartbeat it was asked for
// control every 500 ms, and counted as starting.
TEST_F(TakenByOtherMachine, InALongCutIsNotTakenForOneThatIsBack) {
  const auto cut = [this](bool blocked) {
    hosts_.SetHostBlocked(0, kBoard, blocked);
    hosts_.SetHostBlocked(kBoard, 0, blocked);
  };
  cut(true);
  ASSERT_TRUE(RunUntil([this] { return Ours().Of("b").presence == Presence::kLost; }));
  network_.RunFor(std::chrono::seconds(10));
  TheBoardBeginsAMachineOfItsOwn();
  cut(false);
  for (int i = 0; i < 200; ++i) {
    network_.RunFor(Milliseconds(100));
    ASSERT_EQ(Ours().Of("b").presence, Presence::kLost);
  }
  EXPECT_EQ(Other().Of("b").presence, Presence::kPresent);
}

// It gave the whole robot up: its base drove on without any controller, and `musher down` was
// superseded.
TEST_F(TakenByOtherMachine, LeavesTheOthersToTheirController) {
  TheBoardBeginsAMachineOfItsOwn();
  EXPECT_EQ(Set(kLowPower).state, kLowPower);
  EXPECT_EQ(Ours().Of("a").state(), kLowPower);
  const SwitchResult down = Set(kTearDown);
  EXPECT_EQ(down.outcome, SwitchOutcome::kDoneDegraded) << down.reason;
  EXPECT_THAT(down.reason, HasSubstr("b: "));
  EXPECT_EQ(machine().phase, Phase::kStopped);
  EXPECT_FALSE(processes_.IsAlive("a", 0));
  EXPECT_TRUE(processes_.IsAlive("b", kBoard)) << "it is the other machine's";
}

// A status that is lost on its way is sent again after the reply: the epoch of the reply alone must
// not end this controller.
TEST(ReplyOfAnotherMachine, IsNoneToThisController) {
  for (const std::string host : {"robot/1", "board/1"}) {
    transport::sim::Network network(1);
    const auto robot = network.MakeNode("robot");
    const auto board = network.MakeNode("board");
    const auto server = transport::MakeServer<msg::ActuatorCommand>(
                            *board, transport::CommandService("", "a"),
                            [&host](const msg::ActuatorCommand::Request&, auto reply) {
                              msg::ActuatorCommand::Response response;
                              response.verdict = msg::ActuatorCommand::kVerdictRefused;
                              response.status.name = "a";
                              response.status.epoch = 100;
                              response.status.host = host;
                              response.status.machine = "test";
                              response.status.machine_id = "22222222-0000-4000-8000-000000000000";
                              reply(response);
                            })
                            .value();
    std::size_t replies = 0;
    const MachineConfig config = MachineOf(1);
    const auto link =
        MusherLink::Make(*robot, config, 0, [&replies](const Event&) { ++replies; }).value();
    link->OnMachine({"test", "11111111-0000-4000-8000-000000000000"}, "robot/1");
    network.RunFor(std::chrono::seconds(1));
    link->Query({Epoch(1), CommandNumber(1), false});
    network.RunFor(std::chrono::seconds(1));
    EXPECT_EQ(replies, host == "robot/1" ? 1U : 0U) << host;
  }
}

}  // namespace musher::testing::taken_by_other_machine_test
