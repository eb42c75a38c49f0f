// The policy's inputs: topics on the simulated transport, in virtual time.

#include "musher/controller/shell/policy_inputs.hpp"

#include <gmock/gmock.h>

#include <vector>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::policy_inputs_test {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class Inputs : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.name_space = "dog1";
    PolicyConfig& policy = config_.policy.emplace();
    policy.battery.emplace();
    policy.low_power.emplace().motion_ids = {0, 101};
  }
  void Open() {
    inputs_ = PolicyInputs::Make(*node_, config_, [this](const Event& event) {
                received_.push_back(event);
              }).value();
    batteries_ = Made(transport::MakePublisher<msg::BmsStatus>(*robot_, "dog1/bms_status"));
    motions_ = Made(transport::MakePublisher<msg::MotionStatus>(*robot_, "dog1/motion_status"));
    clocks_ = Made(transport::MakePublisher<msg::Clock>(*robot_, "clock", transport::kClockQos));
    network_.RunFor(seconds(1));
  }
  void Battery(int percent, bool charging = false) {
    msg::BmsStatus status;
    status.batt_soc = static_cast<std::uint8_t>(percent);
    status.power_wired_charging = charging;
    Pass(batteries_->Publish(status));
  }
  void Motion(std::int32_t id) {
    msg::MotionStatus status;
    status.motion_id = id;
    Pass(motions_->Publish(status));
  }
  void Clock(Duration time) { Pass(clocks_->Publish({msg::ToStamp(time)})); }
  // The events since the last call.
  std::vector<Event> TakeReceived() { return std::exchange(received_, {}); }

  MachineConfig config_;
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("controller");
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<PolicyInputs> inputs_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> batteries_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> motions_;
  std::unique_ptr<transport::Publisher<msg::Clock>> clocks_;

 private:
  template <class T>
  static T Made(Result<T> result) {
    return std::move(result).value();
  }
  void Pass(const Result<>& published) {
    EXPECT_TRUE(published.ok());
    network_.RunFor(Milliseconds(100));
  }

  std::vector<Event> received_;
};

TEST_F(Inputs, OfRepeatedSamplesChangesAndWhatConfirmsThemBecomeEvents) {
  Open();
  inputs_->Begin();
  for (const int percent : {80, 80, 80, 80, 80, 79, 79}) Battery(percent);
  Battery(79, true);
  for (const std::int32_t motion : {303, 304, 0, 101, 0, 303}) Motion(motion);
  EXPECT_THAT(
      TakeReceived(),
      ElementsAre(Event(event::BatterySeen{80, false}), Event(event::BatterySeen{80, false}),
                  Event(event::BatterySeen{80, false}), Event(event::BatterySeen{79, false}),
                  Event(event::BatterySeen{79, false}), Event(event::BatterySeen{79, true}),
                  Event(event::MotionSeen{303}), Event(event::MotionSeen{0}),
                  Event(event::MotionSeen{303})));
}

TEST_F(Inputs, SamplesFromBeforeTheBeginBecomeEventsAtTheBegin) {
  Open();
  Battery(50);
  Battery(49);
  EXPECT_THAT(TakeReceived(), IsEmpty());
  inputs_->Begin();
  EXPECT_THAT(TakeReceived(), ElementsAre(Event(event::BatterySeen{49, false})));
}

TEST_F(Inputs, SilenceIsReportedOnceAndTheSameValueAfterItAgain) {
  Open();
  inputs_->Begin();
  Motion(0);
  Battery(50);
  network_.RunFor(seconds(5));
  EXPECT_THAT(TakeReceived(),
              ElementsAre(Event(event::MotionSeen{0}), Event(event::BatterySeen{50, false}),
                          Event(event::InputSilent{PolicyInput::kMotion})));
  network_.RunFor(seconds(60));
  EXPECT_THAT(TakeReceived(), ElementsAre(Event(event::InputSilent{PolicyInput::kBattery})));
  Motion(0);
  Battery(50);
  EXPECT_THAT(TakeReceived(),
              ElementsAre(Event(event::MotionSeen{0}), Event(event::BatterySeen{50, false, 1})));
}

