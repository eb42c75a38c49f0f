// The motion manager's decision code, its link and a motion board on LCM as one chain in virtual
// time: datagrams are lost, the board restarts, the manager hangs.

#include <gmock/gmock.h>

#include <array>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "musher/modules/motion/lcm_link.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/modules/motion/wire_board.hpp"

namespace musher::motion::testing::lcm_chain_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class LcmChain : public ::testing::Test {
 protected:
  LcmChain() { Do(motion_event::Opened{}); }

  // As at the beginning.
  void Reset() {
    link_ = LcmLink(now_, {config_.board_feedback, ""});
    core_ = MotionCore();
    Do(motion_event::Opened{});
    board_ = WireBoard();
    loss_ = loss_of_responses_ = loss_of_commands_ = 0;
    hangs_ = false;
    stop_at_.reset();
    answers_.clear();
    log_.clear();
  }
  void RunFor(Duration duration) {
    for (const Time end = now_ + duration; now_ < end;) {
      now_ += Milliseconds(1);
      if ((now_ - Time{}) % Milliseconds(20) == Duration::zero()) Respond();
      if (hangs_) continue;
      if (stop_at_ && now_ >= *stop_at_) {
        stop_at_.reset();
        Do(motion_event::EmergencyStop{});
      }
      if (now_ >= link_.NextDeadline()) Handle(link_.OnTime(now_));
      const auto deadline = NextDeadline(Rules(), core_);
      if (deadline && now_ >= *deadline) Do(motion_event::TimePassed{});
    }
  }
  void Respond() {
    const BodyReport report = board_.Report(now_);
    ++sequence_;
    if (hangs_ || Lost(loss_ + loss_of_responses_)) return;
    Handle(link_.OnResponse({"192.168.44.233:1", sequence_}, report, now_));
  }
  bool Lost(double loss) { return std::uniform_real_distribution<>()(random_) < loss; }

  void Handle(const LinkOutput& output) {
    for (const BodyCommand& frame : output.frames) {
      if (!Lost(loss_ + loss_of_commands_)) board_.Take(frame, now_);
    }
    for (const LinkFault& fault : output.faults) {
      Do(motion_event::BoardFault{fault.code, fault.text});
    }
    if (output.restarted) Do(motion_event::BoardRestarted{});
    if (output.held_by) Do(motion_event::BoardHeld{*output.held_by});
    if (output.body) Do(motion_event::BoardReported{output.body->report, output.body->age});
  }
  void Do(const MotionEvent& event) {
    for (const MotionAction& action : Step(Rules(), core_, event, now_)) {
      if (const auto* send = std::get_if<motion_action::Send>(&action)) {
        Handle(link_.OnCommand(send->command, now_));
      } else if (const auto* answer = std::get_if<motion_action::Answer>(&action)) {
        answers_[answer->token] = *answer;
      } else if (const auto* response = std::get_if<motion_action::ServoResponse>(&action)) {
        response_ = *response;
      } else if (const auto* log = std::get_if<motion_action::Log>(&action)) {
        log_.push_back(log->text);
      }
    }
  }
  RequestToken Request(std::int32_t id) {
    Do(motion_event::PlayArrived{++token_, 0, {{id, {}}}});
    return token_;
  }
  motion_action::Answer AnswerOf(RequestToken token) {
    for (int i = 0; i < 20'000 && answers_.count(token) == 0; ++i) RunFor(Milliseconds(10));
    return answers_[token];
  }
  void Stream(Duration duration, float speed = 0.3F, std::int32_t id = kUserTrot) {
    for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(50))) {
      ServoCommand command;
      command.requested.id = id;
      command.requested.arguments.vel_des = {speed, 0, 0};
      Do(motion_event::ServoArrived{command});
    }
  }
  MotionRules Rules() const { return {TheTable(), config_, gate_}; }

  Time now_{std::chrono::hours(1)};
  MotionConfig config_;
  Gate gate_ = [](const std::string&) { return Ok(); };
  MotionCore core_;
  LcmLink link_{now_, {config_.board_feedback, ""}};
  WireBoard board_;
  std::mt19937 random_{7};
  double loss_ = 0;
  double loss_of_responses_ = 0;  // beside that of all
  double loss_of_commands_ = 0;   // the same
  bool hangs_ = false;
  std::optional<Time> stop_at_;  // an emergency stop comes then
  std::uint32_t sequence_ = 0;
  RequestToken token_ = 0;
  std::map<RequestToken, motion_action::Answer> answers_;
  motion_action::ServoResponse response_;
  std::vector<std::string> log_;
};

