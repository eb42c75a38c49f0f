// The link to a motion board on LCM, in virtual time: what it sends, and what it believes.

#include "musher/modules/motion/lcm_link.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion::testing::lcm_link_test {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr const char* kBoard = "192.168.44.233:40000";

class LcmLinkTest : public ::testing::Test {
 protected:
  // A response of the board now.
  LinkOutput Respond(std::int8_t mode, std::int8_t gait, std::int8_t status = 0) {
    BodyReport report;
    report.mode = mode;
    report.gait = gait;
    report.bar = 100;
    report.switch_status = status;
    return Respond(report);
  }
  LinkOutput Respond(const BodyReport& report) {
    return Keep(link_.OnResponse({kBoard, ++sequence_}, report, now_));
  }
  // Another host responds each 20 ms, beside the board if that responds.
  void RespondFrom(const std::string& name, Duration duration, std::int8_t mode = 7,
                   transport::HostPlace place = transport::HostPlace::kThisNetwork) {
    BodyReport report;
    report.mode = mode;
    report.gait = mode == 11 ? std::int8_t{27} : std::int8_t{0};
    for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(20))) {
      Keep(link_.OnResponse({name, ++sequence_, place}, report, now_));
    }
  }
  // Time passes, with a response each 20 ms if `responds_`.
  void RunFor(Duration duration, std::int8_t mode = 12, std::int8_t gait = 0,
              std::int8_t status = 0) {
    for (const Time end = now_ + duration; now_ < end;) {
      now_ += Milliseconds(1);
      if (responds_ && (now_ - Time{}) % Milliseconds(20) == Duration::zero()) {
        Respond(mode, gait, status);
      }
      if (now_ >= link_.NextDeadline()) Keep(link_.OnTime(now_));
    }
  }
  void Command(std::int8_t mode, std::int8_t gait, float speed = 0) {
    BodyCommand command;
    command.mode = mode;
    command.gait = gait;
    command.vel = {speed, 0, 0};
    command.life_count = ++life_;
    Keep(link_.OnCommand(command, now_));
  }
  LinkOutput Keep(LinkOutput output) {
    for (const BodyCommand& frame : output.frames) frames_.push_back(frame);
    for (const LinkFault& fault : output.faults) faults_.push_back(fault);
    if (output.body) bodies_.push_back(*output.body);
    if (output.held_by) held_by_ = *output.held_by;
    restarted_ = restarted_ || output.restarted;
    return output;
  }
  // A body that stands, held by the link.
  void Stand() {
    RunFor(Milliseconds(300));
    frames_.clear();
  }
  // The motion manager repeats its command.
  void Repeat(Duration duration, std::int8_t mode, std::int8_t gait) {
    BodyCommand command = *link_.frame();
    command.life_count = life_;
    for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(50), mode, gait)) {
      Keep(link_.OnCommand(command, now_));
    }
  }
  // This process is suspended: neither timers nor datagrams.
  void Hang(Duration duration) { now_ += duration; }
  int FramesOfMode(std::int8_t mode) const {
    return static_cast<int>(std::ranges::count(frames_, mode, &BodyCommand::mode));
  }
  int NewCounts() const {
    int counts = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (i == 0 || frames_[i].life_count != frames_[i - 1].life_count) ++counts;
    }
    return counts;
  }

  Time now_{std::chrono::hours(1)};
  LcmLink link_{now_};
  bool responds_ = true;
  std::uint32_t sequence_ = 0;
  std::int8_t life_ = 64;
  std::vector<BodyCommand> frames_;
  std::vector<LinkFault> faults_;
  std::vector<BodyState> bodies_;
  std::string held_by_;
  bool restarted_ = false;
};

TEST_F(LcmLinkTest, SendsNothingBeforeItHasLookedAtTheBoard) {
  responds_ = false;
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(1000));
  EXPECT_THAT(frames_, IsEmpty()) << "no response yet";
  responds_ = true;
  RunFor(Milliseconds(90));
  EXPECT_THAT(frames_, IsEmpty()) << "it looks for 100 ms";
}

TEST_F(LcmLinkTest, HoldsAStandingBodyWithTwoLifeCounts) {
  RunFor(Milliseconds(250));
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 12);
  EXPECT_EQ(NewCounts(), 2) << "one may be that of the commander before";
}

TEST_F(LcmLinkTest, StopsTheWalkOfALiftedBodyAndBeginsNone) {
  Stand();
  Command(11, 27, 0.5F);
  Repeat(Milliseconds(500), 11, 27);
  frames_.clear();
  RunFor(Milliseconds(100), 11, 27, 4);
  EXPECT_EQ(frames_.back().mode, 11);
  EXPECT_EQ(frames_.back().gait, 1);
  EXPECT_EQ(frames_.back().vel[0], 0);
  Command(11, 3, 0.5F);
  RunFor(Milliseconds(200), 11, 27, 4);
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.vel[0], 0);
}

TEST_F(LcmLinkTest, NamesAProgramThatMovesTheMotorsUntilTheBoardHasRestarted) {
  Stand();
  Command(11, 27, 0.5F);
  Repeat(Milliseconds(300), 11, 27);
  Keep(link_.OnMotorFrame("192.168.44.100:7", now_));
  EXPECT_THAT(held_by_, HasSubstr("192.168.44.100:7 moves the motors directly"));
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_EQ(faults_[0].code, 3011);
  Keep(link_.OnMotorFrame("192.168.44.100:7", now_));
  EXPECT_THAT(faults_, SizeIs(1));
  RunFor(std::chrono::seconds(10));
  frames_.clear();
  Command(12, 0);
  RunFor(Milliseconds(100));
  EXPECT_EQ(FramesOfMode(12), 0) << "the board obeys no command";
  EXPECT_NE(held_by_, "");
  Command(0, 0);
  EXPECT_EQ(FramesOfMode(0), 3) << "a stop is tried";
  Hang(Milliseconds(300));
  sequence_ = 0;  // it was switched off and on
  RunFor(Milliseconds(200), 7, 0);
  EXPECT_TRUE(restarted_);
  EXPECT_EQ(held_by_, "");
}

TEST_F(LcmLinkTest, HoldsAWalkingBodyWithZeroSpeed) {
  RunFor(Milliseconds(250), 11, 27);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) {
    EXPECT_EQ(frame.mode, 11);
    EXPECT_EQ(frame.gait, 27);
    EXPECT_EQ(frame.vel, (std::array<float, 3>{}));
  }
}

