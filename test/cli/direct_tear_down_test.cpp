// What `musher down --without-controller` says of the end of an actuator.

#include "musher/cli/machine/direct_tear_down.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "musher/base/host.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli::direct_tear_down_test {

// A cable that was pulled for the time of a lease was "exited without TearDown", and exit code 0.
TEST(ADirectTearDown, OfAnotherHostIsNotBelievedWhereOnlyTheStatusIsLost) {
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic("direct_tear_down_test"), transport::kLatchedQos)
          .value();
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = "another boot/1";
  legs.state = "Active";
  legs.pid = 7;
  static_cast<void>(statuses->Publish(legs));
  const auto running = RunningActuators::Begin(*desk, "direct_tear_down_test", false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  ASSERT_EQ(running->Now().size(), 1U);
  const auto ending =
      DirectTearDown::Begin(*desk, "direct_tear_down_test", *running, std::chrono::seconds(1))
          .value();
  network.Partition("board", "desk");
  network.RunFor(std::chrono::minutes(1));
  ASSERT_FALSE(running->HasStatusOf("legs"));
  EXPECT_TRUE(ending->OutOfTime());
  EXPECT_FALSE(ending->Ended());
  EXPECT_EQ(ending->Outcomes().front().trouble, "its status is lost, it may run on");
}

// Its status lasts until the lease of its participant expires: "torn down, exited", exit code 0.
TEST(ADirectTearDown, DoesNotTakeAKilledProcessForOneThatWasTornDown) {
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto robot = network.MakeNode("robot");
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *robot, transport::ActuatorStatusTopic("direct_tear_down_test"), transport::kLatchedQos)
          .value();
  const pid_t process = fork();
  if (process == 0) {
    pause();
    _exit(0);
  }
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = HostId();
  legs.state = "Active";
  legs.pid = process;
  static_cast<void>(statuses->Publish(legs));
  const auto running = RunningActuators::Begin(*desk, "direct_tear_down_test", false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  ASSERT_EQ(running->Now().size(), 1U);
  const auto ending =
      DirectTearDown::Begin(*desk, "direct_tear_down_test", *running, std::chrono::seconds(20))
          .value();
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
  network.RunFor(std::chrono::seconds(1));
  ASSERT_TRUE(running->HasStatusOf("legs"));
  EXPECT_FALSE(ending->Outcomes().front().torn_down);
}

// A controller had been gone for longer than the time of the TearDown: the command counted as old
// as the last change of the actuator, which was then ended with what it had switched on.
TEST(ADirectTearDown, CommandsAnActuatorThatHasNotChangedForLong) {
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const auto stamp_ns = [&board] {
    return Duration(board->loop().Now().time_since_epoch()).count();
  };
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic("direct_tear_down_test"), transport::kLatchedQos)
          .value();
  const auto server = transport::MakeServer<msg::ActuatorCommand>(
      *board, transport::CommandService("direct_tear_down_test", "legs"),
      [&](const msg::ActuatorCommand::Request& request, auto reply) {
        msg::ActuatorCommand::Response response;
        response.status.stamp_ns = stamp_ns();
        const std::int64_t age_ns = stamp_ns() - request.status_stamp_ns - request.since_status_ns;
        if (age_ns > request.budget_ns) response.verdict = msg::ActuatorCommand::kVerdictRefused;
        reply(response);
      });
  ASSERT_TRUE(server);
  network.RunFor(std::chrono::seconds(1));
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = "another boot/1";
  legs.state = "Active";
  legs.stamp_ns = stamp_ns();
  legs.pid = 7;
  static_cast<void>(statuses->Publish(legs));
  network.RunFor(std::chrono::seconds(60));
  const auto running = RunningActuators::Begin(*desk, "direct_tear_down_test", false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  const auto ending =
      DirectTearDown::Begin(*desk, "direct_tear_down_test", *running, std::chrono::seconds(5))
          .value();
  network.RunFor(std::chrono::seconds(2));
  EXPECT_TRUE(ending->Outcomes().front().torn_down) << ending->Outcomes().front().trouble;
}