TEST_F(LcmChain, ExecutesAMotionOnceAndKeepsTheBodyStanding) {
  RunFor(Milliseconds(500));
  board_.taken.clear();
  EXPECT_EQ(AnswerOf(Request(132)).code, kCodeOk);
  RunFor(Milliseconds(100));
  ASSERT_EQ(board_.taken.size(), 1U) << "a jump";
  EXPECT_EQ(board_.taken[0].mode, 16);
  RunFor(std::chrono::seconds(30));
  EXPECT_EQ(board_.taken.size(), 1U);
  EXPECT_FALSE(board_.lay_down) << "frames are sent between commands";
}

// Both have one mode and gait, so the board reports the end of the first one meanwhile.
TEST_F(LcmChain, AnswersTheSecondOfTwoPosesOnceTheBodyHasTakenIt) {
  RunFor(Milliseconds(500));
  MotionArguments left;
  left.rpy_des = {0, 0, 0.3F};
  left.duration_ms = 300;
  MotionArguments right = left;
  right.rpy_des = {0, 0, -0.3F};
  constexpr std::int32_t kPose = 212;
  Do(motion_event::PlayArrived{++token_, 0, {{kPose, left}, {kPose, right}}});
  RunFor(Milliseconds(400));
  loss_of_commands_ = 1;
  for (int i = 0; i < 300 && core_.job->todo.size() == 2; ++i) RunFor(Milliseconds(1));
  ASSERT_EQ(core_.job->todo.size(), 1U) << "the second one is sent";
  RunFor(Milliseconds(100));
  EXPECT_EQ(answers_.count(token_), 0U) << "it has not begun";
  loss_of_commands_ = 0;
  EXPECT_EQ(AnswerOf(token_).code, kCodeOk);
  EXPECT_FLOAT_EQ(board_.taken.back().rpy[2], -0.3F);
  EXPECT_GT(board_.Report(now_).bar, kDoneBar);
  EXPECT_FALSE(board_.lay_down);
}

TEST_F(LcmChain, LetsTheBodyLieDownWhenTheManagerHangs) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(1000));
  EXPECT_EQ(board_.Report(now_).gait, 27);
  hangs_ = true;
  RunFor(Milliseconds(600));
  EXPECT_TRUE(board_.lay_down);
  EXPECT_EQ(board_.Report(now_).mode, 7);
  hangs_ = false;
  RunFor(Milliseconds(1000));
  EXPECT_EQ(board_.Report(now_).mode, 7) << "it does not stand up by itself";
}

TEST_F(LcmChain, WalksAndStopsWhen30PercentOfTheDatagramsAreLost) {
  RunFor(Milliseconds(500));
  loss_ = 0.3;
  for (int i = 0; i < 20; ++i) {
    Stream(Milliseconds(2000));
    EXPECT_EQ(board_.Report(now_).gait, 27);
    RunFor(Milliseconds(1500));
    EXPECT_EQ(board_.Report(now_).gait, 1) << "WALK_STAND, run " << i;
    EXPECT_EQ(AnswerOf(Request(132)).code, kCodeOk) << "run " << i;
    EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk) << "run " << i;
  }
  EXPECT_FALSE(board_.lay_down);
}

TEST_F(LcmChain, StopsInAnEmergencyWhen30PercentOfTheDatagramsAreLost) {
  RunFor(Milliseconds(500));
  loss_ = 0.3;
  Stream(Milliseconds(1000));
  const RequestToken stop = Request(kEmergencyStop);
  RunFor(Milliseconds(200));
  EXPECT_EQ(board_.taken.back().mode, 0);
  EXPECT_EQ(AnswerOf(stop).code, kCodeOk);
  RunFor(std::chrono::seconds(30));
  EXPECT_EQ(board_.taken.back().mode, 0);
  EXPECT_FALSE(board_.lay_down) << "the stop is kept up";
}