TEST_F(LcmLinkTest, RenewsTheHoldOfAWalkUntilTheBodyIsStill) {
  BoardLocation location;
  location.motion.v_B.x() = 0.3;
  const auto run = [&](int times) {
    for (int i = 0; i < times; ++i) {
      Keep(link_.OnLocation({kBoard, static_cast<std::uint32_t>(++sequence_)}, location, {}, now_));
      RunFor(Milliseconds(20), 11, 27);
    }
  };
  run(15);
  EXPECT_GT(NewCounts(), 5) << "one of them arrives";
  location.motion.v_B.x() = 0;
  run(2);
  frames_.clear();
  run(20);
  EXPECT_EQ(NewCounts(), 1);
}

TEST_F(LcmLinkTest, SendsHeartbeatsThatAreNoCommandOnceTheBoardHasTakenIt) {
  Stand();
  Command(62, 2);
  const BodyCommand command = frames_.front();
  EXPECT_EQ(command.mode, 62);
  RunFor(Milliseconds(400), 62, 2);
  frames_.clear();
  RunFor(Milliseconds(1000), 62, 2);
  EXPECT_THAT(frames_, SizeIs(20));
  EXPECT_EQ(FramesOfMode(-1), 20) << "a board that has restarted must not begin it again";
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.life_count, command.life_count);
}

TEST_F(LcmLinkTest, SendsHeartbeatsThatAreNoCommandOnceItHoldsTheBody) {
  RunFor(Milliseconds(600));
  frames_.clear();
  RunFor(Milliseconds(500));
  EXPECT_EQ(FramesOfMode(-1), 10);
}

TEST_F(LcmLinkTest, RepeatsACommandFor200msThatTheReportOfTheBoardCannotConfirm) {
  Stand();
  Command(21, 0);
  RunFor(Milliseconds(400), 21, 0);
  frames_.clear();
  Command(21, 0);  // another pose, of the same mode and gait
  RunFor(Milliseconds(190), 21, 0);
  EXPECT_GE(FramesOfMode(21), 10);
  EXPECT_EQ(FramesOfMode(-1), 0);
}

TEST_F(LcmLinkTest, ReportsAmbiguouslyUntilAPoseAfterAPoseHasBegun) {
  const auto reported = [&](std::int8_t bar, SwitchStatus status = SwitchStatus::kNormal) {
    BodyReport report;
    report.mode = 21;
    report.bar = bar;
    report.switch_status = static_cast<std::int8_t>(status);
    now_ += Milliseconds(20);
    Respond(report);
    return bodies_.back().report;
  };
  Stand();
  Command(21, 0);
  EXPECT_FALSE(reported(0).ambiguous) << "it stood before";
  reported(100);
  Command(21, 0);
  EXPECT_TRUE(reported(100).ambiguous);
  EXPECT_EQ(bodies_.back().report.life_count, life_);
  EXPECT_FALSE(reported(3).ambiguous) << "less progress than before";
  EXPECT_FALSE(reported(100).ambiguous);
  Command(21, 0);
  EXPECT_TRUE(reported(100).ambiguous);
  EXPECT_FALSE(reported(100, SwitchStatus::kTransitioning).ambiguous);
  EXPECT_FALSE(reported(100).ambiguous);
}

TEST_F(LcmLinkTest, ReportsAmbiguouslyNoLongerThanACommandMayTake) {
  Stand();
  Command(21, 0);
  RunFor(Milliseconds(400), 21, 0);
  Command(21, 0);
  RunFor(kRepeatTime, 21, 0);
  EXPECT_TRUE(bodies_.back().report.ambiguous);
  RunFor(Milliseconds(100), 21, 0);
  EXPECT_FALSE(bodies_.back().report.ambiguous);
}

TEST_F(LcmLinkTest, TakesTheEndOfATransitionForNoBeginOfAPoseThatCameDuringIt) {
  Stand();
  Command(21, 0);
  RunFor(Milliseconds(100), 21, 0, static_cast<std::int8_t>(SwitchStatus::kTransitioning));
  Command(21, 0);
  BodyReport report;
  report.mode = 21;
  now_ += Milliseconds(20);
  Respond(report);
  EXPECT_TRUE(bodies_.back().report.ambiguous) << "less progress: the first one begins";
}

TEST_F(LcmLinkTest, HoldsTheBodyAsItFindsItAfterItHasHung) {
  Stand();
  Command(12, 0);
  RunFor(Milliseconds(500));
  frames_.clear();
  Hang(std::chrono::seconds(2));
  Command(11, 27, 0.5F);  // queued meanwhile
  RunFor(Milliseconds(600), 7, 1);
  EXPECT_EQ(FramesOfMode(12), 0) << "the board has let the body lie down";
  EXPECT_EQ(FramesOfMode(11), 0);
  EXPECT_GT(FramesOfMode(7), 0);
}

// Its own time stood meanwhile.
TEST_F(LcmLinkTest, HoldsTheBodyAsItFindsItAfterItsComputerWasSuspended) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27);
  frames_.clear();
  link_.OnSuspended(std::chrono::hours(1));
  Command(11, 27, 0.4F);  // the motion manager has no report of the lying body yet
  RunFor(Milliseconds(600), 7, 1);
  EXPECT_EQ(FramesOfMode(11), 0) << "the board has let the body lie down";
  EXPECT_GT(FramesOfMode(7), 0);
}

TEST_F(LcmLinkTest, KeepsAnEmergencyStopAfterItsComputerWasSuspended) {
  Stand();
  Command(0, 0);
  RunFor(Milliseconds(500), 0, 0, 2);
  frames_.clear();
  link_.OnSuspended(std::chrono::hours(1));
  RunFor(Milliseconds(100), 7, 1);
  EXPECT_GT(FramesOfMode(0), 0);
}

TEST_F(LcmLinkTest, KeepsAnEmergencyStopAfterItHasHung) {
  Stand();
  Command(0, 0);
  RunFor(Milliseconds(500), 0, 0, 2);
  frames_.clear();
  Hang(std::chrono::seconds(2));
  RunFor(Milliseconds(100), 7, 1);
  EXPECT_GT(FramesOfMode(0), 0);
}

