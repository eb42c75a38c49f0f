// Which controller an actuator obeys, and what it does without a controller.

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/lifecycle/one_actuator.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::actuator_authority_test {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
using actuator_event::CallbackEnded;
using actuator_event::ControllerHeartbeatReceived;
using actuator_event::QueryArrived;
using actuator_event::SwitchArrived;
using actuator_event::TimePassed;
using ::testing::_;
using testing::Actions;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::VariantWith;

constexpr Sender kUnknownSender = 999;

class ObeyedController : public testing::OneActuator {
 protected:
  ObeyedController() {
    SetUpIt();
    Do(QueryArrived{0, {1, 0, false}, 1});  // the controller of epoch 1 has taken control
  }
};

TEST_F(ObeyedController, ASenderThatHasNotAnnouncedItselfIsRefused) {
  SwitchArrived command = Command(1, "Active", 2);
  const Answer answer = AnswerIn(Do(command));
  EXPECT_EQ(answer.code, kCodePermissionDenied);
  EXPECT_THAT(answer.message, HasSubstr("no controller of epoch 2 has announced itself"));
  EXPECT_EQ(core_.report.epoch, Epoch(1));
}

TEST_F(ObeyedController, AnAnnouncedControllerTakesControlFromThePreviousOne) {
  Announce(2);
  EXPECT_THAT(Do(Command(1, "Active", 2)),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
  EXPECT_EQ(core_.report.epoch, Epoch(2));
  EXPECT_EQ(AnswerIn(Do(Command(2, "DeActive", 1))).code, kCodePermissionDenied);
}

TEST_F(ObeyedController, AWaitingCommandIsDroppedWhenAnotherControllerTakesOver) {
  Do(Command(1, "LowPower"));
  Do(Command(2, "DeActive"));  // waits for the running callback
  Announce(2);
  const Actions taken_over = Do(QueryArrived{0, {2, 1, false}, 2});
  EXPECT_THAT(AnswerIn(taken_over).message, HasSubstr("epoch 2 has taken over"));
  EXPECT_THAT(Do(CallbackEnded{}), Not(Contains(VariantWith<RunCallback>(_))));
  EXPECT_EQ(core_.report.state, "LowPower");
}

TEST_F(ObeyedController, AnAnnouncementAloneChangesNothing) {
  Announce(2);
  EXPECT_THAT(Do(Command(1, "Active", 1)),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

TEST_F(ObeyedController, TheSameEpochFromAnotherSenderIsRefused) {
  SwitchArrived command = Command(1, "Active", 1);
  command.sender = kUnknownSender;
  Do(ControllerHeartbeatReceived{kUnknownSender, 1});
  const Answer answer = AnswerIn(Do(command));
  EXPECT_EQ(answer.code, kCodePermissionDenied);
  EXPECT_THAT(answer.message, HasSubstr("another controller"));
  EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {1, 5, true}, kUnknownSender})).code,
            kCodePermissionDenied);
  EXPECT_EQ(core_.report.number, CommandNumber(0)) << "its query fences nothing";
}

class NoControllerYet : public testing::OneActuator {
 protected:
  NoControllerYet() { SetUpIt(); }
};

// An actuator without a controller so far has epoch 0 and sender 0: both matched a command of an
// unknown participant.
TEST_F(NoControllerYet, ACommandOfAnUnknownSenderIsRefused) {
  Do(ControllerHeartbeatReceived{0, 0});
  Do(ControllerHeartbeatReceived{0, 3});
  for (const Epoch epoch : {Epoch(0), Epoch(3)}) {
    SwitchArrived command = Command(1, "Active", epoch);
    command.sender = 0;
    const Actions actions = Do(command);
    EXPECT_EQ(AnswerIn(actions).code, kCodePermissionDenied) << epoch;
    EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(_)))) << epoch;
    EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {epoch, 5, true}, 0})).code, kCodePermissionDenied);
  }
  EXPECT_EQ(core_.report.epoch, Epoch(0));
  EXPECT_EQ(core_.report.number, CommandNumber(0)) << "its query fences nothing";
}

