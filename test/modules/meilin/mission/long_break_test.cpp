// A match whose process could not run for long: it stands until a person begins it again. The
// actuator with the real controller, on /clock.

#include <gmock/gmock.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/action_of_motion_interfaces/move_to_pose.hpp"
#include "musher/messages/r2_interfaces/arm_action.hpp"
#include "musher/messages/r2_interfaces/spear_action.hpp"
#include "musher/messages/r2_interfaces/start_autonomy.hpp"
#include "musher/messages/r2_interfaces/suspension_control.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/mission/meilin_actuator.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/service.hpp"

namespace musher::meilin::long_break_test {

using ::testing::HasSubstr;

// With the name of the harness's config.
class Played : public MeilinActuator {
 public:
  explicit Played(MissionConfig config) : MeilinActuator("show", std::move(config), {}) {}
  template <class Look>
  auto Of(Look look) {
    decltype(look(*this)) found{};
    RunOnLoop([&] { found = look(*this); });
    return found;
  }
  using TreeActuator::CheckNotLate;
  using TreeActuator::Now;
};

MissionConfig Stage() {
  MissionConfig config;
  config.tree_file = SourceDir() + "/config/meilin/meilin_stage.xml";
  config.self_check_s = 0.2;  // within the checkpoint of the harness's config
  return config;
}

class AMatchAfterALongSuspension : public ::testing::Test {
 protected:
  AMatchAfterALongSuspension() {
    Loop([this] {
      transport::Node& node = harness_.node().node();
      Serve<msg::MoveToPose>(kMoveServer);
      Serve<msg::SuspensionControl>(kSuspensionServer);
      Serve<msg::ArmAction>(kArmServer);
      Serve<msg::SpearAction>(kSpearServer);
      Follow("meilin/state", state_);
      Follow("meilin/status", status_);
      plans_ = transport::MakePublisher<msg::Float32MultiArray>(node, "mf_action_seq",
                                                                transport::kLatchedQos)
                   .value();
      client_ = transport::MakeClient<msg::StartAutonomy>(node, "start_autonomy").value();
    });
  }
  ~AMatchAfterALongSuspension() override {
    Loop([this] {
      client_.reset();
      plans_.reset();
      subscriptions_.clear();
      servers_.clear();
      kept_.clear();
    });
  }
  void SetUp() override {
    harness_.Open(match_, thread_);
    ASSERT_TRUE(testing::Until([this] { return Go("SelfCheck"); })) << "the servers are found";
    ASSERT_TRUE(Go("Active"));
  }

  void Loop(const std::function<void()>& work) { harness_.node().RunOnLoop(work); }
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  // A goal of that action is counted, and ends only by its cancellation.
  template <msg::Action A>
  void Serve(const std::string& name) {
    transport::ActionHandlers<A> handlers;
    handlers.start = [this](transport::ServerGoal<A> goal) {
      ++goals_;
      kept_.push_back(std::make_shared<transport::ServerGoal<A>>(std::move(goal)));
    };
    handlers.cancel = [this](transport::ServerGoal<A> goal) {
      ++cancelled_;
      goal.Canceled({});
    };
    servers_.push_back(std::shared_ptr<transport::ActionServer<A>>(
        transport::MakeActionServer<A>(harness_.node().node(), name, std::move(handlers)).value()));
  }
  void Follow(const std::string& topic, std::string& text) {
    subscriptions_.push_back(
        transport::MakeSubscription<msg::String>(
            harness_.node().node(), topic,
            [&text](const msg::String& sample, const auto&) { text = sample.data; },
            transport::kLatchedQos)
            .value());
  }
  // The word of a person; the reply, once it has come.
  std::shared_ptr<std::optional<std::string>> Begin() {
    auto reply = std::make_shared<std::optional<std::string>>();
    Loop([&] {
      client_->Call({"full"}, std::chrono::minutes(1), [reply](const auto& result) {
        *reply = result ? result.value().message : result.error().message;
      });
    });
    return reply;
  }
  // Until it holds on the loop.
  bool Await(const std::function<bool()>& holds) {
    return testing::Until([&] {
      bool met = false;
      Loop([&] { met = holds(); });
      return met;
    });
  }
  bool AwaitState(const std::string& state) {
    return Await([&] { return state_ == state; });
  }

  // A person has begun the match, and it waits for a plan.
  void AwaitPlan() {
    const auto begun = Begin();
    const auto second = Begin();  // its reply: the first one has arrived
    ASSERT_TRUE(Await([&] { return second->has_value(); }));
    harness_.Advance(match_, Mission::kStartWait + Milliseconds(100));  // no pose comes
    ASSERT_TRUE(Await([&] { return begun->has_value(); }));
    ASSERT_EQ(**begun, "begins with the region full");
    harness_.Tick(match_, 5);
    ASSERT_TRUE(AwaitState("WAITING_MF_ACTION_SEQ"));
  }
  void SendPlan() {
    Loop([&] { EXPECT_TRUE(plans_->Publish(ToActionSequence({{false, {0, 1}, 0, 0}}))); });
    ASSERT_TRUE(Await([&] { return status_.find("\"plans\":1") != std::string::npos; }));
  }