// A board that has let the body lie down meanwhile, by its own rule, ignores the count that it has.
TEST_F(LcmLinkTest, RenewsAnEmergencyStopAfterAHangASuspensionOrASilence) {
  for (const int why : {0, 1, 2}) {
    SCOPED_TRACE(why);
    Stand();
    Command(0, 0);
    RunFor(Milliseconds(500), 0, 0, 2);
    frames_.clear();
    RunFor(Milliseconds(500), 0, 0, 2);
    EXPECT_EQ(NewCounts(), 1) << "the board has it";
    if (why == 0) Hang(Milliseconds(600));
    if (why == 1) link_.OnSuspended(std::chrono::hours(1));
    if (why == 2) {
      responds_ = false;
      RunFor(Milliseconds(600));
      responds_ = true;
    }
    frames_.clear();
    RunFor(Milliseconds(300), 7, 1);
    EXPECT_GT(NewCounts(), 3);
    EXPECT_GT(FramesOfMode(0), 3);
    RunFor(Milliseconds(100), 0, 0, 2);
    frames_.clear();
    RunFor(Milliseconds(500), 0, 0, 2);
    EXPECT_EQ(NewCounts(), 1) << "the board has it again";
    Command(12, 0);
    RunFor(Milliseconds(100));
  }
}

// Its count may go on where it was: then nothing but the silence shows a restart.
TEST_F(LcmLinkTest, LetsALyingBodyLieAfterTheBoardWasSilent) {
  Stand();
  Command(12, 0);
  RunFor(Milliseconds(500));
  responds_ = false;
  RunFor(Milliseconds(1000));
  responds_ = true;
  frames_.clear();
  RunFor(Milliseconds(1000), 7, 1);
  EXPECT_FALSE(restarted_);
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(FramesOfMode(-1), static_cast<int>(frames_.size())) << "it goes on lying";
}

TEST_F(LcmLinkTest, KeepsAPoseOrADanceUpAfterTheBoardWasSilent) {
  for (const std::int8_t mode : {std::int8_t{3}, std::int8_t{62}}) {
    link_ = LcmLink(now_);
    Stand();
    Command(mode, 0);
    RunFor(Milliseconds(400), mode, 0);
    responds_ = false;
    RunFor(Milliseconds(600));
    responds_ = true;
    frames_.clear();
    RunFor(Milliseconds(1000), mode, 0);
    EXPECT_GE(FramesOfMode(-1), 19) << "without them the body lies down, mode " << int{mode};
    EXPECT_EQ(FramesOfMode(-1), static_cast<int>(frames_.size()));
    EXPECT_FALSE(link_.looking());
  }
}

TEST_F(LcmLinkTest, FollowsAStreamOfPosesAfterTheBoardWasSilent) {
  Stand();
  const auto stream = [&](Duration duration) {
    for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(50), 3, 0)) {
      Command(3, 0);
    }
  };
  stream(Milliseconds(1000));
  responds_ = false;
  stream(Milliseconds(550));
  responds_ = true;
  frames_.clear();
  stream(Milliseconds(500));
  EXPECT_GT(FramesOfMode(3), 10);
}

TEST_F(LcmLinkTest, HoldsAWalkingBodyInItsPlaceAfterTheBoardWasSilent) {
  Stand();
  Command(62, 2);
  responds_ = false;
  RunFor(Milliseconds(600));
  responds_ = true;
  frames_.clear();
  RunFor(Milliseconds(300), 11, 27);  // it has taken another command
  ASSERT_GT(FramesOfMode(11), 0);
  EXPECT_EQ(frames_.back().gait, 27);
  EXPECT_EQ(frames_.back().vel[0], 0);
}

TEST_F(LcmLinkTest, KeepsALyingBodyLying) {
  RunFor(Milliseconds(500), 7, 1);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 7);
}

TEST_F(LcmLinkTest, LeavesABodyThatIsOffToItselfUntilItIsCommanded) {
  RunFor(Milliseconds(500), 0, 0);
  EXPECT_THAT(frames_, IsEmpty()) << "its motors get power by a command only";
  Command(7, 1);
  RunFor(Milliseconds(100), 7, 1);
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(NewCounts(), 2) << "one may be that of the commander before";
}

TEST_F(LcmLinkTest, StandsInPlaceOfAPronkABoundOrAUserGaitThatItFinds) {
  for (const int gait : {2, 7, 9, 50, 110}) {
    link_ = LcmLink(now_);
    frames_.clear();
    RunFor(Milliseconds(500), 11, static_cast<std::int8_t>(gait));
    ASSERT_FALSE(frames_.empty()) << gait;
    for (const BodyCommand& frame : frames_) {
      EXPECT_EQ(frame.mode, 11);
      EXPECT_EQ(frame.gait, 1) << "WALK_STAND";
    }
  }
}

TEST_F(LcmLinkTest, DoesNotInterruptAnotherMotionOfTheBodyThatItFinds) {
  RunFor(Milliseconds(500), 62, 2);
  EXPECT_THAT(frames_, IsEmpty());
  RunFor(Milliseconds(200), 7, 1);
  EXPECT_FALSE(frames_.empty()) << "it has ended";
}

TEST_F(LcmLinkTest, RepeatsTheLastFrame20TimesASecond) {
  Stand();
  Command(21, 0);
  RunFor(Milliseconds(1000), 21, 0);
  EXPECT_THAT(frames_, SizeIs(::testing::AllOf(::testing::Ge(20U), ::testing::Le(21U))));
  EXPECT_EQ(NewCounts(), 1);
}

TEST_F(LcmLinkTest, GivesEachCommandTheNextLifeCountRound256) {
  Stand();
  std::uint8_t last = static_cast<std::uint8_t>(link_.frame()->life_count);
  for (int i = 0; i < 300; ++i) {
    life_ = static_cast<std::int8_t>(i % 100);
    Command(11, 27, 0.1F);
    const auto count = static_cast<std::uint8_t>(link_.frame()->life_count);
    ASSERT_EQ(count, static_cast<std::uint8_t>(last + 1));
    last = count;
  }
}

TEST_F(LcmLinkTest, SendsACommandOnceThatTheMotionManagerRepeats) {
  Stand();
  Command(16, 1);
  BodyCommand again = *link_.frame();
  again.life_count = life_;
  EXPECT_THAT(link_.OnCommand(again, now_).frames, IsEmpty());
}