TEST_F(Inputs, EachPublisherOfTheBatteryHasANumberAndASilentOneIsReported) {
  Open();
  inputs_->Begin();
  Motion(0);
  for (int i = 0; i < 4; ++i) Battery(80);
  TakeReceived();
  const auto other = network_.MakeNode("other");
  const auto second = transport::MakePublisher<msg::BmsStatus>(*other, "dog1/bms_status").value();
  network_.RunFor(Milliseconds(100));
  msg::BmsStatus low;
  low.batt_soc = 15;
  ASSERT_TRUE(second->Publish(low).ok());
  network_.RunFor(Milliseconds(100));
  Battery(80);
  EXPECT_THAT(TakeReceived(), UnorderedElementsAre(Event(event::BatterySeen{15, false, 1}),
                                                   Event(event::BatterySeen{80, false, 0})))
      << "the known one is sent again, so that the doubling shows";
  for (int i = 0; i < 12; ++i) {
    network_.RunFor(seconds(1));
    Battery(80);
  }
  std::vector<Event> received = TakeReceived();
  std::erase(received, Event(event::InputSilent{PolicyInput::kMotion}));
  EXPECT_THAT(
      received,
      ElementsAre(Event(event::BatterySeen{80, false, 0}), Event(event::BatterySeen{80, false, 0}),
                  Event(event::BatterySourceSilent{1}), Event(event::BatterySeen{80, false, 0}),
                  Event(event::BatterySeen{80, false, 0}),
                  Event(event::BatterySeen{80, false, 0})));
}

TEST_F(Inputs, ABatteryThatKeepsPublishingIsNotSilent) {
  Open();
  inputs_->Begin();
  for (int i = 0; i < 60; ++i) {
    Battery(50);
    network_.RunFor(seconds(1));
  }
  EXPECT_THAT(TakeReceived(),
              UnorderedElementsAre(Event(event::BatterySeen{50, false}),
                                   Event(event::BatterySeen{50, false}),
                                   Event(event::BatterySeen{50, false}),
                                   Event(event::InputSilent{PolicyInput::kMotion})));
}

TEST_F(Inputs, TheTimeOfAWorldIsEmittedOnlyBeforeAnotherEventAndWhenDue) {
  config_.clock = ClockSource::kTopic;
  config_.policy->battery->silent = std::chrono::hours(1);
  config_.policy->low_power.reset();
  Open();
  inputs_->Begin();
  const auto at = [](int s) { return Event(event::ClockReceived{Time(seconds(s))}); };
  inputs_->WakeAt(Time(seconds(100)));
  Clock(seconds(40));  // the first: what was due keeps its distance
  EXPECT_THAT(TakeReceived(), ElementsAre(Event(event::ClockReceived{Time{}}), at(40)));
  inputs_->WakeAt(Time(seconds(50)));
  for (int s = 41; s < 50; ++s) Clock(seconds(s));
  EXPECT_THAT(TakeReceived(), IsEmpty());
  Clock(seconds(50));
  EXPECT_THAT(TakeReceived(), ElementsAre(at(50)));
  Clock(seconds(51));
  Battery(50);
  EXPECT_THAT(TakeReceived(), ElementsAre(at(51), Event(event::BatterySeen{50, false})));
  Clock(seconds(3));  // the world begins again
  EXPECT_THAT(TakeReceived(), ElementsAre(Event(event::ClockReceived{Time(seconds(3)), true})));
}

// A recording that a person skips by minutes: no publisher was silent meanwhile.
TEST_F(Inputs, NoInputIsSilentSinceTheClockHasJumpedForwards) {
  config_.clock = ClockSource::kTopic;
  Open();
  inputs_->Begin();
  Clock(seconds(40));
  Battery(50);
  TakeReceived();
  Clock(seconds(640));
  EXPECT_THAT(TakeReceived(), ElementsAre(Event(event::ClockReceived{Time(seconds(640)), true})));
}

TEST_F(Inputs, WithoutAPolicyThereAreNone) {
  config_.policy.reset();
  EXPECT_EQ(PolicyInputs::Make(*node_, config_, {}).value(), nullptr);
}

}  // namespace musher::policy_inputs_test
