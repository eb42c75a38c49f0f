#pragma once
// A race without a robot: virtual time, 20 ticks a second, and a fake of everything around it. The
// fake answers motions and speech, moves a body by the frames, publishes samples of the detectors
// that are wanted, and checks each servo stream: frames, then exactly one end.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::race {

// As odometry_share of the course has them.
inline constexpr double kWalkShare = 0.97;
inline constexpr double kTurnShare = 0.9;
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

inline std::string CourseFile() {
  return SourceDir() + "/config/race/course.toml";
}
inline const Course& TheCourse() {
  static const CourseReading reading = ReadCourseFile(CourseFile());
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  static const Course course = reading.course.value_or(Course{});
  return course;
}

class Field : public RaceOutputs {
 public:
  void Walk(const ServoFrame& frame) override {
    if (frame.end) {
      EXPECT_TRUE(streaming) << "an end without a stream";
      ++ends;
    } else if (!streaming) {
      ++streams;
      frames_of_stream.push_back(0);
    }
    if (!frame.end) ++frames_of_stream.back();
    streaming = !frame.end;
    frames.push_back(frame);
  }
  void Move(std::int32_t motion_id, std::uint64_t number) override {
    EXPECT_FALSE(streaming) << "a motion during a stream";
    motions.push_back(motion_id);
    calls.push_back(number);
  }
  void CommandWalker(const LaneWalk& /*walk*/, bool start) override {
    walker.emplace_back(start ? "START" : "STOP");
    walking_lane = start;
  }
  void Watch(const std::vector<bool>& detectors) override { watched = detectors; }
  void Speak(const std::string& text, std::uint64_t number) override {
    spoken.push_back(text);
    speeches.push_back(number);
  }
  void ShowState(int number) override { states.push_back(number); }
  void Log(const std::string& line) override { log.push_back(line); }

  bool Logged(std::string_view part) const {
    for (const std::string& line : log) {
      if (line.find(part) != std::string::npos) return true;
    }
    return false;
  }

  bool streaming = false;
  int streams = 0;
  int ends = 0;
  std::vector<int> frames_of_stream;
  std::vector<ServoFrame> frames;
  std::vector<std::int32_t> motions;
  std::vector<std::uint64_t> calls;
  std::vector<std::string> walker;
  bool walking_lane = false;
  std::vector<bool> watched;
  std::vector<std::string> spoken;
  std::vector<std::uint64_t> speeches;
  std::vector<int> states;
  std::vector<std::string> log;
};

// A message of the odometry.
struct OdometrySample {
  navigation::Pose pose;
  Time stamp;
  Duration age{};
};

// What the fake perception publishes; each may be replaced by a test.
struct Script {
  std::function<Sighting(const std::string& detector)> sight;
  std::function<Lines(const std::string& detector)> lines;
  std::function<std::string(Duration walked)> walker;
  std::function<Result<>(std::int32_t motion)> motion;
  bool motion_replies = true;
  bool speech_replies = true;
  bool body_reports = true;
  int body_status = 0;
  bool cameras = true;
  std::set<std::string> silent;  // detectors without samples
  Duration picture_age = Milliseconds(60);
  std::optional<Time> picture_taken;  // of all pictures
  double slip = 0;                    // beside what the feet slip as usual
  double lane_m_s = 0.62;             // of the line walker: 5 m in 8 s
  // Of the true pose, with the present time as stamp; null: there is no odometry.
  std::function<std::optional<OdometrySample>(OdometrySample truth)> odometry;
};

inline std::optional<OdometrySample> Truth(OdometrySample truth) {
  return truth;
}