TEST_F(LcmLinkTest, SendsAnEmergencyStopAtOnceThriceAndKeepsIt) {
  Command(0, 0);
  EXPECT_THAT(frames_, SizeIs(3)) << "although no board has responded yet";
  EXPECT_EQ(NewCounts(), 1);
  frames_.clear();
  RunFor(Milliseconds(5000), 0, 0, 2);
  EXPECT_THAT(frames_, SizeIs(::testing::Ge(99U)));
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 0);
  frames_.clear();
  Command(11, 27, 0.5F);
  EXPECT_THAT(frames_, IsEmpty()) << "only recovery stand follows";
  Command(12, 0);
  ASSERT_THAT(frames_, SizeIs(1));
  EXPECT_EQ(frames_[0].mode, 12);
}

TEST_F(LcmLinkTest, LetsOnlyRecoveryStandPassAfterAStopOfTheBoard) {
  for (const std::int8_t status : {std::int8_t{2}, std::int8_t{3}}) {
    Stand();
    Command(11, 27, 0.5F);
    RunFor(Milliseconds(100), 11, 27);
    RunFor(Milliseconds(100), 11, 27, status);
    frames_.clear();
    Command(11, 27, 0.5F);
    Command(62, 2);
    Command(7, 1);
    RunFor(Milliseconds(500), 7, 0, status);
    EXPECT_THAT(frames_, IsEmpty()) << int{status};
    Command(12, 0);
    EXPECT_THAT(frames_, SizeIs(1));
    RunFor(Milliseconds(500));
    for (const BodyCommand& frame : frames_) EXPECT_THAT(frame.mode, AnyOf(12, -1));
  }
}

TEST_F(LcmLinkTest, DoesNotContinueAWalkWhenTheBoardRecoversByItself) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27, 3);
  frames_.clear();
  RunFor(Milliseconds(300), 11, 27);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.vel[0], 0);
}

TEST_F(LcmLinkTest, TreatsABodyThatIsOffBecauseItHasTiltedAsStopped) {
  Stand();
  BodyReport tilted;
  tilted.mode = 0;
  tilted.ori_error = 1;
  now_ += Milliseconds(20);
  const LinkOutput output = Respond(tilted);
  ASSERT_TRUE(output.body);
  EXPECT_EQ(CodeOfStatus(output.body->report.switch_status), MotionCode(MotionKey::kOrientation));
  Command(11, 27, 0.5F);
  Command(7, 1);
  EXPECT_THAT(frames_, IsEmpty());
  Command(12, 0);
  EXPECT_THAT(frames_, SizeIs(1));
}

// The board keeps ori_error until the body walks.
TEST_F(LcmLinkTest, WalksAndLiesDownAfterATiltFromWhichTheBodyHasStoodUp) {
  Stand();
  BodyReport report;
  report.mode = 12;
  report.ori_error = 1;
  now_ += Milliseconds(20);
  EXPECT_EQ(Respond(report).body->report.switch_status, 0);
  Command(7, 1);
  ASSERT_THAT(frames_, SizeIs(1)) << "get-down";
  report.mode = 7;
  report.gait = 1;
  now_ += Milliseconds(20);
  EXPECT_EQ(Respond(report).body->report.switch_status, 0) << "it lies as it was commanded";
  EXPECT_TRUE(link_.frame());
  report.mode = 12;
  report.gait = 0;
  now_ += Milliseconds(20);
  Respond(report);
  Command(11, 27, 0.5F);
  EXPECT_EQ(frames_.back().mode, 11);
}

TEST_F(LcmLinkTest, DoesNotBeginACommandThatHasFailedOnceTheBoardIsBack) {
  RunFor(Milliseconds(300), 7, 1);
  responds_ = false;  // the cable is out
  Command(12, 0);
  RunFor(Milliseconds(5000));
  frames_.clear();
  RunFor(std::chrono::seconds(60));
  EXPECT_THAT(frames_, IsEmpty());
  responds_ = true;
  RunFor(Milliseconds(5000), 7, 1);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 7) << "it does not stand up";
}

TEST_F(LcmLinkTest, HoldsTheBodyAfterACommandThatTheBoardHasNotTaken) {
  Stand();
  Command(16, 1);
  RunFor(Milliseconds(700), 12, 0);
  frames_.clear();
  RunFor(Milliseconds(500), 12, 0);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_NE(frame.mode, 16) << "no jump";
}

TEST_F(LcmLinkTest, KeepsARefusedCommandAsItsHeartbeat) {
  Stand();
  Command(16, 1);
  RunFor(Milliseconds(3000), 12, 0, 5);
  ASSERT_TRUE(link_.frame());
  EXPECT_EQ(link_.frame()->mode, 16);
  EXPECT_EQ(NewCounts(), 1) << "never new to the board again";
}

TEST_F(LcmLinkTest, RepeatsACommandAsLongAsTheMotionManagerWaits) {
  link_ = LcmLink(now_, {Milliseconds(2000), ""});
  Stand();
  Command(16, 1);
  RunFor(Milliseconds(1900), 12, 0);
  EXPECT_EQ(link_.frame()->mode, 16);
  RunFor(Milliseconds(300), 12, 0);
  EXPECT_EQ(link_.frame()->mode, 12);
}

TEST_F(LcmLinkTest, SendsAStopUntilTheBoardTakesIt) {
  Stand();
  responds_ = false;
  for (const std::int8_t mode : {std::int8_t{7}, std::int8_t{0}}) {
    Command(mode, 0);
    RunFor(std::chrono::seconds(10));
    frames_.clear();
    RunFor(Milliseconds(1000));
    ASSERT_FALSE(frames_.empty());
    for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, mode);
  }
}

TEST_F(LcmLinkTest, RenewsAStopUntilTheBoardTakesIt) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27, 1);
  frames_.clear();
  Command(11, 1);
  RunFor(Milliseconds(200), 11, 27, 1);
  EXPECT_GE(NewCounts(), 5) << "another program may have used its count";
  EXPECT_NE(bodies_.back().report.life_count, life_) << "it is in another transition";
  RunFor(Milliseconds(40), 11, 1);
  EXPECT_EQ(bodies_.back().report.life_count, life_);
  frames_.clear();
  RunFor(Milliseconds(500), 11, 1);
  EXPECT_EQ(NewCounts(), 1);
}