TEST_F(LcmChain, SaysWhyAnEmergencyStopHasNotStoppedTheBody) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(500));
  EXPECT_EQ(StopTrouble(Rules(), core_), "") << "none is set";
  board_.board.deaf = true;
  Do(motion_event::EmergencyStop{});
  EXPECT_NE(StopTrouble(Rules(), core_), "") << "it is only sent";
  RunFor(Milliseconds(1000));
  EXPECT_THAT(StopTrouble(Rules(), core_),
              HasSubstr("the motion board has not taken the stop: it reports mode 11, gait 27"));
  board_.Become(7, 1);
  board_.board.deaf = true;
  board_.board.report.switch_status = 3;
  RunFor(Milliseconds(100));
  EXPECT_THAT(StopTrouble(Rules(), core_), HasSubstr("damps the body, which is not yet off"));
  loss_of_responses_ = 1;
  RunFor(Milliseconds(600));
  EXPECT_THAT(StopTrouble(Rules(), core_), HasSubstr("the motion board is silent"));
  loss_of_responses_ = 0;
  board_.board.deaf = false;
  RunFor(Milliseconds(300));
  EXPECT_EQ(StopTrouble(Rules(), core_), "") << "it reports that it is off";
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk);
  EXPECT_EQ(StopTrouble(Rules(), core_), "") << "it is no longer set";
}

// The board was off when that program took the motors, and reports that still.
TEST_F(LcmChain, ConfirmsNoEmergencyStopWhileAnotherProgramMovesTheMotors) {
  board_ = WireBoard(0, 0);
  RunFor(Milliseconds(500));
  Handle(link_.OnMotorFrame("192.168.44.9:1", now_));
  Do(motion_event::EmergencyStop{});
  RunFor(Milliseconds(500));
  EXPECT_THAT(StopTrouble(Rules(), core_), HasSubstr("192.168.44.9:1 moves the motors directly"));
}

// The board lets the body lie down by its own rule, and would keep it there.
TEST_F(LcmChain, KeepsAnEmergencyStopThatTheBoardHasLeftWhileTheManagerHung) {
  RunFor(Milliseconds(500));
  EXPECT_EQ(AnswerOf(Request(kEmergencyStop)).code, kCodeOk);
  RunFor(Milliseconds(500));
  hangs_ = true;
  RunFor(Milliseconds(600));
  ASSERT_TRUE(board_.lay_down);
  hangs_ = false;
  RunFor(Milliseconds(1000));
  EXPECT_EQ(board_.Report(now_).mode, 0);
  EXPECT_EQ(StopTrouble(Rules(), core_), "");
}

// At each moment of what may go on, with lost datagrams: the body is off 500 ms later, or once the
// board can be reached, and stays so.
TEST_F(LcmChain, StopsInAnEmergencyAtEachMoment) {
  const std::vector<std::function<void()>> scenarios = {
      [&] { Stream(Milliseconds(1200)); },
      [&] { RunFor(Milliseconds(1200)); },
      [&] {
        Request(132);
        RunFor(Milliseconds(1200));
      },
      [&] {
        Do(motion_event::LieDown{++token_, kGetDown, 3});
        RunFor(Milliseconds(1200));
      },
      [&] {
        Stream(Milliseconds(300));
        board_.Restart();
        now_ += kRestartPause;
        sequence_ = 0;
        Stream(Milliseconds(700));
      },
      [&] {
        Stream(Milliseconds(200));
        hangs_ = true;
        RunFor(Milliseconds(550));
        hangs_ = false;
        Stream(Milliseconds(450));
      },
      [&] {
        loss_of_responses_ = 1;
        Stream(Milliseconds(700));
        loss_of_responses_ = 0;
        Stream(Milliseconds(500));
      },
      [&] {
        BodyCommand frame;
        frame.mode = 12;
        for (int i = 0; i < 10; ++i) {
          ++frame.life_count;
          board_.Take(frame, now_);
          Handle(link_.OnOtherFrame("192.168.44.100:7", frame, now_));
          RunFor(Milliseconds(50));
        }
        RunFor(Milliseconds(700));
      },
  };
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    for (Duration at{}; at < Milliseconds(1200); at += Milliseconds(37)) {
      SCOPED_TRACE(::testing::Message()
                   << "scenario " << i << " at " << ToMilliseconds(at) << " ms");
      Reset();
      RunFor(Milliseconds(500));
      loss_ = 0.3;
      stop_at_ = now_ + at;
      scenarios[i]();
      ASSERT_FALSE(stop_at_) << "it was stopped";
      RunFor(Milliseconds(500));
      EXPECT_EQ(board_.Report(now_).mode, 0);
      board_.taken.clear();
      Stream(Milliseconds(300));
      RunFor(Milliseconds(300));
      Stream(Milliseconds(300));
      EXPECT_EQ(board_.Report(now_).mode, 0);
      for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 0);
    }
  }
}

