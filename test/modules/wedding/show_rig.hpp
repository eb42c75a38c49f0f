#pragma once
// A show without a robot: virtual time, and the show's outputs are recorded.

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "musher/behavior/fsm/replay.hpp"
#include "musher/modules/wedding/show.hpp"

namespace musher::wedding {

class Script : public ShowOutputs {
 public:
  void TakePose(std::string_view pose) override { poses.emplace_back(pose); }
  void LookAt(Gaze gaze) override { gazes.push_back(gaze); }
  void Play(std::string_view sound) override { sounds.emplace_back(sound); }
  void TakePhoto() override { ++photos; }
  void RecordVideo(bool on) override { videos.push_back(on); }
  void SetMotion(std::string_view motion) override { motions.emplace_back(motion); }
  void ShowState(std::string_view state) override { states.emplace_back(state); }
  void Log(const std::string& line) override { log.push_back(line); }

  std::vector<std::string> poses;
  std::vector<Gaze> gazes;
  std::vector<std::string> sounds;
  std::vector<std::string> states;
  std::vector<std::string> log;
  int photos = 0;
  std::vector<bool> videos;
  std::vector<std::string> motions;
};

class ShowRig : public ::testing::Test {
 protected:
  void SetUp() override { Begin({}); }

  void Begin(const ShowConfig& config, Duration step = Milliseconds(20)) {
    step_ = step;
    show_.reset();
    recorder_.reset();
    machine_ = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "wedding"});
    script_ = {};
    show_ = std::make_unique<Show>(config, script_);
    const Result<> built = show_->Build(*machine_);
    ASSERT_TRUE(built) << built.error().message;
    recording_.clear();
    recorder_ = std::make_unique<fsm::Recorder>(
        *machine_, [this](std::string_view line) { recording_ += line; });
    show_->RecordTo(*recorder_);
    show_->Resume(now_);
    ASSERT_TRUE(machine_->Start(now_));
  }

  void Tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      now_ += step_;
      machine_->RunOnce(now_);
      show_->AfterTick();
    }
  }
  // Ticks until the state is `state`; returns how many, -1: more than `most`.
  int TicksTo(std::string_view state, int most) {
    for (int i = 1; i <= most; ++i) {
      Tick();
      if (show_->state() == state) return i;
    }
    return -1;
  }
  // The same with a guest before the robot.
  int TicksToWithFace(std::string_view state, int most, Gaze at = {}) {
    for (int i = 1; i <= most; ++i) {
      Face(at);
      Tick();
      if (show_->state() == state) return i;
    }
    return -1;
  }
  void TickWithFace(int count, Gaze at = {}) {
    for (int i = 0; i < count; ++i) {
      Face(at);
      Tick();
    }
  }
  void Face(Gaze at = {}) { show_->OnTarget({at, 1.5, {}}, now_); }
  void Gesture(std::string_view word) { show_->OnGesture(word, now_); }
  void Command(std::string_view word) { show_->OnCommand(word, now_); }
  void TooClose(bool too_close) { show_->OnTooClose(too_close, now_); }
  void Force(std::string_view state) {
    const Result<> forced = show_->Force(state, now_);
    ASSERT_TRUE(forced) << forced.error().message;
  }
  // To TRACKING, by a face.
  void Track() {
    Face();
    Tick();
    ASSERT_EQ(state(), "TRACKING");
  }
  // Another show of this config replays the recording, and ends as this one. How many changes of
  // its state that has.
  std::uint64_t ExpectReplays(const ShowConfig& config) const {
    const auto recording = fsm::ReadRecording(recording_, "show.record");
    EXPECT_TRUE(recording) << (recording ? "" : recording.error().message);
    if (!recording) return 0;
    Script again;
    fsm::Machine machine({.name = "wedding"});
    Show show(config, again);
    EXPECT_TRUE(show.Build(machine));
    show.Resume({});
    const auto replayed = fsm::Replay(
        recording.value(), machine,
        [&](std::string_view input, std::string_view text) { return show.Apply(input, text); });
    EXPECT_TRUE(replayed) << (replayed ? "" : replayed.error().message);
    if (!replayed) return 0;
    EXPECT_EQ(replayed.value().difference.value_or(""), "");
    EXPECT_EQ(show.state(), state());
    return replayed.value().changes;
  }
  // So many ticks are in `time`.
  int Ticks(Duration time) const { return static_cast<int>(time / step_); }

  std::string_view state() const { return show_->state(); }
  fsm::Mode mode() const { return machine_->mode(); }
  const ShowData& data() const { return show_->data(); }

  Duration step_{};
  Time now_{Milliseconds(1000)};
  Script script_;
  std::unique_ptr<fsm::Machine> machine_;
  std::string recording_;
  std::unique_ptr<fsm::Recorder> recorder_;
  std::unique_ptr<Show> show_;
};

}  // namespace musher::wedding