TEST_F(LcmLinkTest, DoesNotRenewAStopOfABodyThatLies) {
  Stand();
  Command(11, 1);
  RunFor(Milliseconds(100), 7, 1);
  frames_.clear();
  RunFor(Milliseconds(500), 7, 1);
  EXPECT_LE(NewCounts(), 1);
}

TEST_F(LcmLinkTest, StopsAWalkThatTheMotionManagerNoLongerRepeats) {
  Stand();
  Command(11, 27, 0.5F);
  Repeat(std::chrono::seconds(2), 11, 27);
  EXPECT_EQ(link_.frame()->vel[0], 0.5F);
  frames_.clear();
  RunFor(Milliseconds(600), 11, 27);
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(frames_.back().mode, 11);
  EXPECT_EQ(frames_.back().gait, 1) << "WALK_STAND";
  EXPECT_EQ(frames_.back().vel[0], 0);
}

TEST_F(LcmLinkTest, StopsWalksOnlyWhenTheMotionManagerNoLongerRepeatsThem) {
  for (const std::int8_t mode : {std::int8_t{11}, std::int8_t{81}, std::int8_t{82}}) {
    link_ = LcmLink(now_);
    Stand();
    Command(mode, 0, 0.5F);
    RunFor(Milliseconds(700), mode, 0);
    EXPECT_EQ(frames_.back().mode, 11) << int{mode};
    EXPECT_EQ(frames_.back().gait, 1) << "WALK_STAND";
  }
  for (const std::int8_t mode : {std::int8_t{3}, std::int8_t{21}, std::int8_t{62}}) {
    link_ = LcmLink(now_);
    Stand();
    Command(mode, 0, 0.5F);  // a speed that its motion does not use
    RunFor(Milliseconds(2000), mode, 0);
    EXPECT_EQ(FramesOfMode(11), 0) << int{mode};
    EXPECT_EQ(frames_.back().mode, -1);
  }
}

TEST_F(LcmLinkTest, RepeatsAStopWhileAnotherProgramCommands) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27);
  BodyCommand other;
  other.mode = 11;
  other.gait = 10;
  Keep(link_.OnOtherFrame("192.168.44.1:7", other, now_));
  frames_.clear();
  Command(11, 1);
  RunFor(Milliseconds(190), 11, 27);
  EXPECT_GE(NewCounts(), 5) << "a datagram may be lost";
  RunFor(Milliseconds(20), 11, 27);
  frames_.clear();
  RunFor(Milliseconds(200), 11, 27);
  EXPECT_THAT(frames_, IsEmpty()) << "the other program commands";
}

TEST_F(LcmLinkTest, DropsAResponseThatIsOlderThanTheNewest) {
  Stand();
  now_ += Milliseconds(20);
  Respond(12, 0);
  BodyReport old;
  old.mode = 7;
  now_ += Milliseconds(20);
  EXPECT_FALSE(link_.OnResponse({kBoard, sequence_ - 1}, old, now_).body);
  EXPECT_FALSE(link_.OnResponse({kBoard, sequence_}, old, now_).body) << "a copy";
  EXPECT_EQ(Respond(12, 0).body->report.mode, 12);
}

TEST_F(LcmLinkTest, NumbersOfResponsesMayWrapAround) {
  NewestOnly order;
  EXPECT_EQ(order.Take(0xFFFFFFFFU, now_), NewestOnly::Age::kNew);
  EXPECT_EQ(order.Take(0, now_), NewestOnly::Age::kNew);
  EXPECT_EQ(order.Take(0xFFFFFFFFU, now_), NewestOnly::Age::kOld);
}

TEST_F(LcmLinkTest, ForgetsItsCommandWhenTheBoardCountsFromTheBeginning) {
  Stand();
  sequence_ = 100'000;
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(500), 11, 27);
  responds_ = false;
  RunFor(Milliseconds(300));
  sequence_ = 0;
  responds_ = true;
  frames_.clear();
  RunFor(Milliseconds(1000), 7, 0);
  EXPECT_TRUE(restarted_);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0].text, HasSubstr("has restarted"));
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.vel[0], 0);
  EXPECT_EQ(frames_.back().mode, 7) << "it goes on lying";
}

TEST_F(LcmLinkTest, ForgetsItsCommandWhenTheBoardAnswersFromAnotherAddress) {
  Stand();
  Command(11, 27, 0.5F);
  now_ += kRestartPause;
  BodyReport lying;
  lying.mode = 7;
  Keep(link_.OnResponse({"192.168.44.233:51111", 1}, lying, now_));
  EXPECT_TRUE(restarted_);
  EXPECT_FALSE(link_.frame());
}

// As that of another robot, by another network.
TEST_F(LcmLinkTest, DoesNotTakeTheBoardOfAnotherHostForItsOwnOneThatIsSilent) {
  Stand();
  now_ += std::chrono::seconds(1);
  BodyReport other;
  other.mode = 12;
  EXPECT_FALSE(Keep(link_.OnResponse({"192.168.1.5:1", 1}, other, now_)).body);
  EXPECT_FALSE(restarted_);
  EXPECT_THAT(held_by_, HasSubstr("192.168.1.5:1"));
  EXPECT_TRUE(Keep(link_.OnResponse({"192.168.44.233:51111", 1}, other, now_)).body);
  EXPECT_TRUE(restarted_) << "its own one is found again";
}

// Its address comes from DHCP, or it answers by another interface: its messages were ignored until
// the motion manager was restarted.
TEST_F(LcmLinkTest, FindsItsBoardAtAnotherAddressOnceItIsSilentAndNoOtherHostResponds) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27);
  responds_ = false;
  frames_.clear();
  RespondFrom("192.168.44.77:40000", Milliseconds(1400), 11);
  EXPECT_FALSE(restarted_) << "its own one may only be slow";
  EXPECT_EQ(held_by_.substr(0, held_by_.find(';')),
            "two motion boards take these commands: 192.168.44.233:40000, 192.168.44.77:40000");
  RespondFrom("192.168.44.77:40000", Milliseconds(200), 11);
  EXPECT_TRUE(restarted_) << "what was commanded is void";
  EXPECT_THAT(faults_.back().text, AllOf(HasSubstr("answers from 192.168.44.77:40000 now"),
                                         HasSubstr("192.168.44.233:40000 is silent")));
  EXPECT_EQ(bodies_.back().report.mode, 11);
  RespondFrom("192.168.44.77:40000", Milliseconds(1500), 12);
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.vel[0], 0) << "it walks no further";
  EXPECT_EQ(held_by_, "");
  Command(62, 2);
  EXPECT_EQ(frames_.back().mode, 62);
  Keep(link_.OnLocation({"192.168.44.77:40000", 9}, BoardLocation(), Milliseconds(7), now_));
  RespondFrom("192.168.44.77:40000", Milliseconds(40), 62);
  EXPECT_TRUE(std::ranges::any_of(bodies_, &BodyState::has_new_motion)) << "its odometry, too";
}

