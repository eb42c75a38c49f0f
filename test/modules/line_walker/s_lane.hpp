#pragma once
// A closed loop in virtual time: a lane like an S with an end line, a body with lag, slip and
// noise, and cameras by the world's camera model with noise and delay, driven by a LineWalker.

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "musher/modules/line_walker/line_walker.hpp"
#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::line_walker {

// The same camera for the world's model.
world::CameraSpec SpecOf(const MountedCamera& camera);

// A camera on a body at `body`, by the world's model.
class WorldCamera {
 public:
  WorldCamera(const MountedCamera& camera, const Pose& body, double height_m, double roll_rad = 0,
              double pitch_rad = 0);
  // The share of the picture at which it shows that point on the ground.
  std::optional<std::array<double, 2>> ShareOf(const GroundPoint& point) const;

 private:
  world::Intrinsics intrinsics_;
  Eigen::Isometry3d X_CW_;
};

// Straight, an arc to the left, one to the right, straight.
class SLane {
 public:
  struct Shape {
    double before_m = 0.6;
    double arc_rad = M_PI / 4;
    double radius_m = 1.6;
    double after_m = 0.7;
    double lines_from_m = -0.8;  // along the lane; a body starts at 0
  };
  SLane() : SLane(Shape()) {}
  explicit SLane(const Shape& shape);

  double width_m = 0.83;
  double length_m() const { return length_m_; }
  // The lane's middle, that far along it; yaw is its direction.
  Pose At(double along_m) const;
  // How far along it is, and how far to the left of the middle.
  struct Place {
    double along_m = 0;
    double left_m = 0;
  };
  Place PlaceOf(const Pose& body) const;
  GroundPoint LinePoint(double along_m, double left_m) const;
  // Points of both its lines, 8 mm apart, with their place along it.
  struct LinePoints {
    double along_m;
    GroundPoint left;
    GroundPoint right;
  };
  const std::vector<LinePoints>& lines() const { return lines_; }

 private:
  Shape shape_;
  double length_m_;
  std::vector<LinePoints> lines_;
};

// The lane of most tests.
const SLane& TheSLane();

struct SimulationRules {
  Duration lag = Milliseconds(200);
  double slip = 0.03;
  double yaw_slip = 0.1;
  double speed_noise = 0.05;    // of each component, as a share, new each 100 ms
  double attitude_rad = 0.012;  // standard deviation of roll and pitch in a picture
  double pixel_noise = 1;       // standard deviation
  Duration picture_delay = Milliseconds(150);
  // Of the detectors, as modules/vision has them by default.
  double region_top = 0.6;
  int edge_columns = 24;
  double odometry_scale = 1.01;
  double odometry_drift = 0.01;  // rad for each metre
};

class SLaneRun {
 public:
  SLaneRun(unsigned seed, double start_left_m, double start_heading_rad, WalkRules rules = {},
           const SLane& course = TheSLane());

  // What a camera shows now; changed by a test.
  std::function<void(View, msg::YellowLines&)> spoil;
  bool has_end_line = true;
  bool has_cameras = true;        // pictures come
  bool repeats_odometry = false;  // the last message comes again and again
  bool has_lines_beside = false;  // at the end, from 0.54 m beside the middle on, 0.1 m beyond
  SimulationRules simulation;

  void RunFor(Duration time);
  // Until the walker has ended, at most that long.
  void RunToEnd(Duration longest = std::chrono::seconds(40));

  Time now() const { return now_; }
  SLane::Place place() const { return lane.PlaceOf(body_); }
  const Pose& body() const { return body_; }
  const Pose& odometry() const { return odometry_; }
  double rms_m() const { return std::sqrt(squares_ / std::max(1, samples_)); }
  double max_m() const { return max_m_; }
  double max_later_m() const { return max_later_m_; }  // after the first 0.8 m

  SLane lane;
  LineWalker walker;
  std::vector<LineWalker::Step> frames;

 private:
  struct Delivery {
    Time at;
    View view;
    msg::YellowLines lines;
  };

  void Step();
  void MoveBody(double seconds);
  void SendOdometry();
  void TakePictures();
  msg::YellowLines Picture(View view);
  double Noise(double deviation) { return std::normal_distribution(0.0, deviation)(random_); }

  WalkRules rules_;
  std::mt19937 random_;
  Time now_{std::chrono::seconds(1000)};
  int ticks_ = 0;
  Pose body_;
  Velocity velocity_;
  Velocity command_;
  Velocity noise_;
  Pose odometry_;
  msg::Odometry last_odometry_;
  std::deque<Delivery> deliveries_;
  double squares_ = 0;
  int samples_ = 0;
  double max_m_ = 0;
  double max_later_m_ = 0;
};

}  // namespace musher::line_walker
