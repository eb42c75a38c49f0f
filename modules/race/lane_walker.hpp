#pragma once
// A walk of the line walker (modules/line_walker): START, its status until its end, STOP. Pure.
//
// Times are those of the machine, which stands still in a pause. One thread.

#include <optional>
#include <string>
#include <string_view>

#include "musher/modules/race/outputs.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::race {

// A walk that a light has interrupted, and that continues.
struct LaneProgress {
  Duration walked{};                     // how long it has lasted
  std::optional<navigation::Pose> from;  // where it has begun, by odometry
  bool lost = false;                     // the odometry does not say any more how far it has come
};

class LaneWalker {
 public:
  LaneWalker(const Course& course, RaceOutputs& outputs) : course_(course), outputs_(outputs) {}

  enum class End : std::uint8_t { kNone, kGood, kOther, kLost };

  // `progress`: of a walk that continues.
  void Begin(Index walk, const LaneProgress& progress = {});
  // Each tick until an end. kGood: see arrived(); kOther: another end, kStopGrace after it and
  // after all retries, or the limit; kLost: no status. `reason` has the last two as text, and with
  // kNone that it is started once more. A walker that others stop, or that was restarted, is not.
  End Advance(Duration now, std::string& reason);
  // STOP, if START was sent.
  void Stop();
  // It is started again by the next Advance(), and walks on from where it is.
  void Pause();
  // The same for good; returns its progress, for Begin().
  LaneProgress Interrupt();
  // The course's end, of a walker that has begun; also where a Pause() has followed.
  bool arrived() const;

  void OnStatus(Index walk, std::string_view status);
  // Fresh odometry.
  void OnOdometry(const navigation::Pose& pose, Time time);
  // A walk has begun and has not ended: odometry counts.
  bool under_way() const { return walk_.has_value(); }
  // How far it has come from where it began, in a straight line; nothing: the odometry does not
  // say it. `time` is that of the actuator's clock, as of OnOdometry().
  std::optional<double> WayM(Time time) const;

 private:
  struct Place {
    navigation::Pose pose;
    Time at;
  };

  const Course& course_;
  RaceOutputs& outputs_;
  std::optional<Index> walk_;
  bool started_ = false;
  Duration started_at_{};
  Duration walked_{};  // before the last pause
  Duration received_at_{};
  bool received_ = false;             // since the last tick
  bool running_ = false;              // a status without an end was received since START
  bool arrived_ = false;              // before the last pause
  std::string end_;                   // of the last status
  std::optional<Duration> ended_at_;  // with another end than the course's
  int tries_ = 0;                     // retries so far
  std::optional<Duration> retry_at_;
  std::optional<navigation::Pose> from_;  // where the walk has begun
  std::optional<Place> place_;            // the newest
  bool lost_ = false;                     // see LaneProgress
};

}  // namespace musher::race