// It had seen another controller, which never led it: it was ended with what it had switched on.
TEST(ADirectTearDown, TakesAHigherEpochThanAnyThatTheActuatorHasSeen) {
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic("direct_tear_down_test"), transport::kLatchedQos)
          .value();
  constexpr std::uint64_t kSeen = 12;
  std::uint64_t torn_down_by = 0;
  std::uint64_t number = 0;
  const auto server = transport::MakeServer<msg::ActuatorCommand>(
      *board, transport::CommandService("direct_tear_down_test", "legs"),
      [&](const msg::ActuatorCommand::Request& request, auto reply) {
        msg::ActuatorCommand::Response response;
        if (request.epoch <= kSeen) {
          response.verdict = msg::ActuatorCommand::kVerdictRefused;
          response.code = kCodePermissionDenied;
          response.status.epoch = kSeen;
          response.status.number = request.number + 5;
        } else {
          torn_down_by = request.epoch;
          number = request.number;
        }
        reply(response);
      });
  ASSERT_TRUE(server);
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = "another boot/1";
  legs.state = "Active";
  legs.epoch = 1;
  legs.pid = 7;
  static_cast<void>(statuses->Publish(legs));
  const auto running = RunningActuators::Begin(*desk, "direct_tear_down_test", false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  const auto ending =
      DirectTearDown::Begin(*desk, "direct_tear_down_test", *running, std::chrono::seconds(5))
          .value();
  network.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(torn_down_by, kSeen + 1);
  EXPECT_EQ(number, 7U) << "after 1, which was refused with 6 as the last one";
  EXPECT_TRUE(ending->Outcomes().front().torn_down);
}

// On a slow computer no status had arrived within the second of the search: all processes were
// ended by a signal, with what they had switched on.
TEST(ADirectTearDown, CommandsAnActuatorOfThisHostOnceItsStatusArrives) {
  const std::string name_space = "late_" + std::to_string(getpid());
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const int domain = transport::DomainId({}).value();
  const auto held = NameLock::Acquire(NameLock::NameOf(domain, name_space, "legs"));
  ASSERT_TRUE(held);
  const auto running = RunningActuators::Begin(*desk, name_space, false).value();
  network.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(running->Now().count("legs"), 1U);
  ASSERT_FALSE(running->Now().at("legs").has_status);
  const auto ending =
      DirectTearDown::Begin(*desk, name_space, *running, std::chrono::seconds(10)).value();
  network.RunFor(std::chrono::seconds(3));
  EXPECT_EQ(ending->Outcomes().front().signal, "") << "it has time until the timeout";

  std::string machine;
  const auto server = transport::MakeServer<msg::ActuatorCommand>(
      *board, transport::CommandService(name_space, "legs"),
      [&machine](const msg::ActuatorCommand::Request& request, auto reply) {
        machine = request.machine;
        reply(msg::ActuatorCommand::Response{});
      });
  ASSERT_TRUE(server);
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic(name_space), transport::kLatchedQos)
          .value();
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = HostId();
  legs.state = "Active";
  legs.pid = getpid();
  static_cast<void>(statuses->Publish(legs));
  network.RunFor(Milliseconds(500));
  EXPECT_EQ(machine, "dog");
  EXPECT_TRUE(ending->Outcomes().front().torn_down);
  EXPECT_EQ(ending->Outcomes().front().trouble, "");
}

// Its name is held on this host, and its late status says that it is of a robot that is simulated
// here, too.
TEST(ADirectTearDown, LeavesAnActuatorAloneWhoseLateStatusIsOfAnotherMachine) {
  const std::string name_space = "foreign_" + std::to_string(getpid());
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const int domain = transport::DomainId({}).value();
  const auto held = NameLock::Acquire(NameLock::NameOf(domain, name_space, "legs"));
  ASSERT_TRUE(held);
  const auto running = RunningActuators::Begin(*desk, name_space, false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  const auto ending =
      DirectTearDown::Begin(*desk, name_space, *running, std::chrono::seconds(10)).value();
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic(name_space), transport::kLatchedQos)
          .value();
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "cat";
  legs.host = HostId();
  legs.state = "Active";
  legs.pid = getpid();
  static_cast<void>(statuses->Publish(legs));
  network.RunFor(std::chrono::seconds(30));
  EXPECT_TRUE(ending->Outcomes().empty());
}

// One that has the name on another host announced itself first, and was torn down in the place of
// the one that is found here.
TEST(ADirectTearDown, AwaitsTheStatusOfTheProcessThatItHasFoundHere) {
  const std::string name_space = "elsewhere_" + std::to_string(getpid());
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const int domain = transport::DomainId({}).value();
  const auto held = NameLock::Acquire(NameLock::NameOf(domain, name_space, "legs"));
  ASSERT_TRUE(held);
  const auto running = RunningActuators::Begin(*desk, name_space, false).value();
  network.RunFor(std::chrono::seconds(1));
  const auto ending =
      DirectTearDown::Begin(*desk, name_space, *running, std::chrono::seconds(10)).value();
  int commands = 0;
  const auto server = transport::MakeServer<msg::ActuatorCommand>(
      *board, transport::CommandService(name_space, "legs"),
      [&commands](const msg::ActuatorCommand::Request&, auto reply) {
        ++commands;
        reply(msg::ActuatorCommand::Response{});
      });
  ASSERT_TRUE(server);
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic(name_space), transport::kLatchedQos)
          .value();
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "cat";
  legs.host = "another boot/1";
  legs.state = "Active";
  legs.pid = 7;
  static_cast<void>(statuses->Publish(legs));
  network.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(commands, 0);
  EXPECT_FALSE(ending->Outcomes().front().torn_down);
}

