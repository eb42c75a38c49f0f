#pragma once
// Walks in a lane between two yellow lines, from START to the lane's end line. Pure: messages and
// the time go in, velocities and the status come out. README.md has the rules.
//
//   IDLE --Start()--> ADJUSTING <--> WALKING --an End--> IDLE
//
//   ADJUSTING  no line is seen yet (it stands) or any more (it walks slowly by odometry), or the
//              body is beside the middle or turned by more than a tolerance: it walks and corrects
//   WALKING    in the middle
//
// After an End the walker does nothing until Start(). Times: `now` is the machine's, for waits; the
// stamps of pictures and odometry relate the two to each other. A picture or a line is as old as
// what it was taken of, not as its message. Frame of ground.hpp.
//
// Threads: one.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/line_walker/end_line.hpp"
#include "musher/modules/line_walker/ground.hpp"
#include "musher/modules/line_walker/lane.hpp"
#include "musher/modules/line_walker/line_fit.hpp"
#include "musher/modules/line_walker/odometry_track.hpp"
#include "musher/modules/line_walker/steering.hpp"

namespace musher::line_walker {

enum class View : std::uint8_t { kLeft, kRight, kFront };

struct CameraSet {
  double trunk_height_m = 0.29;
  double farthest_m = 2;  // from the body's middle: points beyond are not used
  MountedCamera left;
  MountedCamera right;
  MountedCamera front;

  CameraSet();  // CyberDog's, as config/scenes/yard.toml mounts them

  friend bool operator==(const CameraSet&, const CameraSet&) = default;
};

struct WalkRules {
  CameraSet cameras;
  FitRules fit;
  EndRules end;
  LaneRules lane;
  SteeringRules steering;
  Duration lead = Milliseconds(200);           // the body follows a velocity so late
  Duration picture_delay = Milliseconds(150);  // of a picture without a comparable stamp
  Duration start_wait = Milliseconds(5000);    // for lines and odometry, standing
  double approach_m = 0;  // walks so far straight ahead at the start, to the beginning of the lines
  Duration stale = Milliseconds(1000);        // without pictures of both sides, or odometry
  Duration fresh = Milliseconds(500);         // a line is seen for so long after its picture
  Duration lost = Milliseconds(2000);         // without both lines, after `fresh`
  double lost_m_s = 0.15;                     // at most, meanwhile
  Duration time_limit = Milliseconds(60000);  // of a walk
  double end_gap_m = -0.5;   // from the body's middle to the lane's end; less than 0: beyond it
  int end_pictures = 2;      // of the front camera that show the end line, before it counts
  int side_pictures = 6;     // of the side cameras that show the end of a line, before it counts
  double end_jump_m = 0.15;  // at most between them
  Duration refused = Milliseconds(500);  // motion refuses for so long
  double adjust_m = 0.08;                // ADJUSTING beside the middle by more
  double adjust_rad = kDegree * 12;      // or turned by more

  friend bool operator==(const WalkRules&, const WalkRules&) = default;
};

// Why a walk has ended.
enum class End : std::uint8_t {
  kCourseEnd,
  kTimeLimit,
  kLost,     // both lines
  kStopped,  // by STOP, by a state other than Active, or by an emergency stop
  kSilent,   // no pictures of lines, or no odometry
  kRefused,  // by the motion manager
};
std::string_view NameOf(End end);

class LineWalker {
 public:
  // One frame to the motion manager. `end`: the last one of a walk, with no velocity.
  struct Step {
    Velocity velocity;
    bool end = false;
  };
  enum class State : std::uint8_t { kIdle, kWalking, kAdjusting };

  explicit LineWalker(const WalkRules& rules) : rules_(rules), lane_(rules.lane) {}

  // False, without an effect, while it walks. Where the last walk has ended after it has seen the
  // lane's end, and the body is still there, it walks on to this end: no line may be seen any more;
  // at the end itself it ends at once. It is still there for WalkRules::time_limit at most: a body
  // that is carried does not always show that.
  bool Start(Time now);
  // Without an effect while it does not walk. The next Tick() gives the last frame.
  void Stop(Time now, const std::string& why = "STOP");
  // Between two walks: the body may have been carried, without odometry. Start() continues no walk
  // then, and approaches no more than before.
  void ForgetLane() { Forget(); }

  // Ignored while it does not walk.
  void OnLines(View view, const msg::YellowLines& lines, Time now);
  void OnResponse(const msg::MotionServoResponse& response, Time now);
  // Always, so that a walk can begin at once. `age`: of its stamp, by the clock that stamps; a
  // sample with the stamp of the one before is none.
  void OnOdometry(const msg::Odometry& odometry, Time now, Duration age = {});