// It began while the board still responded: it is another robot's.
TEST_F(LcmLinkTest, NeverTakesAHostForItsBoardThatHasRespondedBesideIt) {
  Stand();
  RespondFrom("192.168.44.5:1", Milliseconds(400));
  responds_ = false;
  RespondFrom("192.168.44.5:1", std::chrono::seconds(20));
  RunFor(std::chrono::seconds(5));
  RespondFrom("192.168.44.5:1", std::chrono::seconds(20));
  EXPECT_FALSE(restarted_);
  responds_ = true;
  RunFor(Milliseconds(1500));
  EXPECT_EQ(bodies_.back().report.mode, 12) << "its own one is back";
}

TEST_F(LcmLinkTest, TakesNeitherOfTwoOtherHostsForItsBoard) {
  Stand();
  responds_ = false;
  for (int i = 0; i < 500; ++i) {
    RespondFrom("192.168.44.5:1", Milliseconds(20));
    RespondFrom("192.168.44.6:1", Milliseconds(20));
  }
  EXPECT_FALSE(restarted_);
  EXPECT_NE(held_by_, "");
  RespondFrom("192.168.44.6:1", Milliseconds(1600));
  EXPECT_TRUE(restarted_) << "the other one has ended";
}

TEST_F(LcmLinkTest, TakesNoHostOfAnotherNetworkForItsBoard) {
  Stand();
  responds_ = false;
  RespondFrom("10.0.0.5:1", std::chrono::seconds(20), 7, transport::HostPlace::kElsewhere);
  EXPECT_FALSE(restarted_);
}

TEST_F(LcmLinkTest, TakesNoOtherHostForABoardThatIsNamed) {
  link_ = LcmLink(now_, {kNoResponse, "192.168.44.233"});
  Stand();
  responds_ = false;
  RespondFrom("192.168.44.77:40000", std::chrono::seconds(20));
  EXPECT_FALSE(restarted_);
}

TEST_F(LcmLinkTest, SendsAnEmergencyStopAlsoToTheNewAddressOfItsBoard) {
  Stand();
  Command(0, 0);
  RunFor(Milliseconds(100), 0, 0, 2);
  responds_ = false;
  RespondFrom("192.168.44.77:40000", Milliseconds(1600), 11);
  ASSERT_TRUE(restarted_);
  frames_.clear();
  RespondFrom("192.168.44.77:40000", Milliseconds(500), 11);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 0);
  EXPECT_GE(NewCounts(), 2);
}

// A new address is no restart of the board's process.
TEST_F(LcmLinkTest, KnowsOfAProgramThatMovesTheMotorsWhenItsBoardGetsAnotherAddress) {
  Stand();
  Keep(link_.OnMotorFrame("192.168.44.9:1", now_));
  responds_ = false;
  RespondFrom("192.168.44.77:40000", std::chrono::seconds(4), 12);
  ASSERT_TRUE(restarted_);
  EXPECT_THAT(held_by_, HasSubstr("moves the motors directly"));
}

TEST_F(LcmLinkTest, TakesAllAddressesOfThisComputerForOneHost) {
  const auto respond = [&](const std::string& name) {
    BodyReport report;
    report.mode = 12;
    return Keep(
        link_.OnResponse({name, ++sequence_, transport::HostPlace::kThisComputer}, report, now_));
  };
  EXPECT_TRUE(respond("192.168.1.20:1").body);
  now_ += kRestartPause;
  EXPECT_TRUE(respond("10.0.0.7:1").body);
  now_ += kRestartPause;
  EXPECT_TRUE(respond("127.0.0.1:1").body);
  EXPECT_EQ(held_by_, "");
}

TEST_F(LcmLinkTest, SendsACommandAfterARestartOfTheBoardThatHasTheCountOfTheOneBefore) {
  Stand();
  sequence_ = 100'000;
  Command(62, 2);
  RunFor(Milliseconds(100), 62, 2);
  EXPECT_EQ(bodies_.back().report.life_count, life_);
  now_ += kRestartPause;
  sequence_ = 0;
  RunFor(Milliseconds(300), 7, 0);
  EXPECT_EQ(bodies_.back().report.life_count, 0) << "what it has taken is void";
  frames_.clear();
  --life_;
  Command(12, 0);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(LcmLinkTest, KeepsAnEmergencyStopWhenTheBoardRestarts) {
  Stand();
  Command(0, 0);
  RunFor(Milliseconds(100), 0, 0, 2);
  now_ += kRestartPause;
  sequence_ = 0;
  frames_.clear();
  RunFor(Milliseconds(300), 7, 0);
  ASSERT_FALSE(frames_.empty());
  for (const BodyCommand& frame : frames_) EXPECT_EQ(frame.mode, 0);
  EXPECT_GE(NewCounts(), 2) << "the board that was switched on must take it as new";
}

TEST_F(LcmLinkTest, IgnoresASecondBoardAndNamesIt) {
  Stand();
  BodyReport other;
  other.mode = 7;
  EXPECT_FALSE(Keep(link_.OnResponse({"192.168.44.5:1", 1}, other, now_)).body);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0].text, AllOf(HasSubstr("192.168.44.5:1"), HasSubstr(kBoard)));
}