// A machine that was started beside another program's, and is led to TearDown.
TEST_F(LcmChain, LaysNoBodyDownThatAnotherProgramCommands) {
  for (const int tries : {0, 3}) {
    Reset();
    const auto other = [&](Duration duration) {
      BodyCommand walk;
      walk.mode = 11;
      walk.gait = 27;
      for (const Time end = now_ + duration; now_ < end; RunFor(Milliseconds(20))) {
        ++walk.life_count;
        board_.Take(walk, now_);
        Handle(link_.OnOtherFrame("192.168.44.1:7", walk, now_));
      }
    };
    other(Milliseconds(1000));
    board_.taken.clear();
    Do(motion_event::Closed{State(kTearDown)});
    Do(motion_event::LieDown{++token_, kPassiveGetDown, tries});
    other(Milliseconds(3000));
    for (const BodyCommand& frame : board_.taken) ASSERT_EQ(frame.mode, 11) << "not this one's";
    ASSERT_EQ(answers_.count(token_), 1U);
    EXPECT_EQ(answers_[token_].code, 3011);
    EXPECT_THAT(answers_[token_].message, HasSubstr("192.168.44.1:7"));
    Do(motion_event::LieDown{++token_, kPassiveGetDown, tries});
    EXPECT_EQ(AnswerOf(token_).code, kCodeOk) << "the other program has ended";
  }
}

// The body was off before it was commanded to stand up.
TEST_F(LcmChain, ConfirmsNoEmergencyStopByAReportFromBeforeIt) {
  RunFor(Milliseconds(500));
  board_.Become(0, 0);
  RunFor(Milliseconds(500));
  Request(kRecoveryStand);
  Do(motion_event::EmergencyStop{});
  EXPECT_THAT(StopTrouble(Rules(), core_), HasSubstr("has not reported since the stop"));
  RunFor(Milliseconds(300));
  EXPECT_EQ(StopTrouble(Rules(), core_), "");
}

// Received before it, and handled after it: it had waited for the loop, or for the 10 ms between
// two reports that are handed on.
TEST_F(LcmChain, ConfirmsNoEmergencyStopByAReportThatWasReceivedBeforeIt) {
  for (const bool loop : {true, false}) {
    link_ = LcmLink(now_, {config_.board_feedback, ""});
    core_ = MotionCore();
    Do(motion_event::Opened{});
    board_ = WireBoard(0, 0);
    RunFor(Milliseconds(500));
    const BodyReport off = board_.Report(now_);
    now_ += Milliseconds(20);
    if (!loop) {  // the second one of 10 ms waits in the link
      Handle(link_.OnResponse({"192.168.44.233:1", ++sequence_}, off, now_));
      now_ += Milliseconds(2);
      Handle(link_.OnResponse({"192.168.44.233:1", ++sequence_}, off, now_));
    }
    const Time received_at = now_;
    now_ += Milliseconds(1);
    Request(kRecoveryStand);
    Do(motion_event::EmergencyStop{});
    now_ += Milliseconds(12);
    if (loop) {
      LcmLink::Sender sender{"192.168.44.233:1", ++sequence_};
      sender.age = now_ - received_at;
      Handle(link_.OnResponse(sender, off, now_));
    } else {
      Handle(link_.OnTime(now_));
    }
    EXPECT_EQ(core_.body_reported_at, received_at);
    EXPECT_THAT(StopTrouble(Rules(), core_), HasSubstr("has not reported since the stop")) << loop;
    RunFor(Milliseconds(300));
    EXPECT_EQ(StopTrouble(Rules(), core_), "");
  }
}