  // To be called at the rate of frames, and after Stop(). Gives frames once a line has been seen;
  // after the end exactly one with `end`, unless no frame preceded it.
  std::optional<Step> Tick(Time now);

  State state() const { return state_; }
  bool active() const { return state_ != State::kIdle; }
  const std::optional<End>& end() const {
    return end_;
  }  // of the last walk; nothing while it walks
  // Why, for people: "no picture of a line for 1000 ms".
  const std::string& reason() const { return reason_; }
  // As of the newest odometry; nothing before a line is seen.
  std::optional<InLane> in_lane() const;
  // Metres from the body's middle to the lane's end; nothing before it is known.
  std::optional<double> to_end_m() const;
  bool ImagesReady(Time now) const;
  Duration Runtime(Time now) const;
  // "State:WALKING,Active:True,ImagesReady:True,Runtime:3.2s", and ",End:course_end" after an end.
  std::string StatusText(Time now) const;

 private:
  struct Sight {
    std::optional<Time> picture_at;  // when the newest picture was taken
    std::optional<Time> line_at;     // that with the newest line that was believed
  };

  // What pictures in a row show of the lane's end.
  struct EndSight {
    Pose line;         // in the odometry's frame; yaw: of the lane that ends there
    double share = 0;  // of the pictures that are needed
  };

  // When and where a picture was taken.
  struct Taken {
    Time at;
    std::optional<Pose> pose;  // nothing: without odometry of that time
  };
  // The picture of the message before, once more: no camera or detector works.
  bool Repeats(View view, const msg::YellowLines& lines);
  Taken TakenOf(const msg::YellowLines& lines, Time now) const;
  // Its words are of now: without a doubt, and not late.
  bool Counts(const msg::YellowLines& lines, const Taken& taken, Time now) const;
  void OnSide(Side side, const msg::YellowLines& lines, Time now);
  void OnFront(const msg::YellowLines& lines, Time now);
  // `found`: the end in a picture taken at `pose`. It counts after so many `pictures`.
  void SeeEnd(const Pose& pose, const EndLine& found, int pictures, EndSight& sight);
  bool end_known() const { return end_line_.has_value(); }
  bool Seen(const Sight& sight, Time now) const;
  bool Within(const std::optional<Time>& at, Duration time, Time now) const;
  std::optional<Step> EndFrame();
  // The body is still where the last walk has ended.
  bool StandsThere(Time now) const;
  // Start() continues the last walk.
  bool Continues(Time now) const;
  // Ends the walk where a rule says so.
  void CheckEnds(Time now);
  void Finish(End end, std::string reason, Time now);
  // The frame of the odometry is another one.
  void OnJump(Time now);
  // The lane and its end.
  void Forget();
  std::string WhyNoOdometry() const;
  std::string WhyNoPictures() const;
  Velocity Command(Time now);
  // No line was seen yet, and it may walk on to look for one,
  bool MayApproach() const;
  // which it does while pictures without a doubt show that there is none.
  bool Approaching(Time now) const;
  InLane AlongStart(const Pose& pose) const;

  WalkRules rules_;
  OdometryTrack track_;
  std::optional<Time> odometry_at_;  // of the newest sample
  Duration odometry_age_{};          // of that at its reception
  bool odometry_repeats_ = false;    // the last message had its stamp
  LaneEstimate lane_;
  Sight left_;
  Sight right_;
  std::array<msg::Stamp, 3> stamps_{};  // of the newest pictures, by view; also of earlier walks
  EndSight front_end_;
  EndSight side_end_;
  std::optional<Pose> end_line_;  // once it counts
  bool beyond_ = false;           // the end is passed
  std::optional<Time> refused_since_;
  std::int32_t refused_code_ = 0;
  State state_ = State::kIdle;
  Time started_at_;
  std::optional<Time> pictures_from_;  // of the sides, without a doubt, in this walk: in a row
  std::optional<Time> clear_at_;       // and the last of them
  Duration picture_age_{};             // of the last picture of a side, at its reception
  bool approaches_ = true;             // it was not in the lane where it stands
  std::optional<Pose> start_;          // in which it began to approach, also in a walk before
  std::optional<Pose> stopped_;        // and in which the last walk ended
  std::optional<Time> ended_at_;
  std::optional<End> end_;
  std::string reason_;
  bool framed_ = false;    // a frame was given in this walk
  bool owes_end_ = false;  // the last frame is still to be given
};

}  // namespace musher::line_walker