TEST_F(LcmLinkTest, SendsOnlyStopsWhileTwoBoardsTakeItsCommands) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(100), 11, 27);
  BodyReport other;
  other.mode = 7;
  frames_.clear();
  for (std::uint32_t i = 1; i < 100; ++i) {
    Keep(link_.OnResponse({"192.168.44.5:1", i}, other, now_));
    if (i == 1) Command(11, 1);
    if (i > 1) Command(62, 2);
    RunFor(Milliseconds(20), 11, i < 5 ? 27 : 1);
  }
  EXPECT_EQ(held_by_.substr(0, held_by_.find(';')),
            "two motion boards take these commands: 192.168.44.233:40000, 192.168.44.5:1");
  EXPECT_EQ(FramesOfMode(62), 0);
  EXPECT_GT(FramesOfMode(11), 0) << "the walk is stopped";
  EXPECT_EQ(FramesOfMode(11) + FramesOfMode(-1), static_cast<int>(frames_.size()));
  EXPECT_GT(frames_.size(), 30U) << "heartbeats: the body does not lie down";
  RunFor(Milliseconds(900), 11, 1);
  EXPECT_NE(held_by_, "");
  RunFor(Milliseconds(300), 11, 1);
  EXPECT_EQ(held_by_, "") << "the second one has ended";
  Command(62, 2);
  EXPECT_EQ(frames_.back().mode, 62);
}

// Its process has restarted: for 200 ms its answers are those of a second board.
TEST_F(LcmLinkTest, SendsHeartbeatsToABoardThatAnswersFromAnotherPort) {
  Stand();
  Command(62, 2);
  RunFor(Milliseconds(400), 62, 2);
  responds_ = false;
  BodyReport standing;
  standing.mode = 12;
  std::uint32_t count = 0;
  const auto run = [&](Duration duration) {
    for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(20))) {
      Keep(link_.OnResponse({"192.168.44.233:51111", ++count}, standing, now_));
    }
  };
  run(Milliseconds(100));
  EXPECT_THAT(held_by_, HasSubstr("or the board has restarted"));
  run(Milliseconds(200));
  EXPECT_TRUE(restarted_);
  EXPECT_FALSE(link_.frame());
  frames_.clear();
  run(Milliseconds(500));
  EXPECT_NE(held_by_, "");
  EXPECT_GE(FramesOfMode(-1), 7) << "without them the body lies down";
  EXPECT_EQ(FramesOfMode(-1), static_cast<int>(frames_.size()));
}

TEST_F(LcmLinkTest, DoesNotKeepAMotionUpThatItFindsWhileTwoBoardsTakeItsCommands) {
  for (const std::int8_t mode : {std::int8_t{11}, std::int8_t{62}, std::int8_t{0}}) {
    link_ = LcmLink(now_);
    for (std::uint32_t i = 1; i < 50; ++i) {
      RunFor(Milliseconds(20), mode, 27);
      Keep(link_.OnResponse({"192.168.44.5:1", i}, BodyReport(), now_));
    }
    EXPECT_THAT(frames_, IsEmpty()) << "it ends by the rule of the board, mode " << int{mode};
  }
}

TEST_F(LcmLinkTest, TakesPositionsAndTemperaturesOfTheHostThatRespondsOnly) {
  BoardLocation location;
  link_.OnLocation({"192.168.44.5:1", 1}, location, Milliseconds(7), now_);
  EXPECT_FALSE(Respond(12, 0).body->has_new_motion) << "before the first response";
  Stand();
  Keep(link_.OnLocation({"192.168.44.5:1", 2}, location, Milliseconds(7), now_));
  Keep(link_.OnTemperatures({"192.168.44.5:2", 1}, Temperatures{90}, now_));
  now_ += Milliseconds(20);
  EXPECT_FALSE(Respond(12, 0).body->has_new_motion);
  EXPECT_EQ(bodies_.back().report.motor_temperature[0], 0);
  ASSERT_THAT(faults_, SizeIs(1)) << "reported once";
  EXPECT_THAT(faults_[0].text, AllOf(HasSubstr("192.168.44.5:1"), HasSubstr(kBoard)));
}

TEST_F(LcmLinkTest, DropsMessagesOfOtherHostsThanTheConfiguredBoard) {
  link_ = LcmLink(now_, {kNoResponse, "192.168.44.233"});
  BodyReport other;
  other.mode = 7;
  EXPECT_FALSE(Keep(link_.OnResponse({"192.168.44.5:1", 1}, other, now_)).body);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0].text,
              AllOf(HasSubstr("from 192.168.44.5:1"), HasSubstr("board is 192.168.44.233")));
  Stand();
  now_ += std::chrono::seconds(1);  // the board is silent, but another host is not the board
  EXPECT_FALSE(Keep(link_.OnResponse({"192.168.44.5:1", 2}, other, now_)).body);
  EXPECT_FALSE(restarted_);
  EXPECT_EQ(Respond(12, 0).body->report.mode, 12);
}

TEST_F(LcmLinkTest, YieldsToAnotherProgramAndNamesItByItsLifeCount) {
  Stand();
  Command(11, 27, 0.5F);
  BodyCommand other;
  other.mode = 11;
  other.gait = 10;
  other.life_count = static_cast<std::int8_t>(200);
  Keep(link_.OnOtherFrame("192.168.44.100:7", other, now_));
  EXPECT_THAT(held_by_, AllOf(HasSubstr("192.168.44.100:7"), HasSubstr("life count 200")));
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_EQ(faults_[0].code, 3011);
  frames_.clear();
  for (int i = 0; i < 100; ++i) {
    Keep(link_.OnOtherFrame("192.168.44.100:7", other, now_));
    Command(11, 27, 0.5F);
    RunFor(Milliseconds(20), 11, 10);
  }
  EXPECT_THAT(frames_, IsEmpty());
  EXPECT_THAT(faults_, SizeIs(1)) << "reported once";
  Command(0, 0);
  EXPECT_THAT(frames_, SizeIs(3)) << "an emergency stop is sent all the same";
  frames_.clear();
  other.life_count = link_.frame()->life_count;
  Keep(link_.OnOtherFrame("192.168.44.100:7", other, now_));
  RunFor(Milliseconds(51), 11, 10);
  ASSERT_FALSE(frames_.empty());
  EXPECT_NE(frames_.back().life_count, other.life_count) << "new to the board";
}

TEST_F(LcmLinkTest, YieldsToAnotherProgramThatSendsTwoFramesASecond) {
  Stand();
  BodyCommand other;
  other.mode = 11;
  for (int i = 0; i < 10; ++i) {
    Keep(link_.OnOtherFrame("192.168.44.1:7", other, now_));
    frames_.clear();
    Command(62, 2);
    RunFor(Milliseconds(500), 11, 27);
    EXPECT_THAT(frames_, IsEmpty());
    EXPECT_NE(held_by_, "");
  }
}

