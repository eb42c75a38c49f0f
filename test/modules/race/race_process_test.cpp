// musher-race as a controller and an operator use it: the real program over DDS, with fakes of the
// body, the voice, two detectors and the line walker.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/module_process.hpp"

namespace musher::race::race_process_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// With limits that a busy computer keeps, too.
constexpr const char* kCourse = R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
[robot]
self_check_ms = 15000
record = "race.record"
[body]
silent_ms = 20000
[checks]
picture_ms = 20000
silent_ms = 60000
[detector.qr]
topic = "/qr_detector/sighting"
type = "sighting"
[detector.lines]
topic = "/yellow_line_detector/front"
type = "lines"
[movement.forward]
motion = 303
twist = [0.4, 0.0, 0.0]
[movement.stand]
motion = 111
[movement.lie_down]
motion = 101
[result.qr_a]
values = ["A-1", "A-2"]
command = "SET_QR_A"
shown = true
[check.ahead]
detector = "lines"
word = "ycy"
[wait.qr_a]
detector = "qr"
result = "qr_a"
limit_ms = 120000
otherwise = "ERROR"
[walk.lane]
command = "/yellow_line_walker/command"
status = "/yellow_line_walker/status"
silent_ms = 20000
otherwise = "ERROR"
[speech.qr_a]
result = "qr_a"
texts."A-2" = { zh = "A区库位2", en = "Zone A, bay 2" }
[state.START]
number = 0
next = "DRIVE"
[state.DRIVE]
number = 1
steps = [{ move = "stand" }, { move = "forward", count = 3 }, { check = "ahead" }]
next = "BOARD"
[state.BOARD]
number = 2
steps = [{ wait = "qr_a" }, { say = "qr_a" }]
next = "LANE"
[state.LANE]
number = 3
steps = [{ walk = "lane" }]
next = "END"
[state.END]
number = 45
[state.ERROR]
number = 46
steps = [{ move = "lie_down" }]
)";

// For a check that fails.
std::string CourseWithAShortCheck() {
  std::string course = kCourse;
  const std::string time = "self_check_ms = 15000";
  return course.replace(course.find(time), time.size(), "self_check_ms = 5000");
}

class RaceProcess : public test::ModuleProcess {
 protected:
  RaceProcess() : ModuleProcess("race", "musher-race") {
    const transport::Qos all{.depth = 0};
    Subscribe<msg::String>(
        "state_machine/state_info",
        [this](const msg::String& text) {
          infos_.push_back(text.data);
          if (text.data.starts_with("State:")) states_.push_back(text.data);
        },
        all);
    Subscribe<msg::String>(
        "yellow_line_walker/command",
        [this](const msg::String& text) {
          if (text.data == "HEARTBEAT") {
            ++heartbeats_;
          } else {
            walker_.push_back(text.data);
          }
        },
        all);
    Subscribe<msg::MotionServoCmd>(
        "motion_servo_cmd", [this](const msg::MotionServoCmd& frame) { frames_.push_back(frame); },
        all);
    command_ = Publisher<msg::String>("state_machine/start_command");
    walker_status_ = Publisher<msg::String>("yellow_line_walker/status");
    lines_ = Publisher<msg::YellowLines>("yellow_line_detector/front");
    body_ = Publisher<msg::MotionStatus>("motion_status");
    motion_ = transport::MakeServer<msg::MotionResultCmd>(
                  peer_.node(), "motion_result_cmd",
                  [this](const auto& request, const auto& reply, auto) {
                    motions_.push_back(request.motion_id);
                    msg::MotionResultCmd::Response done;
                    done.motion_id = request.motion_id;
                    done.result = motion_code_ == 0;
                    done.code = motion_code_;
                    reply(done);
                  })
                  .value();
    speech_ = transport::MakeServer<msg::AudioTextPlay>(
                  peer_.node(), "speech_text_play",
                  [this](const auto& request, const auto& reply, auto) {
                    EXPECT_TRUE(request.is_online);
                    spoken_.push_back(request.text);
                    reply({});
                  })
                  .value();
    OpenQr();
    turns_ = peer_.node().loop().Every(Milliseconds(100), [this] { Publish(); });
  }
  void OpenQr() { qr_ = Publisher<msg::Sighting>("qr_detector/sighting"); }