  testing::Harness harness_;
  const std::shared_ptr<testing::SuspendedThread> thread_ =
      std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Played> match_{Stage()};
  int goals_ = 0;
  int cancelled_ = 0;
  std::string state_;
  std::string status_;
  std::vector<std::shared_ptr<void>> kept_;
  std::vector<std::shared_ptr<void>> servers_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> plans_;
  std::unique_ptr<transport::Client<msg::StartAutonomy>> client_;
};

// It was sent while the computer was suspended, and the person has long gone.
TEST_F(AMatchAfterALongSuspension, RefusesAStartThatWaitedMeanwhile) {
  thread_->SuspendEachTime(std::chrono::seconds(9));
  const auto late = Begin();
  ASSERT_TRUE(Await([&] { return late->has_value(); }));
  EXPECT_THAT(**late, testing::HasRefusal(ApplicationRefusal::kMayBeLate));
  thread_->SuspendEachTime({});
  harness_.Advance(match_, Mission::kStartWait + Milliseconds(100));
  EXPECT_TRUE(AwaitState("WAITING_START"));
}

// The match was begun, and the plan was sent while the computer was suspended.
TEST_F(AMatchAfterALongSuspension, RefusesAPlanThatWaitedMeanwhile) {
  ASSERT_NO_FATAL_FAILURE(AwaitPlan());
  thread_->SuspendEachTime(std::chrono::seconds(9));
  const msg::Float32MultiArray plan = ToActionSequence({{false, {0, 1}, 0, 0}});
  Loop([&] { EXPECT_TRUE(plans_->Publish(plan)); });
  ASSERT_TRUE(Await([&] { return status_.find("\"refusals\":1") != std::string::npos; }));
  Loop([&] { EXPECT_THAT(status_, HasSubstr("the request may be as old")); });
  thread_->SuspendEachTime({});
  harness_.Tick(match_, 20);
  Loop([&] { EXPECT_EQ(goals_, 0); });
  ASSERT_TRUE(testing::Until(
      [&] { return match_.Of([](Played& match) { return match.CheckNotLate().ok(); }); }));
  ASSERT_NO_FATAL_FAILURE(SendPlan());
  harness_.Tick(match_, 20);
  EXPECT_TRUE(Await([&] { return goals_ == 1; })) << "it was sent once more";
}

// It would have begun with the first pose that came, and a plan would have moved it.
TEST_F(AMatchAfterALongSuspension, RefusesTheStartThatWaitedForThePose) {
  const auto first = Begin();
  const auto second = Begin();
  ASSERT_TRUE(Await([&] { return second->has_value(); }));
  ASSERT_EQ(**second, "another start waits for the first pose of the robot");
  Loop([&] { ASSERT_FALSE(first->has_value()); });
  thread_->Suspend(std::chrono::minutes(2));
  harness_.Tick(match_, 1);
  ASSERT_TRUE(Await([&] { return first->has_value(); }));
  EXPECT_EQ(**first, "its process could not run before the match could begin");
}

// The server of a goal that runs on another computer does not see the break.
TEST_F(AMatchAfterALongSuspension, HasCancelledTheGoalThatWasUnderWay) {
  ASSERT_NO_FATAL_FAILURE(AwaitPlan());
  ASSERT_NO_FATAL_FAILURE(SendPlan());
  harness_.Tick(match_, 20);
  ASSERT_TRUE(Await([&] { return goals_ == 1; }));
  thread_->Suspend(std::chrono::minutes(2));
  harness_.Tick(match_, 1);
  EXPECT_TRUE(AwaitState("WAITING_START"));
  EXPECT_TRUE(Await([&] { return cancelled_ == 1; }));
}

TEST_F(AMatchAfterALongSuspension, StandsUntilAPersonBeginsAlsoWhereAPlanComes) {
  ASSERT_NO_FATAL_FAILURE(AwaitPlan());
  thread_->Suspend(std::chrono::minutes(2));
  harness_.Tick(match_, 1);
  ASSERT_TRUE(AwaitState("WAITING_START"));
  ASSERT_NO_FATAL_FAILURE(SendPlan());
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(match_, 20);
  ASSERT_TRUE(testing::Until(
      [&] { return match_.Of([](Played& match) { return match.CheckNotLate().ok(); }); }));
  // The goals of a match that had begun by itself would have arrived before the second reply.
  const auto again = Begin();
  const auto other = Begin();
  ASSERT_TRUE(Await([&] { return other->has_value(); }));
  Loop([&] {
    EXPECT_EQ(goals_, 0);
    EXPECT_EQ(state_, "WAITING_START");
  });
  harness_.Advance(match_, Mission::kStartWait + Milliseconds(100));
  ASSERT_TRUE(Await([&] { return again->has_value(); }));
  EXPECT_THAT(**again, HasSubstr("begins with the region full"));
  harness_.Tick(match_, 20);
  EXPECT_TRUE(Await([&] { return goals_ == 1; })) << "of the plan that waited";
}

}  // namespace musher::meilin::long_break_test
