// What `musher down --without-controller` says of the end of an actuator.

#include "musher/cli/machine/direct_tear_down.hpp"

#include <gtest/gtest.h>

#include "musher/messages/musher_msgs/actuator_status.hpp"
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

}  // namespace musher::cli::direct_tear_down_test