  void StartActive(const std::string& course = kCourse) {
    Start(course);
    ASSERT_TRUE(peer_.Until([&] {
      return command_->MatchedReaders() == 1 &&
             std::ranges::all_of(subscriptions_,
                                 [](const auto& one) { return one->MatchedWriters() == 1; });
    }));
    ExpectDone("SelfCheck");
    ExpectDone("Active");
    // That of a race that begins to run.
    ASSERT_TRUE(peer_.Until([&] { return walker_.size() == 1; }));
    EXPECT_EQ(walker_.front(), "STOP");
    walker_.clear();
  }
  // Of a course whose check is over soon: its parts may be discovered only during a later one.
  bool AwaitSelfCheck() {
    return peer_.Until([this] {
      const auto checked = peer_.Switch("SelfCheck");
      return checked && checked.value().verdict == msg::ActuatorCommand::kVerdictDone;
    });
  }
  void Command(const std::string& text) { ASSERT_TRUE(command_->Publish({text})); }
  bool AwaitState(const std::string& text) {
    return peer_.Until([&] { return std::ranges::find(states_, text) != states_.end(); });
  }
  int Ends() const {
    return static_cast<int>(
        std::ranges::count(frames_, msg::MotionServoCmd::kEnd, &msg::MotionServoCmd::cmd_type));
  }
  // Where two publishers of the topic take turns.
  template <msg::Message M>
  void ExpectErrorOfTwo(const std::string& topic,
                        const transport::Qos& qos = transport::kDefaultQos) {
    Command("START:BOARD");
    ASSERT_TRUE(AwaitState("State:2")) << peer_.Output();
    const auto one = Publisher<M>(topic, qos), other = Publisher<M>(topic, qos);
    const auto turns = peer_.node().loop().Every(Milliseconds(50), [&] {
      static_cast<void>(one->Publish({}));
      static_cast<void>(other->Publish({}));
    });
    ASSERT_TRUE(AwaitState("State:46")) << topic << "\n" << peer_.Output();
    ASSERT_TRUE(peer_.Until([&] {
      return infos_.back().find("two publishers of " + topic) != std::string::npos;
    })) << infos_.back();
  }
  // Runs the program as a person does.
  int RunTool(std::vector<std::string> words) {
    words.insert(words.begin(), "musher-race");
    return Run(std::move(words));
  }

  std::int32_t motion_code_ = 0;
  std::string reads_ = "A-2";
  std::string walker_says_ = "State:IDLE,Active:False";
  std::vector<std::string> infos_;
  std::vector<std::string> states_;
  std::vector<std::string> walker_;
  int heartbeats_ = 0;  // that the walker gets
  std::vector<std::string> spoken_;
  std::vector<std::int32_t> motions_;
  std::vector<msg::MotionServoCmd> frames_;
  std::unique_ptr<transport::Publisher<msg::Sighting>> qr_;

 private:
  void Publish() {
    if (qr_) {
      msg::Sighting sighting;
      sighting.header.stamp = Stamp();
      sighting.seen = true;
      sighting.text = reads_;
      static_cast<void>(qr_->Publish(sighting));
    }
    msg::YellowLines lines;
    lines.header.stamp = Stamp();
    lines.contours = 2;
    lines.ycy = lines.dy = lines.walk = "center";
    static_cast<void>(lines_->Publish(lines));
    if (odometry_) {
      msg::Odometry odometry;
      odometry.header.stamp = Stamp();
      odometry.pose.pose.orientation.w = 1;
      static_cast<void>(odometry_->Publish(odometry));
    }
    const bool walks = !walker_.empty() && walker_.back() == "START";
    static_cast<void>(walker_status_->Publish({walks ? walker_says_ : "State:IDLE,Active:False"}));
    msg::MotionStatus body;
    body.motion_id = msg::MotionId::kWalkUserTrot;
    static_cast<void>(body_->Publish(body));
  }
  static msg::Stamp Stamp() {
    return msg::ToStamp(std::chrono::system_clock::now().time_since_epoch());
  }

 protected:
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::String>> walker_status_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> lines_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> body_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;  // of a body that stands still
  std::unique_ptr<transport::Server<msg::MotionResultCmd>> motion_;
  std::unique_ptr<transport::Server<msg::AudioTextPlay>> speech_;
  transport::LoopHandlePtr turns_;
};