class Rig {
 public:
  explicit Rig(const Course& course = TheCourse()) : course_(course) {
    script.sight = [](const std::string&) { return Sighting{false, kUnknown, "", ""}; };
    script.lines = [](const std::string&) {
      return Lines{1, LineWord::kCenter, LineWord::kCenter};
    };
    script.walker = [](Duration walked) -> std::string {
      return walked < Milliseconds(8000) ? "State:WALKING,Active:True"
                                         : "State:IDLE,Active:False,End:course_end";
    };
    script.motion = [](std::int32_t) { return Ok(); };
    machine = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "race", .commands = 32});
    race = std::make_unique<Race>(course_, field);
    const Result<> built = race->Build(*machine);
    EXPECT_TRUE(built) << (built ? "" : built.error().message);
    recorder = std::make_unique<fsm::Recorder>(
        *machine, [this](std::string_view line) { recording += line; });
    race->RecordTo(*recorder);
    race->Resume(now);
    field.walker.clear();
    EXPECT_TRUE(machine->Start(now));
  }

  void Tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      now += Milliseconds(50);
      MoveBody();
      if (race->resting()) {
        Answer();
        PublishOdometry();
        continue;
      }
      Answer();
      Publish();
      machine->RunOnce(now);
      race->AfterTick();
      const std::string state(race->state());
      if (visited.empty() || visited.back() != state) visited.push_back(state);
    }
  }
  void Run(Duration time) { Tick(static_cast<int>(time / Milliseconds(50))); }
  // Ticks until the state is `state`; false: not within `most`.
  bool RunTo(std::string_view state, Duration most = std::chrono::hours(1)) {
    for (Duration passed{}; passed < most; passed += Milliseconds(50)) {
      if (race->state() == state) return true;
      Tick();
    }
    return race->state() == state;
  }
  bool RunUntil(const std::function<bool()>& done, Duration most = std::chrono::minutes(5)) {
    for (Duration passed{}; passed < most; passed += Milliseconds(50)) {
      if (done()) return true;
      Tick();
    }
    return done();
  }
  void Command(std::string_view text) { race->OnCommand(text, now); }
  bool Wants(std::string_view detector) const {
    const auto index = FindByName(course_.detectors, detector);
    return index && *index < field.watched.size() && field.watched[*index];
  }
  std::string_view state() const { return race->state(); }
  // How many frames have led there, as { 0.4, 0, 0 }.
  int FramesOf(const Twist& twist) const {
    return static_cast<int>(std::ranges::count_if(field.frames, [&](const ServoFrame& frame) {
      return !frame.end && frame.twist.forward_m_s == twist.forward_m_s &&
             frame.twist.left_m_s == twist.left_m_s;
    }));
  }

  const Course course_;
  Field field;
  Script script;
  Time now{Milliseconds(1000)};
  std::unique_ptr<fsm::Machine> machine;
  std::string recording;
  std::unique_ptr<fsm::Recorder> recorder;  // before the race, which uses it
  std::unique_ptr<Race> race;
  std::vector<std::string> visited;
  navigation::Pose pose;  // the true one

 private:
  // It takes up each speed at once.
  void MoveBody() {
    if (field.walking_lane && !field.streaming) pose.at.x_m += script.lane_m_s * 0.05;
    if (!field.streaming) return;
    const Twist& twist = field.frames.back().twist;
    const double walk = kWalkShare * (1 - script.slip);
    const double turn_rad = kTurnShare * (1 - script.slip) * twist.yaw_rad_s * 0.05;
    const double yaw_rad = pose.yaw_rad + turn_rad / 2;
    const double ahead_m = walk * twist.forward_m_s * 0.05;
    const double left_m = walk * twist.left_m_s * 0.05;
    pose.at.x_m += ahead_m * std::cos(yaw_rad) - left_m * std::sin(yaw_rad);
    pose.at.y_m += ahead_m * std::sin(yaw_rad) + left_m * std::cos(yaw_rad);
    pose.yaw_rad = navigation::Wrapped(pose.yaw_rad + turn_rad);
  }
  // Motions are answered after 500 ms, phrases after 300 ms.
  void Answer() {
    if (script.motion_replies && !field.calls.empty() && ++motion_wait_ >= 10) {
      motion_wait_ = 0;
      const std::uint64_t call = field.calls.front();
      field.calls.erase(field.calls.begin());
      race->OnMotionDone(call, script.motion(field.motions.back()), now);
    }
    if (script.speech_replies && !field.speeches.empty() && ++speech_wait_ >= 6) {
      speech_wait_ = 0;
      const std::uint64_t speech = field.speeches.front();
      field.speeches.erase(field.speeches.begin());
      race->OnSpoken(speech, Ok(), now);
    }
    if (script.body_reports) race->OnBody(script.body_status, 303, now);
  }
  void PublishOdometry() {
    if (!script.odometry) return;
    const auto sample = script.odometry({pose, now, {}});
    if (!sample) return;
    race->OnOdometry(sample->stamp.time_since_epoch().count(), sample->pose, now - sample->age,
                     now);
  }
  // Ten pictures a second.
  void Publish() {
    ++turn_;
    PublishOdometry();
    lane_ = field.walking_lane ? lane_ + Milliseconds(50) : Duration(0);
    if (turn_ % 2 != 0) return;
    const std::string status = script.walker(lane_);
    if (!status.empty()) race->OnWalkerStatus(0, status, now);
    if (!script.cameras) return;
    const Time taken = script.picture_taken.value_or(now - script.picture_age);
    for (Index i = 0; i < field.watched.size(); ++i) {
      if (!field.watched[i]) continue;
      const Detector& detector = course_.detectors[i];
      if (script.silent.contains(detector.name)) continue;
      if (detector.kind == Detector::Kind::kSighting) {
        race->OnSighting(i, script.sight(detector.name), taken, now);
        continue;
      }
      const Lines lines = script.lines(detector.name);
      race->OnLines(i, lines.contours, Name(lines.ycy), Name(lines.dy), lines.middle_offset, taken,
                    now, lines.doubt);
    }
  }

  int motion_wait_ = 0;
  int speech_wait_ = 0;
  int turn_ = 0;
  Duration lane_{};
};

inline Sighting Text(const std::string& text) {
  return {true, 1.0, "", text};
}

}  // namespace musher::race
