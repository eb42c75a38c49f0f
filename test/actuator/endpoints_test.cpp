// Topics and services that a module opens in SetUp.

#include "musher/transport/endpoints.hpp"

#include <gmock/gmock.h>

#include <future>

#include "musher/actuator/callback_harness.hpp"
#include "musher/actuator/machine_actuator.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/test/actuator/robot_file.hpp"

namespace musher::endpoints_test {

using testing::kAllStates;
using testing::RobotFile;

// Counts its calls, and says whether it ticks.
class Counter : public MachineActuator {
 public:
  explicit Counter(std::string service = "count") : MachineActuator("counter") {
    RegisterStateCallback([](const State&) { return kCodeOk; });
    RegisterStateCallback(kSetUp, [this, service = std::move(service)] {
      return OpenEndpoints([this, service](transport::Endpoints& wire) {
        const auto kept = std::make_shared<bool>(true);
        kept_ = kept;
        wire.Serve<msg::SetBool>(service, [this, kept](const auto&, const auto& reply) {
          reply({*kept, std::to_string(++calls_)});
        });
        wire.Every(Milliseconds(1), [this] {
          if (++ticks_ == 1) ticked_.set_value();
        });
      });
    });
  }

  std::future<void> ticked() { return ticked_.get_future(); }
  // Lives as long as what was opened.
  const std::weak_ptr<bool>& kept() const { return kept_; }

 private:
  std::weak_ptr<bool> kept_;
  int calls_ = 0;
  int ticks_ = 0;
  std::promise<void> ticked_;
};

Result<msg::SetBool::Response> CallCount(transport::NodeThread& node, const std::string& name) {
  std::unique_ptr<transport::Client<msg::SetBool>> client;
  std::promise<Result<msg::SetBool::Response>> promise;
  node.RunOnLoop([&] {
    client = transport::MakeClient<msg::SetBool>(node.node(), name).value();
    client->Call({true}, std::chrono::seconds(120),
                 [&](auto answer) { promise.set_value(std::move(answer)); });
  });
  auto answer = promise.get_future().get();
  node.RunOnLoop([&] { client.reset(); });
  return answer;
}

TEST(Endpoints, AreOpenInTheRobotsNamespaceUntilTheModuleEnds) {
  const RobotFile file({"counter"}, kAllStates);
  const auto other = transport::NodeThread::Start().value();
  ActuatorRunner<Counter> counter;
  ASSERT_TRUE(counter.Init(file.path()));
  ASSERT_TRUE(counter.Start());
  const auto answer = CallCount(*other, file.name_space() + "/count");
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer.value().message, "1");
  EXPECT_EQ(counter.ticked().wait_for(std::chrono::seconds(120)), std::future_status::ready);
  counter.Shutdown();
  EXPECT_TRUE(counter.kept().expired());
}

TEST(Endpoints, ThatCannotBeOpenedFailSetUp) {
  const RobotFile file({"counter"}, kAllStates);
  ActuatorRunner<Counter> counter("no such name");
  ASSERT_TRUE(counter.Init(file.path()));
  EXPECT_FALSE(counter.Start());
}

TEST(Endpoints, AreNotOpenedAfterTheFirstThatFails) {
  const auto node = transport::NodeThread::Start().value();
  node->RunOnLoop([&] {
    transport::Endpoints wire(node->node(), "test");
    EXPECT_NE(wire.Advertise<msg::Bool>("first"), nullptr);
    EXPECT_EQ(wire.Advertise<msg::Bool>("no such name"), nullptr);
    EXPECT_EQ(wire.Advertise<msg::Bool>("nor this one"), nullptr);
    EXPECT_EQ(wire.Subscribe<msg::Bool>("third", [](const msg::Bool&) {}), nullptr);
    ASSERT_FALSE(wire.opened());
    EXPECT_THAT(wire.opened().error().message, ::testing::HasSubstr("no such name"));
  });
}

TEST(Endpoints, AreClosedInTheReverseOrder) {
  const auto node = transport::NodeThread::Start().value();
  std::vector<int> closed;
  node->RunOnLoop([&] {
    transport::Endpoints wire(node->node(), "test");
    for (const int i : {1, 2, 3}) {
      wire.Keep(std::shared_ptr<void>(nullptr, [&closed, i](void*) { closed.push_back(i); }));
    }
  });
  EXPECT_THAT(closed, ::testing::ElementsAre(3, 2, 1));
}

TEST(Endpoints, AreNotThereInATrial) {
  ActuatorRunner<Counter> counter;
  CallbackHarness callbacks(counter);
  EXPECT_TRUE(callbacks.Run(State(kSetUp)));
  EXPECT_TRUE(counter.kept().expired()) << "nothing was opened";
  int runs = 0;
  counter.RunOnLoop([&] { ++runs; });
  EXPECT_EQ(runs, 1) << "at once";
}

TEST(EmergencyStopped, IsAsTheMachineReports) {
  ActuatorRunner<Counter> counter;
  CallbackHarness callbacks(counter);
  EXPECT_FALSE(counter.EmergencyStopped());
  ActuatorReport report;
  report.emergency_stop = 7;
  callbacks.SetReport(report);
  EXPECT_TRUE(counter.EmergencyStopped());
}

}  // namespace musher::endpoints_test
