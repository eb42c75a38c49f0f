// Whose process a pid is: any process can publish a status, with any pid of the controller's
// host. A pid that is not proven is never watched, traced or signalled.

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/controller.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/lifecycle/coordination/records.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::process_proof_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::Is;
using testing::kAllStates;
using ::testing::Not;
using testing::RobotFile;

// A process of this test that has nothing to do with the machine. With `name` it holds that name.
class Bystander {
 public:
  explicit Bystander(const std::string& name = "") {
    std::array<int, 2> ready{};
    if (pipe(ready.data()) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      const auto lock = NameLock::Acquire(name);
      const bool held = name.empty() || lock.ok();
      if (held && write(ready[1], "r", 1) == 1) pause();
      _exit(1);
    }
    char byte = 0;
    EXPECT_EQ(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    close(ready[1]);
  }
  ~Bystander() {
    if (ended_) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Bystander(const Bystander&) = delete;
  Bystander& operator=(const Bystander&) = delete;

  pid_t pid() const { return pid_; }
  bool IsAlive() {
    ended_ = ended_ || waitpid(pid_, nullptr, WNOHANG) == pid_;
    return !ended_;
  }

 private:
  pid_t pid_ = 0;
  bool ended_ = false;
};

// A controller of the actuator `arm`, whose own process ends at once and is not started again, and
// a participant that publishes statuses in the arm's name.
class ProcessProof : public ::testing::Test {
 protected:
  ProcessProof()
      : file_({"arm"}, kAllStates, {}, "command = [\"true\"]\nrestart = \"no\"\n"),
        config_(*ReadConfigFile(file_.path()).config),
        node_(transport::MakeDdsNode(loop_, {}).value()),
        peer_(transport::MakeDdsNode(loop_, {}).value()) {
    ControllerOptions options;
    options.by_hand = true;
    options.hooks.on_record = [this](const action::Record& record) { records_.push_back(record); };
    options.hooks.on_stopped = [this] { stopped_ = true; };
    controller_ = Controller::Make(*node_, transport::TestDomain(), config_, options).value();
    EXPECT_TRUE(RunUntil([&] { return Arm().fault.has_value(); })) << "its process has ended";
    status_ =
        transport::MakePublisher<msg::ActuatorStatus>(
            *peer_, transport::ActuatorStatusTopic(config_.name_space), transport::kLatchedQos)
            .value();
  }

  std::string NameOfArm() const {
    return NameLock::NameOf(transport::TestDomain(), config_.name_space, "arm");
  }

  const KnownActuator& Arm() const { return controller_->shell().machine().actuators[0]; }

  // The peer publishes the status of the arm with `pid`.
  void Say(pid_t pid, Incarnation incarnation = 77, const State& state = kSetUp) {
    ActuatorReport report;
    report.state = state;
    report.incarnation = incarnation;
    report.pid = pid;
    report.host = HostId();
    report.config_hash = config_.hash;
    report.stamp = loop_.Now();
    ASSERT_TRUE(status_->Publish(transport::ToMessage("arm", report)));
    ASSERT_TRUE(RunUntil([&] { return Arm().report.incarnation == incarnation; }));
  }

  void TakeDown() {
    controller_->shell().SetState(State(kTearDown), std::nullopt, [](const SwitchResult&) {});
    EXPECT_TRUE(RunUntil([&] { return stopped_; }));
  }

  template <class Done>
  bool RunUntil(const Done& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }

  RobotFile file_;
  const MachineConfig config_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Node> peer_;
  testing::Records records_;
  bool stopped_ = false;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> status_;
  std::unique_ptr<Controller> controller_;
};

TEST_F(ProcessProof, AProcessThatAStatusNamesWithoutProofIsNotSignalled) {
  Bystander bystander;
  Say(bystander.pid());
  EXPECT_EQ(Arm().report.pid, 0) << "the decision code never gets it";
  TakeDown();
  EXPECT_TRUE(bystander.IsAlive());
  EXPECT_THAT(testing::RecordWith(records_, EventName::kProcessUnproven).message,
              HasSubstr(std::to_string(bystander.pid())));
  EXPECT_THAT(records_, Not(Contains(Is(EventName::kProcessSignalled))));
  EXPECT_THAT(records_, Not(Contains(Is(EventName::kBacktraceStarted))));
}

TEST_F(ProcessProof, NorIsItWatched) {
  Bystander bystander;
  Say(bystander.pid());
  kill(bystander.pid(), SIGKILL);
  EXPECT_TRUE(RunUntil([&] { return !bystander.IsAlive(); }));
  Say(0, 78);  // comes after what the end of the other would have led to
  EXPECT_EQ(Arm().process.dead, Incarnation(0));
}

TEST_F(ProcessProof, AnUnprovenPidIsReportedOnceHoweverOftenItIsPublished) {
  Bystander bystander;
  for (Incarnation incarnation = 100; incarnation < 110; ++incarnation) {
    Say(bystander.pid(), incarnation);
  }
  EXPECT_THAT(records_, Contains(Is(EventName::kProcessUnproven)).Times(1));
}

TEST_F(ProcessProof, TheProcessThatHoldsTheNameIsAcceptedAndEndsWithTheMachine) {
  Bystander arm(NameOfArm());
  Say(arm.pid());
  EXPECT_EQ(Arm().report.pid, arm.pid());
  TakeDown();
  EXPECT_TRUE(RunUntil([&] { return !arm.IsAlive(); }));
}

TEST_F(ProcessProof, TheEndOfTheProcessThatHoldsTheNameIsSeenAtOnce) {
  Bystander arm(NameOfArm());
  Say(arm.pid());
  kill(arm.pid(), SIGKILL);
  EXPECT_TRUE(RunUntil([&] { return Arm().process.dead == 77; }));
}

TEST_F(ProcessProof, OnlyTheProcessThatHoldsTheNameIsAccepted) {
  Bystander arm(NameOfArm());
  Bystander bystander;
  Say(bystander.pid());
  Say(arm.pid(), 78);
  Say(bystander.pid(), 79);
  EXPECT_EQ(Arm().report.pid, 0);
  TakeDown();
  EXPECT_TRUE(bystander.IsAlive());
}

TEST_F(ProcessProof, AProcessOfAnotherUserIsReportedWithItsUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  ASSERT_EQ(seteuid(65534), 0);
  Bystander arm(NameOfArm());
  ASSERT_EQ(seteuid(0), 0);
  Say(arm.pid());
  EXPECT_EQ(Arm().report.pid, 0);
  EXPECT_THAT(testing::RecordWith(records_, EventName::kProcessUnproven).message,
              HasSubstr("of user 65534"));
  TakeDown();
  EXPECT_TRUE(arm.IsAlive());
}

class StopOfThisHost : public ProcessProof {
 protected:
  bool HandOver(const msg::EmergencyStop& stop) const {
    return NameLock::Send(
        NameLock::NameOf(transport::TestDomain(), config_.name_space, "musher/controller"),
        msg::Encode(stop));
  }
  const EmergencyStopState& Emergency() const { return controller_->shell().machine().emergency; }
};

TEST_F(StopOfThisHost, ReachesTheControllerByItsNameWithoutDiscovery) {
  msg::EmergencyStop stop = NewEmergencyStop("alice", "a person is near");
  stop.machine = config_.name;
  ASSERT_TRUE(HandOver(stop));
  ASSERT_TRUE(RunUntil([&] { return Emergency().stop.has_value(); }));
  EXPECT_EQ(Emergency().stop->id, StopId(stop.id));
  EXPECT_EQ(Emergency().stop->by, "alice");
}

TEST_F(StopOfThisHost, OfAnotherMachineIsIgnoredAndNoReleaseIsTaken) {
  msg::EmergencyStop other = NewEmergencyStop("alice", "");
  other.machine = "another one";
  ASSERT_TRUE(HandOver(other));
  msg::EmergencyStop stop = NewEmergencyStop("bob", "");
  ASSERT_TRUE(HandOver(stop));
  stop.engaged = false;
  ASSERT_TRUE(HandOver(stop));
  ASSERT_TRUE(RunUntil([&] { return Emergency().stop.has_value(); }));
  loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(20));
  ASSERT_TRUE(Emergency().stop);
  EXPECT_EQ(Emergency().stop->by, "bob");
}

TEST(StartOfAProcess, ShowsAModuleByItsNameAndAForeignProgramByItsIdleness) {
  transport::LinuxEventLoop loop;
  transport::DiskWriter disk(loop);
  ProcessSupervisor processes(loop, disk);
  const std::string name = "start_of_a_process_" + std::to_string(getpid());
  KernelProbe probe(loop, processes, [&](const std::string&) { return name; });
  const auto becomes = [&](pid_t pid, StartProgress progress) {
    const transport::LoopHandlePtr tick = loop.Every(Milliseconds(2), [] {});
    return loop.RunUntil([&] { return probe.ProgressOf("arm", pid) == progress; },
                         loop.Now() + std::chrono::seconds(120));
  };
  const Bystander foreign;
  EXPECT_TRUE(becomes(foreign.pid(), StartProgress::kIdle));
  {
    const Bystander module(name);
    EXPECT_TRUE(becomes(module.pid(), StartProgress::kNamed));
    EXPECT_TRUE(becomes(foreign.pid(), StartProgress::kIdle)) << "another process holds it";
  }
  const pid_t loading = fork();
  if (loading == 0) {
    volatile unsigned long sum = 0;
    while (true) sum = sum + 1;
  }
  EXPECT_TRUE(becomes(loading, StartProgress::kBusy));
  kill(loading, SIGKILL);
  waitpid(loading, nullptr, 0);
}

}  // namespace musher::process_proof_test
