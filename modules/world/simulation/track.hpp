#pragma once
// The history for the picture: the body's position and state, a few times a second. It is bounded:
// when it is full, every second sample is dropped.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

struct Sample {
  Duration at{};
  Pose2 pose;
  double battery_percent = 0;
  bool charging = false;
  std::uint16_t machine_state = 0;  // index into Track::states()
  std::uint16_t motion = 0;         // index into Track::motions()
};

struct Bump {
  Duration at{};
  Eigen::Vector2d where_m;
};

// What happened, in words.
struct Mark {
  Duration at{};
  std::string text;
};

struct Light {
  std::uint8_t red = 0, green = 0, blue = 0;
};

class Track {
 public:
  static constexpr std::size_t kMost = 20'000;  // samples; an hour at 5 Hz is 18,000

  // Keeps the first and the last sample.
  void Add(Sample sample, const std::string& machine_state, const std::string& motion);
  void AddBump(const Bump& bump);
  void AddMark(Mark mark);
  void SetLight(int target, const Light& light) { lights_[target] = light; }

  // The least time between two samples.
  Duration period() const { return period_; }
  bool IsDue(Duration now) const { return samples_.empty() || now - samples_.back().at >= period_; }

  const std::vector<Sample>& samples() const { return samples_; }
  const std::vector<Bump>& bumps() const { return bumps_; }
  const std::vector<Mark>& marks() const { return marks_; }
  const std::vector<std::string>& states() const { return states_; }  // "" where unknown
  const std::vector<std::string>& motions() const { return motions_; }
  const std::map<int, Light>& lights() const { return lights_; }

 private:
  Duration period_ = Milliseconds(200);
  std::vector<Sample> samples_;
  std::vector<Bump> bumps_;
  std::vector<Mark> marks_;
  std::vector<std::string> states_;
  std::vector<std::string> motions_;
  std::map<int, Light> lights_;  // by target: 1 head, 2 tail, 3 mini
};

}  // namespace musher::world