TEST_F(RaceProcess, RunsACourseToItsEndAndReplaysItsRecording) {
  walker_says_ = "State:WALKING,Active:True";
  StartActive();
  ASSERT_TRUE(peer_.Until([&] { return qr_->MatchedReaders() == 0; }));  // not needed yet
  Command("START");
  ASSERT_TRUE(AwaitState("State:3")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] { return walker_.size() == 1; }));
  ASSERT_TRUE(peer_.Until([&] { return qr_->MatchedReaders() == 0; }));  // not needed any more
  const std::size_t count = infos_.size();
  ASSERT_TRUE(peer_.Until([&] { return infos_.size() > count + 10; }));
  EXPECT_TRUE(peer_.Until([&] { return heartbeats_ >= 3; }));
  walker_says_ = "State:IDLE,Active:False,End:course_end";
  ASSERT_TRUE(AwaitState("State:45")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] {
    return infos_.back() == "CurrentState:45,QRResult:A-2,TaskCompleted:True,Reservations:0";
  }));
  ASSERT_TRUE(peer_.Until([&] { return walker_.size() >= 2; }));
  EXPECT_THAT(walker_, ElementsAre("START", "STOP"));
  EXPECT_THAT(motions_, ElementsAre(111));
  EXPECT_THAT(spoken_, ElementsAre("A区库位2"));
  EXPECT_EQ(Ends(), 1);
  EXPECT_EQ(frames_.back().cmd_type, msg::MotionServoCmd::kEnd);
  EXPECT_EQ(frames_.front().cmd_type, msg::MotionServoCmd::kData);
  EXPECT_EQ(frames_.front().motion_id, 303);
  EXPECT_EQ(frames_.front().cmd_source, msg::MotionSource::kAlgo);
  EXPECT_THAT(frames_.front().vel_des, ElementsAre(0.4F, 0.0F, 0.0F));
  EXPECT_THAT(frames_.front().step_height, ElementsAre(0.05F, 0.05F));
  ExpectTornDown();
  EXPECT_EQ(RunTool({"replay", "race.record", "race.toml"}), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("LANE -> END"));
  EXPECT_THAT(Said(), HasSubstr("identical"));
}

TEST_F(RaceProcess, KeepsAReservationWhereTheOdometryStandsStill) {
  walker_says_ = "State:WALKING,Active:True";
  odometry_ = Publisher<msg::Odometry>("odom_out", transport::kSensorDataQos);
  std::string course = kCourse;
  const std::string old = "count = 3";
  course.replace(course.find(old), old.size(), "count = 40");
  StartActive(course + "[odometry]\ntopic = \"odom_out\"\nfresh_ms = 2000\nblocked_share = 0\n");
  ASSERT_TRUE(peer_.Until([&] { return odometry_->MatchedReaders() == 1; }));
  Command("START");
  ASSERT_TRUE(AwaitState("State:3")) << peer_.Output();
  const std::size_t count = infos_.size();
  ASSERT_TRUE(peer_.Until([&] { return infos_.size() > count + 10; }));
  walker_says_ = "State:IDLE,Active:False,End:course_end";
  ASSERT_TRUE(AwaitState("State:45")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] {
    return infos_.back().find("TaskCompleted:True,Reservations:1,FirstReservation:DRIVE: ") !=
           std::string::npos;
  })) << infos_.back();
  EXPECT_THAT(infos_.back(), HasSubstr("40 steps made"));
  EXPECT_THAT(infos_.back(), HasSubstr("the feet slip; or something is in the way"));
  ExpectTornDown();
  EXPECT_EQ(RunTool({"replay", "race.record", "race.toml"}), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("identical"));
}

TEST_F(RaceProcess, PausesInLowPowerAndContinuesInActive) {
  walker_says_ = "State:WALKING,Active:True";
  StartActive();
  Command("START:LANE");
  ASSERT_TRUE(peer_.Until([&] { return walker_.size() == 1; })) << peer_.Output();
  ExpectDone("LowPower");
  ASSERT_TRUE(peer_.Until([&] { return walker_.size() == 2; }));
  EXPECT_EQ(walker_.back(), "STOP");
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] { return walker_.size() == 3; }));
  EXPECT_EQ(walker_.back(), "START");
}

TEST_F(RaceProcess, ThatWasKilledStandsInItsStartUntilTheCommand) {
  StartActive();
  Command("START");
  ASSERT_TRUE(AwaitState("State:1")) << peer_.Output();
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  ASSERT_TRUE(peer_.Until([this] { return !frames_.empty(); }));  // it walks
  EXPECT_EQ(frames_.front().cmd_type, msg::MotionServoCmd::kData);
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_TRUE(peer_.Until([this] { return subscriptions_.front()->MatchedWriters() == 0; }));
  frames_.clear();
  motions_.clear();
  infos_.clear();
  states_.clear();
  StartActive();
  ASSERT_TRUE(peer_.Until([this] { return infos_.size() > 10; }));  // it publishes while it waits
  EXPECT_THAT(states_, ::testing::Each("State:0"));
  EXPECT_TRUE(motions_.empty());
  EXPECT_TRUE(frames_.empty());
  Command("START");
  EXPECT_TRUE(AwaitState("State:1"));
}