TEST_F(LcmChain, DoesNotWalkOnAfterARestartOfTheBoardBeforeTheStreamHasPaused) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(1000));
  board_.Restart();
  now_ += kRestartPause;
  sequence_ = 0;
  Stream(Milliseconds(5000));
  EXPECT_EQ(board_.Report(now_).mode, 7);
  for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 7);
  EXPECT_EQ(response_.code, 3035);
  EXPECT_THAT(log_, Contains(HasSubstr("has restarted")));
  RunFor(Milliseconds(300));
  Stream(Milliseconds(5000));
  EXPECT_EQ(board_.Report(now_).gait, 27) << "a new stream: it stands up and walks";
}

TEST_F(LcmChain, DoesNotStandABodyUpThatLiesSinceItsBoardHasRestarted) {
  RunFor(Milliseconds(500));
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk);
  RunFor(Milliseconds(500));
  loss_of_responses_ = 1;  // it starts more slowly than it takes frames
  board_.Restart();
  RunFor(Milliseconds(2000));
  loss_of_responses_ = 0;
  RunFor(Milliseconds(2000));
  EXPECT_EQ(board_.Report(now_).mode, 7);
  for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 7);
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk) << "once it is commanded";
}

TEST_F(LcmChain, KeepsAStreamedPoseUpWhileItsBoardIsSilent) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(1000), 0, kForceControl);
  loss_of_responses_ = 1;
  Stream(Milliseconds(600), 0, kForceControl);
  loss_of_responses_ = 0;
  board_.taken.clear();
  Stream(Milliseconds(2000), 0, kForceControl);
  EXPECT_FALSE(board_.lay_down);
  EXPECT_EQ(board_.Report(now_).mode, 3);
  EXPECT_GT(board_.taken.size(), 30U) << "it follows the stream";
}

TEST_F(LcmChain, DoesNotCommandAWalkToABodyThatLiesAfterTheManagerHung) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(1000));
  hangs_ = true;
  RunFor(Milliseconds(600));
  hangs_ = false;
  board_.taken.clear();
  board_.refuses = false;
  Stream(Milliseconds(2000));
  for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 7);
  EXPECT_EQ(response_.code, 3035);
  RunFor(Milliseconds(300));
  Stream(Milliseconds(5000));
  EXPECT_EQ(board_.Report(now_).gait, 27) << "a new stream: it stands up and walks";
}

TEST_F(LcmChain, LetsALyingBodyLieThatWasCommandedToStandWhileTheCableWasOut) {
  board_.Become(7, 1);
  RunFor(Milliseconds(500));
  loss_ = 1;
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, 3035);
  RunFor(std::chrono::seconds(60));
  loss_ = 0;
  board_.taken.clear();
  RunFor(std::chrono::seconds(5));
  EXPECT_EQ(board_.Report(now_).mode, 7);
  for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 7);
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk) << "once it is commanded again";
}

// By remote control, or because the board has stopped by itself.
TEST_F(LcmChain, StandsABodyUpThatWasStoppedAtItsBoardByRecoveryStandAlone) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(500));
  for (const std::int8_t status : std::array<std::int8_t, 3>{0, 2, 3}) {
    SCOPED_TRACE(::testing::Message() << "status " << int{status});
    board_.Become(status == 3 ? 7 : 0, 0);
    board_.board.report.switch_status = status;
    RunFor(Milliseconds(100));
    board_.taken.clear();
    Stream(Milliseconds(1000));
    RunFor(Milliseconds(300));
    Stream(Milliseconds(1000));
    EXPECT_EQ(response_.code, 3040);
    EXPECT_EQ(AnswerOf(Request(132)).code, 3040);
    for (const BodyCommand& frame : board_.taken) EXPECT_EQ(frame.mode, 7);
    EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk);
    Stream(Milliseconds(500));
    EXPECT_EQ(board_.Report(now_).gait, 27);
  }
}

TEST_F(LcmChain, StandsWalksAndLiesDownAfterATiltThatTheBoardStillReports) {
  RunFor(Milliseconds(500));
  board_.Become(0, 0);
  board_.board.report.ori_error = 1;  // kept until it walks
  RunFor(Milliseconds(100));
  EXPECT_EQ(AnswerOf(Request(kGetDown)).code, 3040) << "only recovery stand passes";
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk);
  EXPECT_EQ(AnswerOf(Request(kGetDown)).code, kCodeOk);
  EXPECT_EQ(AnswerOf(Request(kRecoveryStand)).code, kCodeOk);
  Stream(Milliseconds(1000));
  EXPECT_EQ(board_.Report(now_).gait, 27);
}

