#include "musher/actuator/machine_actuator.hpp"

#include <gmock/gmock.h>

#include <future>
#include <stdexcept>
#include <thread>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/actuator/robot_file.hpp"

namespace musher::machine_actuator_test {

using ::testing::HasSubstr;
using testing::kAllStates;
using testing::RobotFile;

void RegisterAll(MachineActuator& actuator, const std::vector<std::string>& states) {
  for (const std::string& state : states) {
    actuator.RegisterStateCallback(State(state), [] { return kCodeOk; });
  }
}

TEST(MachineActuator, IsInSetUpOnceItHasStarted) {
  const RobotFile file({"arm"}, kAllStates);
  ActuatorRunner<MachineActuator> arm("arm");
  RegisterAll(arm, kAllStates);
  EXPECT_EQ(arm.CurrentState(), "Uninitialized");
  ASSERT_TRUE(arm.Init(file.path()));
  ASSERT_TRUE(arm.Start());
  EXPECT_EQ(arm.CurrentState(), "SetUp");
}

// A module with a topic of its own, as the header describes.
class Singer : public MachineActuator {
 public:
  Singer() : MachineActuator("singer") {
    RegisterStateCallback([](const State&) { return kCodeOk; });
    RegisterStateCallback(kSetUp, [this] { return OpenTopic(); });
  }
  ~Singer() override {
    if (node_) node_->RunOnLoop([this] { subscription_.reset(); });
  }
  std::future<std::string> subscription() { return word_.get_future(); }

 private:
  Result<> OpenTopic() {
    node_ = node();
    Result<> result = Ok();
    node_->RunOnLoop([&] {
      const std::string topic =
          transport::ResolveName(machine_config().name_space, "song_of_" + name());
      auto subscription = transport::MakeSubscription<msg::String>(
          node_->node(), topic,
          [this](const msg::String& word, const auto&) { word_.set_value(word.data); },
          transport::kLatchedQos);
      if (!subscription) result = subscription.error();
      if (subscription) subscription_ = std::move(subscription).value();
    });
    return result;
  }

  std::promise<std::string> word_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<transport::Subscription> subscription_;
};

TEST(MachineActuator, HasTopicsOfItsOwnOnItsLoop) {
  const RobotFile file({"singer"}, kAllStates);
  const auto other = transport::NodeThread::Start();
  ASSERT_TRUE(other);
  std::unique_ptr<transport::Publisher<msg::String>> publisher;
  other.value()->RunOnLoop([&] {
    auto made = transport::MakePublisher<msg::String>(
        other.value()->node(), file.name_space() + "/song_of_singer", transport::kLatchedQos);
    if (!made) return;
    publisher = std::move(made).value();
    static_cast<void>(publisher->Publish({"la"}));
  });
  ASSERT_NE(publisher, nullptr);
  {
    ActuatorRunner<Singer> singer;
    auto subscription = singer.subscription();
    EXPECT_EQ(singer.node(), nullptr);
    ASSERT_TRUE(singer.Init(file.path()));
    ASSERT_TRUE(singer.Start());
    ASSERT_EQ(subscription.wait_for(std::chrono::seconds(120)), std::future_status::ready);
    EXPECT_EQ(subscription.get(), "la");
  }
  other.value()->RunOnLoop([&] { publisher.reset(); });
}

TEST(MachineActuator, ReportsAStateWithoutACallback) {
  const RobotFile file({"arm"}, kAllStates);
  ActuatorRunner<MachineActuator> arm("arm");
  RegisterAll(arm, {"SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower",
                    "Error"});
  ASSERT_TRUE(arm.Init(file.path()).ok());
  const Result<> started = arm.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().code, kCodeParametersInvalid);
  EXPECT_THAT(started.error().message, HasSubstr("state 'OTA'"));
}

TEST(MachineActuator, ReportsACallbackWithoutAState) {
  const RobotFile file({"arm"}, {"SetUp", "TearDown", "SelfCheck", "Active"});
  ActuatorRunner<MachineActuator> arm("arm");
  RegisterAll(arm, {"SetUp", "TearDown", "SelfCheck", "Active", "LowPower"});
  ASSERT_TRUE(arm.Init(file.path()).ok());
  const Result<> started = arm.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message, HasSubstr("state 'LowPower'"));
}

TEST(MachineActuator, ReportsAStateWithTwoCallbacks) {
  const RobotFile file({"arm"}, kAllStates);
  ActuatorRunner<MachineActuator> arm("arm");
  RegisterAll(arm, kAllStates);
  RegisterAll(arm, {"Active"});
  ASSERT_TRUE(arm.Init(file.path()).ok());
  EXPECT_THAT(arm.Start().error().message, HasSubstr("two callbacks for state 'Active'"));
}

TEST(MachineActuator, ReportsTheErrorInTheConfigWithItsLine) {
  const RobotFile file({"arm"}, kAllStates, {{"SetUp", -5}});
  ActuatorRunner<MachineActuator> arm("arm");
  const Result<> initialised = arm.Init(file.path());
  ASSERT_FALSE(initialised.ok());
  EXPECT_THAT(initialised.error().message, HasSubstr("robot.toml:10:10: error:"));
}