TEST_F(RaceProcess, GoesToErrorWithTheReasonWhenAMotionFails) {
  motion_code_ = 3035;
  StartActive();
  Command("START");
  ASSERT_TRUE(AwaitState("State:46")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] {
    return infos_.back().find("Reason:DRIVE: the motion stand (111) failed: 3035") !=
           std::string::npos;
  })) << infos_.back();
  ASSERT_TRUE(peer_.Until([&] { return motions_.size() == 2; }));
  EXPECT_THAT(motions_, ElementsAre(111, 101));
}

TEST_F(RaceProcess, FailsItsSelfCheckWithTheDetectorThatIsMissing) {
  qr_.reset();
  Start(CourseWithAShortCheck());
  EXPECT_THAT(Failure(kSelfCheck), HasSubstr("cameras: no publisher of /qr_detector/sighting"));
  OpenQr();
  EXPECT_TRUE(AwaitSelfCheck()) << peer_.Output();
}

TEST_F(RaceProcess, FailsItsSelfCheckWithTheDetectorThatTwoPublish) {
  auto second = Publisher<msg::Sighting>("qr_detector/sighting");
  Start(CourseWithAShortCheck());
  EXPECT_THAT(Failure(kSelfCheck),
              HasSubstr("cameras: more than one publisher of /qr_detector/sighting"));
  second.reset();
  EXPECT_TRUE(AwaitSelfCheck()) << peer_.Output();
}

TEST_F(RaceProcess, GoesToErrorWhereASecondPublisherOfADetectorAppears) {
  StartActive();
  std::string course = kCourse;
  Command("START:BOARD");
  qr_.reset();
  OpenQr();  // a restarted one
  reads_ = "C-3";
  const auto second = Publisher<msg::Sighting>("qr_detector/sighting");
  const auto turns =
      peer_.node().loop().Every(Milliseconds(70), [&] { static_cast<void>(second->Publish({})); });
  ASSERT_TRUE(AwaitState("State:46")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] {
    return infos_.back().find("two publishers of /qr_detector/sighting") != std::string::npos;
  })) << infos_.back();
}

// Its reports hid that this body had fallen, or that it was refused to walk. Each topic has a race
// of its own: samples of the topic before may arrive after the command that starts the next.
TEST_F(RaceProcess, GoesToErrorWhereASecondBodyReportsItsStatus) {
  reads_ = "C-3";
  StartActive();
  ExpectErrorOfTwo<msg::MotionStatus>("motion_status");
}

TEST_F(RaceProcess, GoesToErrorWhereASecondBodyAnswersServoFrames) {
  reads_ = "C-3";
  StartActive();
  ExpectErrorOfTwo<msg::MotionServoResponse>("motion_servo_response");
}

TEST_F(RaceProcess, GoesToErrorWhereASecondBodyReportsItsOdometry) {
  reads_ = "C-3";
  StartActive(kCourse + std::string("[odometry]\ntopic = \"odom_out\"\n"));
  ExpectErrorOfTwo<msg::Odometry>("odom_out", transport::kSensorDataQos);
}

// Each turn put it on its charger once more, which is a fault, also where a person had started it
// there; and its log did not name the second one.
TEST_F(RaceProcess, DoesNotBelieveTwoBatteriesInTurn) {
  reads_ = "C-3";
  StartActive();
  const auto charges = Publisher<msg::BmsStatus>("bms_status");
  const auto does_not = Publisher<msg::BmsStatus>("bms_status");
  int turns = 0;
  const auto ticker = peer_.node().loop().Every(Milliseconds(50), [&] {
    msg::BmsStatus status;
    status.power_wired_charging = true;
    static_cast<void>(charges->Publish(status));
    static_cast<void>(does_not->Publish({}));
    ++turns;
  });
  ASSERT_TRUE(AwaitOutput("two publishers of bms_status are received in turn")) << peer_.Output();
  Command("START:BOARD");
  ASSERT_TRUE(AwaitState("State:2")) << peer_.Output();
  const int begun = turns;
  ASSERT_TRUE(peer_.Until([&] { return turns > begun + 20; }));
  EXPECT_EQ(std::ranges::count(states_, "State:46"), 0) << infos_.back();
}

TEST_F(RaceProcess, TakesCommandsOfItsTool) {
  StartActive();
  EXPECT_EQ(RunTool({"send", "SET_QR_A:A-1"}), 0) << Said();
  EXPECT_EQ(RunTool({"send", "--json", "SET_QR_A:A-1"}), 0) << Said();
  EXPECT_EQ(RunTool({"send", "command", "START:BOARD", "--json"}), 0) << Said();
  EXPECT_EQ(Said(), "{\"sent\": true}\n");
  ASSERT_TRUE(AwaitState("State:3")) << peer_.Output();
  EXPECT_THAT(infos_, Contains(HasSubstr("QRResult:A-1")));
  EXPECT_EQ(RunTool({"send"}), 2);
}

