#pragma once
// The guests of a scene: people who come, look, make gestures and leave by timetables of their
// own.
//
//   absent - first act -> here - leave -> absent, and again from the start if the scene repeats
//
// A plain value: time and the robot's position come in as arguments. Guests walk straight and
// never enter the robot's circle: they walk around its edge.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// The state of one guest.
struct Guest {
  bool here = false;
  Eigen::Vector2d position_m{0, 0};
  double yaw_rad = 0;         // of its body
  double head_yaw_rad = 0;    // in the place
  double head_pitch_rad = 0;  // downwards
  bool looks_at_robot = false;
  Gesture gesture = Gesture::kNone;

  friend bool operator==(const Guest&, const Guest&) = default;
};

// The robot as an obstacle for guests and as a target of their looks.
struct Robot {
  Eigen::Vector2d position_m{0, 0};
  double radius_m = 0;
  Eigen::Vector3d eyes_m{0, 0, 0};
};

class Guests {
 public:
  // At the beginning; each Step() must get the scene with the same guests.
  explicit Guests(const Scene& scene);

  void Step(const Scene& scene, const Robot& robot, Duration now, Duration dt);

  const std::vector<Guest>& all() const { return guests_; }  // as the scene lists them

 private:
  // What a guest will do next.
  struct Plan {
    std::size_t next_act = 0;
    std::optional<Eigen::Vector2d> walk_to_m;
    double speed_m_s = 0;
    GuestLook look;
    bool leaves = false;
  };

  void Begin(const Scene& scene);
  static void Act(const GuestSpec& spec, const GuestAct& act, Guest& guest, Plan& plan);
  static void Move(const GuestSpec& spec, const Robot& robot, double seconds, Guest& guest,
                   Plan& plan);

  std::vector<Guest> guests_;
  std::vector<Plan> plans_;
  Duration within_{};  // of the timetables
};

// From the top of its hair to the chin.
double HeadHeightM(const GuestSpec& guest);
// The middle of its head, between the eyes.
Eigen::Vector3d HeadOf(const GuestSpec& spec, const Guest& guest);

}  // namespace musher::world