TEST(MachineActuator, ReportsAConfigWithoutAnActuatorOfItsName) {
  const RobotFile file({"arm"}, kAllStates);
  ActuatorRunner<MachineActuator> leg("leg");
  EXPECT_THAT(leg.Init(file.path()).error().message, HasSubstr("no actuator 'leg'"));
}

TEST(MachineActuator, DoesNotStartWithoutInit) {
  ActuatorRunner<MachineActuator> arm("arm");
  EXPECT_EQ(arm.Start().error().code, kCodeUninitialized);
}

TEST(MachineActuator, GivesTheCodeAndMessageOfASetUpThatFailed) {
  const RobotFile file({"arm"}, {"SetUp"});
  ActuatorRunner<MachineActuator> arm("arm");
  arm.RegisterStateCallback("SetUp", []() -> Result<> { return Error{3012, "no motor"}; });
  ASSERT_TRUE(arm.Init(file.path()).ok());
  const Result<> started = arm.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error(), (Error{3012, "no motor"}));
}

TEST(MachineActuator, TreatsAnExceptionAsAFailureAndReportsItsText) {
  const RobotFile file({"arm"}, {"SetUp"});
  ActuatorRunner<MachineActuator> arm("arm");
  arm.RegisterStateCallback("SetUp", []() -> Result<> { throw std::runtime_error("cable loose"); });
  ASSERT_TRUE(arm.Init(file.path()).ok());
  const Result<> started = arm.Start();
  EXPECT_EQ(started.error().code, kCodeFailed);
  EXPECT_THAT(started.error().message, HasSubstr("cable loose"));
}

TEST(MachineActuator, RunsOnceOnAHost) {
  const RobotFile file({"arm"}, {"SetUp"});
  ActuatorRunner<MachineActuator> first("arm");
  RegisterAll(first, {"SetUp"});
  ASSERT_TRUE(first.Init(file.path()).ok());
  ASSERT_TRUE(first.Start().ok());
  ActuatorRunner<MachineActuator> second("arm");
  RegisterAll(second, {"SetUp"});
  ASSERT_TRUE(second.Init(file.path()).ok());
  EXPECT_EQ(second.Start().error().code, kCodeTargetBusy);
  first.Shutdown();
  ActuatorRunner<MachineActuator> third("arm");
  RegisterAll(third, {"SetUp"});
  ASSERT_TRUE(third.Init(file.path()).ok());
  EXPECT_TRUE(third.Start().ok()) << "the name is free again";
}

TEST(MachineActuator, SharesANodeWithOthersOfItsProcess) {
  const RobotFile file({"arm", "leg"}, {"SetUp"});
  const auto node = transport::NodeThread::Start();
  ASSERT_TRUE(node.ok());
  ActuatorRunner<MachineActuator> arm("arm");
  ActuatorRunner<MachineActuator> leg("leg");
  for (ActuatorRunner<MachineActuator>* actuator : {&arm, &leg}) {
    RegisterAll(*actuator, {"SetUp"});
    ASSERT_TRUE(actuator->Init(file.path(), node.value()).ok());
    ASSERT_TRUE(actuator->Start().ok());
  }
}

TEST(MachineActuator, EndsItsWaitWhenItIsShutDown) {
  const RobotFile file({"arm"}, {"SetUp"});
  ActuatorRunner<MachineActuator> arm("arm");
  RegisterAll(arm, {"SetUp"});
  ASSERT_TRUE(arm.Init(file.path()).ok());
  ASSERT_TRUE(arm.Start().ok());
  std::thread ender([&] { arm.Shutdown(); });
  EXPECT_EQ(arm.Wait(), 0);
  ender.join();
}

TEST(MachineActuator, IsShutDownWhenItsWaitHasEnded) {
  const RobotFile file({"arm"}, {"SetUp"});
  ActuatorRunner<MachineActuator> first("arm");
  RegisterAll(first, {"SetUp"});
  ASSERT_TRUE(first.Init(file.path()).ok());
  ASSERT_TRUE(first.Start().ok());
  first.GiveUp({kCodeFailed, "the cable is loose"});
  EXPECT_EQ(first.Wait(), 1);
  ActuatorRunner<MachineActuator> second("arm");
  RegisterAll(second, {"SetUp"});
  ASSERT_TRUE(second.Init(file.path()).ok());
  EXPECT_TRUE(second.Start().ok()) << "the name is free again";
}

template <class Actuator>
concept CanBeStarted = requires(Actuator& actuator) {
  actuator.Start();
};
static_assert(!CanBeStarted<MachineActuator> && !CanBeStarted<Singer>);
static_assert(CanBeStarted<ActuatorRunner<Singer>>);

// Starts itself, and is stopped by no ActuatorRunner.
class CarelessSinger : public Singer {
 public:
  Result<> Begin() { return Start(); }
};

// Its callbacks would use members that are already destroyed.
TEST(MachineActuatorDeathTest, EndsTheProgramWhenADerivedOneIsDestroyedWhileItIsStarted) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        const RobotFile file({"singer"}, {"SetUp"});
        CarelessSinger singer;
        if (!singer.Init(file.path()) || !singer.Begin()) std::exit(3);
      },
      "singer is destroyed while it is started.*ActuatorRunner");
}

}  // namespace musher::machine_actuator_test