TEST_F(ObeyedController, ASenderCannotUseTheEpochThatAnotherAnnounced) {
  Announce(2);
  SwitchArrived command = Command(1, "Active", 2);
  command.sender = kUnknownSender;
  EXPECT_EQ(AnswerIn(Do(command)).code, kCodePermissionDenied);
}

TEST_F(ObeyedController, AnEpochOutOfRangeIsRefusedEvenIfItIsAnnounced) {
  for (const Epoch epoch : {kLastEpoch + 1, Epoch(std::numeric_limits<std::uint64_t>::max())}) {
    Do(ControllerHeartbeatReceived{kUnknownSender, epoch});
    SwitchArrived command = Command(1, "Active", epoch);
    command.sender = kUnknownSender;
    EXPECT_EQ(AnswerIn(Do(command)).code, kCodeParametersInvalid);
  }
  EXPECT_EQ(core_.report.epoch, Epoch(1));
  Announce(2);
  EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {2, 0, false}, 2})).verdict, Verdict::kDone)
      << "a controller with a valid epoch still takes control";
}

TEST_F(ObeyedController, AnAnnouncementOfALowerEpochDoesNotHideAHigherOne) {
  Announce(5);
  Announce(3);
  EXPECT_THAT(Do(Command(1, "Active", 5)),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
  EXPECT_EQ(AnswerIn(Do(Command(2, "LowPower", 3))).code, kCodePermissionDenied);
}

TEST_F(ObeyedController, AnnouncementsOfAnEpochOutOfRangeDoNotHideOthers) {
  Do(ControllerHeartbeatReceived{666, Epoch(UINT64_MAX)});
  Announce(5);
  EXPECT_THAT(Do(Command(1, "Active", 5)),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

// Without a controller

class ControllerLost : public ObeyedController {
 protected:
  ControllerLost() {
    ActuatorConfig& actuator = config_.actuators[0];
    actuator.controller_lost = Milliseconds(2000);
    actuator.on_controller_lost = "DeActive";
    Switch(1, "Active");
  }
  // Time passes without a sample; the actions of the actuator at the end.
  Actions After(Duration duration) {
    now_ += duration;
    return Do(TimePassed{});
  }
  // A command of now that does not become too old on its way.
  SwitchArrived Lasting(CommandNumber n, const State& target) {
    SwitchArrived command = Command(n, target);
    command.command.budget = std::chrono::seconds(10);
    return command;
  }
  std::optional<Time> Deadline() const { return NextDeadline(config_, 0, core_); }
};

TEST_F(ControllerLost, GoesToItsSafeStateByItselfAfterItsTimeout) {
  EXPECT_EQ(Deadline(), now_ + Milliseconds(2000));
  EXPECT_THAT(After(Milliseconds(1999)), IsEmpty());
  EXPECT_THAT(After(Milliseconds(1)), Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
  EXPECT_TRUE(core_.report.busy());
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "DeActive");
  EXPECT_FALSE(Deadline()) << "it is safe now";
}

TEST_F(ControllerLost, AnySampleOfItsControllerIsEnoughToStay) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_THAT(After(Milliseconds(1900)), IsEmpty());
    Announce(1);
  }
  EXPECT_THAT(After(Milliseconds(1900)), IsEmpty());
  Do(QueryArrived{0, {1, 0, false}, 1});
  EXPECT_THAT(After(Milliseconds(1900)), IsEmpty());
}

TEST_F(ControllerLost, SamplesOfAnotherControllerDoNotCount) {
  now_ += Milliseconds(1000);
  Do(ControllerHeartbeatReceived{kUnknownSender, 9});
  now_ += Milliseconds(500);
  Do(SwitchArrived{3, {1, 2, "LowPower", Milliseconds(100), now_, {}, 77}, kUnknownSender});
  EXPECT_THAT(After(Milliseconds(500)),
              Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(ControllerLost, NeverGoesUpForIt) {
  Switch(2, "LowPower");
  EXPECT_FALSE(Deadline());
  EXPECT_THAT(After(std::chrono::hours(1)), IsEmpty());
  EXPECT_EQ(core_.report.state, "LowPower");
}

TEST_F(ControllerLost, WaitsForACallbackThatRuns) {
  Do(Command(2, "LowPower"));
  EXPECT_FALSE(Deadline());
  EXPECT_THAT(After(std::chrono::hours(1)), IsEmpty());
  Do(CallbackEnded{kCodeFailed, "stuck"});
  EXPECT_LE(*Deadline(), now_);
  EXPECT_THAT(After({}), Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(ControllerLost, ACallbackThatFailsIsRetriedAfterTheSameTimeoutAndNotAtOnce) {
  EXPECT_THAT(After(Milliseconds(2000)),
              Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
  Do(CallbackEnded{5001, "stuck"});
  EXPECT_GT(*Deadline(), now_);
  EXPECT_THAT(After(Milliseconds(1999)), IsEmpty());
  EXPECT_THAT(After(Milliseconds(1)), Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(ControllerLost, ASwitchByItselfIsNotTheOutcomeOfACommand) {
  After(Milliseconds(2000));
  Do(CallbackEnded{5001, "stuck"});
  EXPECT_EQ(core_.report.outcome_number, CommandNumber(1));
  EXPECT_EQ(core_.report.outcome_code, kCodeOk);
  EXPECT_EQ(AnswerIn(Do(Command(1, "Active"))).verdict, Verdict::kDone) << "repeated";
}

TEST_F(ControllerLost, ReturnsAtTheCommandOfItsController) {
  After(Milliseconds(2000));
  Do(CallbackEnded{});
  Switch(2, "Active");
  EXPECT_EQ(Deadline(), now_ + Milliseconds(2000));
}

TEST_F(ControllerLost, ACommandOfItsControllerWaitsBehindTheWayToTheSafeState) {
  After(Milliseconds(2000));
  Do(Command(2, "LowPower"));
  EXPECT_THAT(Do(CallbackEnded{}), Contains(VariantWith<RunCallback>(RunCallback{"LowPower"})));
}

// The link was cut, and delivered afterwards what had been sent.
TEST_F(ControllerLost, ACommandFromBeforeItWentToItsSafeStateSwitchesNothingOn) {
  const SwitchArrived late = Lasting(2, "Active");
  const SwitchArrived down = Lasting(3, "LowPower");
  After(Milliseconds(2000));
  Do(CallbackEnded{});
  EXPECT_THAT(AnswerIn(Do(late)), testing::IsRefused(Refusal::kCommandBeforeSafeState));
  EXPECT_FALSE(core_.report.busy());
  Do(down);
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "LowPower") << "it leads down";
  Switch(4, "Active");
}

TEST_F(ControllerLost, ACommandFromBeforeThatWaitsBehindTheWayToTheSafeStateSwitchesNothingOn) {
  const SwitchArrived late = Lasting(2, "Active");
  After(Milliseconds(2000));
  Do(late);
  EXPECT_THAT(AnswerIn(Do(CallbackEnded{})), testing::IsRefused(Refusal::kCommandBeforeSafeState));
  EXPECT_EQ(core_.report.state, "DeActive");
  EXPECT_FALSE(core_.report.busy());
}

TEST_F(ControllerLost, StaysDetachedWhenTheWayToItsSafeStateFails) {
  SwitchArrived alone = Command(2, "Active");
  alone.command.detached = true;
  Do(alone);
  ASSERT_TRUE(core_.report.detached);
  After(Milliseconds(2000));
  Do(CallbackEnded{5001, "stuck"});
  EXPECT_TRUE(core_.report.detached);
}

class NeverControlled : public testing::OneActuator {};

TEST_F(NeverControlled, AnActuatorThatNoControllerControlsWaitsForEver) {
  config_.actuators[0].controller_lost = Milliseconds(2000);
  config_.actuators[0].on_controller_lost = "LowPower";
  SetUpIt();
  core_.report.state = "DeActive";
  EXPECT_FALSE(NextDeadline(config_, 0, core_));
}

}  // namespace musher::actuator_authority_test