// The second process of the actuator, on another host, was torn down: that of this host counted as
// torn down, and was ended with all that it had switched on.
TEST(ADirectTearDown, DoesNotTakeATearDownOnAnotherHostForThatOfTheProcessHere) {
  const std::string name_space = "torn_" + std::to_string(getpid());
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  const auto board = network.MakeNode("board");
  const int domain = transport::DomainId({}).value();
  const auto held = NameLock::Acquire(NameLock::NameOf(domain, name_space, "legs"));
  ASSERT_TRUE(held);
  const auto statuses =
      transport::MakePublisher<msg::ActuatorStatus>(
          *board, transport::ActuatorStatusTopic(name_space), transport::kLatchedQos)
          .value();
  msg::ActuatorStatus legs;
  legs.name = "legs";
  legs.machine = "dog";
  legs.host = "another boot/1";
  legs.state = "TearDown";
  legs.pid = 7;
  static_cast<void>(statuses->Publish(legs));
  const auto running = RunningActuators::Begin(*desk, name_space, false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  ASSERT_EQ(running->Now().count("legs"), 1U);
  EXPECT_EQ(running->Now().at("legs").status.pid, getpid());
  EXPECT_FALSE(running->Now().at("legs").has_status);
}

// The other one runs on, where a person believed that all was off.
TEST(ADirectTearDown, NamesTheProcessOfAnActuatorOnAnotherHostThatItDoesNotEnd) {
  transport::sim::Network network(1);
  const auto desk = network.MakeNode("desk");
  struct Board {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> statuses;
    std::unique_ptr<transport::Server<msg::ActuatorCommand>> server;
    msg::ActuatorStatus legs;
  };
  std::map<std::int32_t, Board> boards;  // by the pid of their legs
  std::vector<std::int32_t> commanded;
  for (const std::int32_t pid : {7, 8}) {
    Board& board = boards[pid];
    board.node = network.MakeNode("board " + std::to_string(pid));
    board.statuses = transport::MakePublisher<msg::ActuatorStatus>(
                         *board.node, transport::ActuatorStatusTopic("direct_tear_down_test"),
                         transport::kLatchedQos)
                         .value();
    board.server = transport::MakeServer<msg::ActuatorCommand>(
                       *board.node, transport::CommandService("direct_tear_down_test", "legs"),
                       [&board, &commanded](const auto& request, auto reply) {
                         if (request.incarnation != board.legs.incarnation) return;
                         commanded.push_back(board.legs.pid);
                         board.legs.state = "TearDown";
                         static_cast<void>(board.statuses->Publish(board.legs));
                         reply(msg::ActuatorCommand::Response{});
                       })
                       .value();
    board.legs.name = "legs";
    board.legs.machine = "dog";
    board.legs.host = "boot " + std::to_string(pid) + "/1";
    board.legs.state = "Active";
    board.legs.incarnation = 100 + static_cast<std::uint64_t>(pid);
    board.legs.pid = pid;
    static_cast<void>(board.statuses->Publish(board.legs));
  }
  const auto running = RunningActuators::Begin(*desk, "direct_tear_down_test", false).value();
  network.RunFor(std::chrono::seconds(1));
  running->OnlyOf({"dog", ""});
  const auto ending =
      DirectTearDown::Begin(*desk, "direct_tear_down_test", *running, std::chrono::seconds(5))
          .value();
  network.RunFor(std::chrono::seconds(2));
  ASSERT_EQ(commanded.size(), 1U);
  const auto others = ending->Others();
  ASSERT_EQ(others.size(), 1U);
  EXPECT_EQ(others.front().name, "legs");
  EXPECT_EQ(others.front().pid, commanded.front() == 7 ? 8 : 7);
  EXPECT_NE(others.front().host, "");
}

TEST(ADirectTearDown, SaysHowTheProcessesThatItDoesNotEndAreEnded) {
  EXPECT_EQ(OthersText({{"legs", 8, "dock"}}),
            "legs (pid 8 of host dock) still runs, beside what was ended; `musher down "
            "--without-controller` ends it, too, when it is repeated");
  EXPECT_EQ(OthersText({{"legs", 8, "dock"}, {"arm", 9, "dock"}}),
            "legs (pid 8 of host dock), arm (pid 9 of host dock) still run, beside what was ended; "
            "`musher down --without-controller` ends them, too, when it is repeated");
}

}  // namespace musher::cli::direct_tear_down_test