// The tool published once any reader was matched: with a recorder of the topic the race missed it.
TEST_F(RaceProcess, ACommandOfTheToolIsForTheRaceAndNotForAnotherReader) {
  int recorded = 0;
  const auto recorder = transport::MakeSubscription<msg::String>(
      peer_.node(), "state_machine/start_command",
      [&](const msg::String&, const transport::SampleInfo&) { ++recorded; });
  ASSERT_TRUE(recorder);
  EXPECT_EQ(RunTool({"send", "RESET"}), 1);
  EXPECT_THAT(Said(), HasSubstr("no race subscribes to state_machine/start_command"));
  peer_.node().loop().RunUntil([] { return false; }, peer_.node().loop().Now());
  EXPECT_EQ(recorded, 0);
}

TEST_F(RaceProcess, ChecksACourse) {
  EXPECT_EQ(RunTool({"check", SourceDir() + "/config/race/course.toml"}), 0);
  EXPECT_THAT(Said(), HasSubstr("42 states"));
  EXPECT_EQ(RunTool({"check", SourceDir() + "/test/modules/race/courses/stuck.toml"}), 2);
  EXPECT_THAT(Said(),
              HasSubstr("stuck.toml:24:8: error: state.FORK: has no transition in the case"));
  EXPECT_EQ(RunTool({"check"}), 2);
}

TEST_F(RaceProcess, PrintsACourseForAnotherHall) {
  const std::string config = SourceDir() + "/config/";
  const std::string hall = peer_.folder() / "hall.toml";
  std::ofstream(hall) << "start_m = 1.33\nline_m = 0.04\n";
  EXPECT_EQ(RunTool({"course", hall, config + "race/course.toml"}), 1);
  EXPECT_THAT(Said(), HasSubstr("not derived: start_m: where the line ahead is seen from START"));
  EXPECT_THAT(Said(), HasSubstr("start_m = 1.33"));
  EXPECT_THAT(Said(), HasSubstr("state.START_TO_QRA: forward 12 -> 17 (0.40 m more)"));
  EXPECT_EQ(RunTool({"course", hall, config + "race/course.toml", "--vision",
                     config + "vision/course.toml"}),
            1);
  EXPECT_THAT(Said(), HasSubstr("lane_m = 0.87 "));
  EXPECT_EQ(RunTool({"course", hall, config + "race/course.toml", "--walker",
                     config + "line_walker/walker.toml"}),
            0);
  EXPECT_EQ(RunTool({"course", config + "race/course.toml", "--start", "1.33", "--line", "0.04"}),
            1);
  EXPECT_THAT(Said(), HasSubstr("state.START_TO_QRA: forward 12 -> 17 (0.40 m more)"));
  EXPECT_EQ(RunTool({"course", hall, config + "race/course.toml", "--start", "0.93"}), 0);
  EXPECT_THAT(Said(), HasSubstr("start_m = 0.93")) << "an option is over the file";
  EXPECT_EQ(RunTool({"course", config + "race/course.toml", "--lane", "9"}), 2);
  EXPECT_THAT(Said(),
              HasSubstr("options:1:10: error: lane_m: expected a number from 0.4 to 3, found 9"));
  const std::string folder = peer_.folder() / "here";
  const std::vector<std::string> all = {
      "course",   config + "race/course.toml",   "--lane",   "0.9",
      "--vision", config + "vision/course.toml", "--walker", config + "line_walker/walker.toml"};
  EXPECT_EQ(RunTool(all), 2);
  EXPECT_THAT(Said(), HasSubstr("both with --write"));
  std::vector<std::string> to_folder = all;
  to_folder.insert(to_folder.end(), {"--write", folder});
  EXPECT_EQ(RunTool(to_folder), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("walker.toml: lane: width_m 0.83 -> 0.9"));
  EXPECT_THAT(Said(), HasSubstr("vision.toml: hall: lane_m 0.95"));
  EXPECT_EQ(RunTool({"check", folder + "/course.toml"}), 0) << Said();
  EXPECT_EQ(RunTool(to_folder), 2) << "it overwrites nothing";
  EXPECT_THAT(Said(), HasSubstr("course.toml: error: there is such a file already"));
  EXPECT_EQ(RunTool({"course", "/no/such.toml", config + "race/course.toml"}), 2);
  EXPECT_EQ(RunTool({"course", hall}), 2);
}

}  // namespace musher::race::race_process_test