TEST_F(LcmChain, AnswersThatABodyLiesThatLiesByPassiveGetDown) {
  board_.Become(7, 0);
  RunFor(Milliseconds(1500));
  const std::size_t before = board_.taken.size();
  Do(motion_event::LieDown{++token_, kGetDown, 3});
  EXPECT_EQ(AnswerOf(token_).code, kCodeOk);
  EXPECT_EQ(board_.taken.size(), before);
}

TEST_F(LcmChain, AnswersWhatTheBoardReportsWhenItNeverTakesTheMotion) {
  RunFor(Milliseconds(500));
  board_.board.deaf = true;
  const motion_action::Answer answer = AnswerOf(Request(132));
  EXPECT_EQ(answer.code, 3035);
  EXPECT_THAT(answer.message, HasSubstr("has not taken it within 200 ms; it reports mode 12"));
}

TEST_F(LcmChain, ReportsToAStreamThatTheBoardDoesNotTakeIt) {
  RunFor(Milliseconds(500));
  board_.board.deaf = true;
  Stream(Milliseconds(1500));
  EXPECT_EQ(response_.code, 3035);
  EXPECT_FALSE(response_.result);
  const std::string text =
      "servo motion 303: the motion board has not taken it within 500 ms; it reports mode 12, gait "
      "0";
  EXPECT_THAT(log_, ::testing::Contains(HasSubstr(text)));
  board_.board.deaf = false;
  Stream(Milliseconds(1000));
  EXPECT_TRUE(response_.result) << "the board takes it now";
}

// The first frame after the hang is read before the board's report; the last one is of the time
// before the walk.
TEST_F(LcmChain, DoesNotReportToAStreamWhatTheBoardHadNotTakenBeforeAHang) {
  RunFor(Milliseconds(500));
  Stream(Milliseconds(1));
  hangs_ = true;
  RunFor(Milliseconds(700));
  hangs_ = false;
  Stream(Milliseconds(1));
  EXPECT_EQ(response_.code, 0);
  Stream(Milliseconds(1000));
  EXPECT_THAT(log_, ::testing::Contains(HasSubstr("is stopped: the body lies")));
  EXPECT_THAT(log_, ::testing::Not(::testing::Contains(HasSubstr("has not taken it"))));
}

TEST_F(LcmChain, RefusesMotionsWhileAnotherProgramCommandsTheBoard) {
  RunFor(Milliseconds(500));
  const auto other = [&] {
    BodyCommand frame;
    frame.mode = 12;
    Handle(link_.OnOtherFrame("192.168.44.100:7", frame, now_));
  };
  Stream(Milliseconds(500));
  other();
  EXPECT_EQ(board_.taken.back().gait, 1) << "the walk is stopped";
  other();
  const motion_action::Answer answer = AnswerOf(Request(132));
  EXPECT_EQ(answer.code, 3011);
  EXPECT_THAT(answer.message, HasSubstr("192.168.44.100:7"));
  RunFor(Milliseconds(1000));
  EXPECT_EQ(AnswerOf(Request(132)).code, kCodeOk) << "it has ended";
}

TEST_F(LcmChain, AccusesTheBoardOfNoFloodWhileAFastStreamChanges) {
  RunFor(Milliseconds(500));
  for (int i = 0; i < 5000; ++i) {
    ServoCommand command;
    command.requested.id = kUserTrot;
    command.requested.arguments.vel_des = {i % 2 == 0 ? 0.1F : 0.2F, 0, 0};
    Do(motion_event::ServoArrived{command});
    RunFor(Milliseconds(5));
  }
  RunFor(Milliseconds(1500));
  EXPECT_THAT(log_, Not(Contains(HasSubstr("responses a second"))));
}

TEST_F(LcmChain, TakesASentenceOfTheLinkIntoTheLog) {
  Do(motion_event::BoardFault{3010, "a datagram is dropped"});
  EXPECT_THAT(log_, Contains("a datagram is dropped (3010)"));
}

}  // namespace musher::motion::testing::lcm_chain_test