TEST_F(LcmLinkTest, HoldsTheBodyOnceAnotherProgramHasEnded) {
  BodyCommand other;
  other.mode = 11;
  for (int i = 0; i < 50; ++i) {
    Keep(link_.OnOtherFrame("192.168.44.1:7", other, now_));
    RunFor(Milliseconds(20), 11, 27);
  }
  EXPECT_THAT(frames_, IsEmpty());
  RunFor(kOtherSender + Milliseconds(200), 11, 27);
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(frames_.back().vel[0], 0);
  EXPECT_EQ(held_by_, "");
}

TEST_F(LcmLinkTest, StopsAWalkWithoutAResponseFor500ms) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(200), 11, 27);
  responds_ = false;
  frames_.clear();
  RunFor(Milliseconds(600));
  EXPECT_EQ(frames_.back().gait, 1) << "WALK_STAND";
  EXPECT_EQ(frames_.back().vel[0], 0);
  frames_.clear();
  Command(11, 27, 0.5F);
  EXPECT_THAT(frames_, IsEmpty());
}

TEST_F(LcmLinkTest, TakesTheMotionOfTheBoardForItsAnswer) {
  Stand();
  Command(62, 2);
  now_ += Milliseconds(1);
  Respond(62, 2, 1);
  EXPECT_NE(link_.OnTime(now_ + kBetweenReports).body->report.life_count, life_)
      << "sent before the command arrived";
  now_ += Milliseconds(20);
  EXPECT_NE(Respond(12, 0).body->report.life_count, life_) << "another mode";
  now_ += Milliseconds(20);
  EXPECT_EQ(Respond(62, 2, 1).body->report.life_count, life_);
}

TEST_F(LcmLinkTest, TakesNoTransitionForItsAnswerThatHadBegunBefore) {
  Stand();
  RunFor(Milliseconds(100), 12, 0, 1);
  Command(16, 1);
  RunFor(Milliseconds(100), 12, 0, 1);
  EXPECT_NE(bodies_.back().report.life_count, life_);
  RunFor(Milliseconds(100), 12, 0, 0);
  RunFor(Milliseconds(100), 12, 0, 1);
  EXPECT_EQ(bodies_.back().report.life_count, life_) << "a new transition";
}

TEST_F(LcmLinkTest, NeverTakesAModeThatWasNotAskedForAsAnAnswer) {
  Stand();
  Command(11, 27, 0.5F);
  RunFor(Milliseconds(2000), 12, 0);
  EXPECT_NE(bodies_.back().report.life_count, life_);
}

TEST_F(LcmLinkTest, HandsOnTheNewestReportOfEach10msInAFlood) {
  for (int i = 0; i < 20'000; ++i) {
    now_ += std::chrono::microseconds(100);
    Respond(12, 0);
    if (now_ >= link_.NextDeadline()) Keep(link_.OnTime(now_));
  }
  EXPECT_LE(bodies_.size(), 202U);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0].text, HasSubstr("responses a second, expected 50"));
}

TEST_F(LcmLinkTest, ReportsNoFloodOf500ResponsesASecond) {
  for (int i = 0; i < 1500; ++i) {
    now_ += Milliseconds(2);
    Respond(12, 0);
    if (now_ >= link_.NextDeadline()) Keep(link_.OnTime(now_));
  }
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(LcmLinkTest, ReportsAMalformedDatagramOnceIn3Minutes) {
  for (int i = 0; i < 1000; ++i) Keep(link_.OnMalformed("robot_control_response", "short", now_));
  EXPECT_THAT(faults_, SizeIs(1));
  Keep(link_.OnMalformed("robot_control_response", "short", now_ + kSameFault));
  EXPECT_THAT(faults_, SizeIs(2));
}

TEST_F(LcmLinkTest, ReportsTimestampsThatGoBackAndUsesItsOwnTime) {
  RunFor(Milliseconds(100), 12, 0);
  BoardLocation location;
  location.timestamp = Milliseconds(500);
  EXPECT_TRUE(link_.OnLocation({kBoard, 1}, location, Milliseconds(7), now_).faults.empty());
  location.timestamp = Milliseconds(480);
  const LinkOutput output = link_.OnLocation({kBoard, 2}, location, Milliseconds(27), now_);
  ASSERT_EQ(output.faults.size(), 1U);
  EXPECT_EQ(output.faults[0].code, 3010);
  EXPECT_THAT(output.faults[0].text, HasSubstr("timestamps of global_to_robot go back, by 20 ms"));
}

TEST_F(LcmLinkTest, SaysHowFarAnyTwoTimestampsGoBack) {
  RunFor(Milliseconds(100), 12, 0);
  BoardLocation location;
  location.timestamp = Duration::max();
  Keep(link_.OnLocation({kBoard, 1}, location, Milliseconds(7), now_));
  location.timestamp = Duration::min();
  const LinkOutput output = link_.OnLocation({kBoard, 2}, location, Milliseconds(27), now_);
  ASSERT_EQ(output.faults.size(), 1U);
  EXPECT_THAT(output.faults[0].text, HasSubstr("go back, by 18446744073709 ms"));
}

TEST_F(LcmLinkTest, PublishesEachPositionOnce) {
  Stand();
  BoardLocation location;
  location.motion.X_OB.translation().x() = 3;
  link_.OnLocation({"192.168.44.233:40001", 1}, location, Milliseconds(7), now_);
  now_ += Milliseconds(20);
  const LinkOutput first = Respond(12, 0);
  EXPECT_TRUE(first.body->has_new_motion);
  EXPECT_EQ(first.body->motion.X_OB.translation().x(), 3);
  EXPECT_EQ(first.body->motion.stamp, Milliseconds(7));
  now_ += Milliseconds(20);
  EXPECT_FALSE(Respond(12, 0).body->has_new_motion);
  Keep(link_.OnTemperatures({kBoard, ++sequence_}, Temperatures{40}, now_));
  now_ += Milliseconds(20);
  EXPECT_EQ(Respond(12, 0).body->report.motor_temperature[0], 40);
}

}  // namespace musher::motion::testing::lcm_link_test
