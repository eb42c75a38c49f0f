// An actuator on another host follows the controller of another machine, which has begun there: the
// controller that it followed before loses this actuator, and leads the others on.

#include <gmock/gmock.h>

#include "musher/controller/link/musher_link.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/simulation/simulated_systemds.hpp"
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

// Who has started actuator b on the board.
enum class Started : std::uint8_t { kByHand, kByTheRobot };

class TakenByOtherMachine : public ::testing::Test {
 protected:
  explicit TakenByOtherMachine(Started started = Started::kByHand)
      : config_(Robot(started)), hosts_(network_, layout_.hosts) {
    processes_.make_module = [](const std::string&) { return std::make_unique<Free>(); };
    processes_.on_end = [this](std::size_t host, std::int32_t pid, const ProcessExit& exit) {
      for (const auto& controller : {robot_.get(), other_.get()}) {
        if (controller != nullptr) controller->OnEnd(host, pid, exit);
      }
      systemds_.OnEnd(host, pid, exit);
    };
    processes_.leads_on = [this](std::size_t host, std::int32_t pid) {
      return other_ && other_->host() == host && other_->pid() == pid;
    };
    if (started == Started::kByHand) processes_.Launch("b");
    BringUpTheRobot();
    EXPECT_EQ(machine().state, kActive);
    EXPECT_EQ(Ours().Of("b").presence, Presence::kPresent);
  }
  ~TakenByOtherMachine() override { processes_.on_end = {}; }

  std::unique_ptr<simulation::SimulatedController> Open(const std::string& endpoint,
                                                        std::size_t host, const std::string& id,
                                                        simulation::Disk& disk) {
    simulation::SimulatedController::Hooks hooks;
    if (host != kBoard) {
      hooks.connect = [this, host](transport::EventLoop& loop) {
        return systemds_.From(host, loop);
      };
    }
    return std::make_unique<simulation::SimulatedController>(
        network_, endpoint, host, hosts_, config_, id, processes_, disk, std::move(hooks));
  }
  // Also again, after its controller has been killed.
  void BringUpTheRobot() {
    robot_.reset();
    robot_ = Open("robot", 0, layout_.machine_id, robot_disk_);
    network_.RunFor(std::chrono::seconds(1));  // as it listens for others
    robot_->Begin(true);
    EXPECT_TRUE(RunUntil([this] { return machine().phase == Phase::kRunning; }));
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
  simulation::SimulatedSystemds systemds_{network_, config_, hosts_, processes_};
  simulation::Disk robot_disk_;
  simulation::Disk other_disk_;
  std::unique_ptr<simulation::SimulatedController> robot_;
  std::unique_ptr<simulation::SimulatedController> other_;

 private:
  class Free : public simulation::Module {
   public:
    simulation::Act Run(const State&) override { return {Milliseconds(5), {kCodeOk, ""}}; }
  };
  static MachineConfig Robot(Started started) {
    MachineConfig config = MachineOf(2);
    config.transport = TransportProfile::kLan;
    config.actuators[0].command = {"run", "a"};
    if (started == Started::kByHand) return config;
    HostConfig& board = config.hosts.emplace_back();
    board.name = "board";
    board.address = "10.0.0.2";
    ActuatorConfig& b = config.actuators[1];
    b.host = "board";
    b.command = {"run", "b"};
    b.restart.policy = RestartPolicy::kOnFailure;
    b.times.assign(b.times.size(), std::chrono::seconds(5));
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

// The controller of the robot has started b, by the systemd of the board.
class ProcessTakenByOtherMachine : public TakenByOtherMachine {
 protected:
  ProcessTakenByOtherMachine() : TakenByOtherMachine(Started::kByTheRobot) {
    TheBoardBeginsAMachineOfItsOwn();
    EXPECT_TRUE(RunUntil([this] { return Ours().Of("b").presence == Presence::kLost; }));
  }
  void ExpectLeftAloneByTearDown() {
    const std::int32_t pid = processes_.PidOf("b", kBoard);
    const Time begun = network_.now();
    const SwitchResult down = Set(kTearDown);
    EXPECT_LT(network_.now() - begun, config_.shutdown_budget / 2) << "nothing is to be awaited";
    EXPECT_EQ(down.outcome, SwitchOutcome::kDoneDegraded);
    EXPECT_THAT(down.reason, HasSubstr("b: it follows another machine now, test (id 22222222)"));
    EXPECT_THAT(down.reason, HasSubstr("its process " + std::to_string(pid) + " on host board"));
    network_.RunFor(std::chrono::seconds(30));
    ASSERT_TRUE(processes_.IsAlive("b", kBoard));
    EXPECT_EQ(processes_.PidOf("b", kBoard), pid);
    EXPECT_EQ(Other().Of("b").presence, Presence::kPresent) << "it is the other machine's";
  }
};

// The actuator of another robot was ended by SIGTERM, without TearDown.
TEST_F(ProcessTakenByOtherMachine, IsLeftAloneByTearDown) {
  ExpectLeftAloneByTearDown();
}

TEST_F(ProcessTakenByOtherMachine, IsLeftAloneByARestartThatAPersonRequests) {
  const std::int32_t pid = processes_.PidOf("b", kBoard);
  std::optional<Result<>> restarted;
  robot_->shell().Restart("b", "alice", [&](const Result<>& result) { restarted = result; });
  ASSERT_TRUE(RunUntil([&] { return restarted.has_value(); }));
  ASSERT_FALSE(*restarted);
  EXPECT_THAT(restarted->error().message, HasSubstr("it follows another machine now, test"));
  EXPECT_EQ(processes_.PidOf("b", kBoard), pid);
  ExpectLeftAloneByTearDown();
}

// The next controller of the robot finds the process by its unit, and has never had a status of it.
TEST_F(ProcessTakenByOtherMachine, IsLeftAloneByTheNextController) {
  BringUpTheRobot();
  ASSERT_TRUE(RunUntil([this] { return Ours().Of("b").fault.has_value(); }));
  EXPECT_EQ(Ours().Of("b").presence, Presence::kLost);
  EXPECT_THAT(Ours().Of("b").fault->message, HasSubstr("it follows another machine now, test"));
  ExpectLeftAloneByTearDown();
}

// The unit is found while the machine is torn down already.
TEST_F(ProcessTakenByOtherMachine, IsLeftAloneByANextControllerThatFinishesATearDown) {
  const std::int32_t pid = processes_.PidOf("b", kBoard);
  robot_.reset();
  robot_disk_.stop_intent = true;
  robot_ = Open("robot", 0, layout_.machine_id, robot_disk_);
  network_.RunFor(std::chrono::seconds(1));
  robot_->Begin(true, simulation::Starter::kSupervisor);
  ASSERT_TRUE(RunUntil([this] { return machine().phase == Phase::kStopped; }));
  network_.RunFor(std::chrono::seconds(30));
  EXPECT_EQ(processes_.PidOf("b", kBoard), pid);
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
