#pragma once
// The world of a scene: walls as squares, movers and robots as discs. It moves them, says what a
// scanner sees, and counts contacts, by geometry alone: it knows no map, no gate and no grid of the
// product.
//
// A body that would enter a wall or another disc stays where it is, which is a contact; as long as
// it pushes, it is the same one. Of a mover that runs into a robot that stands the contact is the
// mover's. A flyer that sinks onto a mover below it is counted apart: no planar scan sees it. Its
// sensor that looks down does: movers and robots are columns, movers from the ground to their
// heads. Metres, radians, seconds; one thread; deterministic.

#include <random>
#include <vector>

#include "musher/test/modules/skills/scenes/scene.hpp"

namespace musher::skills::testing {

inline constexpr double kSceneBodyM = 0.2;        // the radius of a robot
inline constexpr double kSceneBodyHeightM = 0.1;  // of a flyer, above and below its middle
inline constexpr double kSceneDownM = 4;          // the longest range of its sensor that looks down
inline constexpr double kSceneConeRad = 1;

class SceneWorld {
 public:
  explicit SceneWorld(const Scene& scene, std::uint64_t seed);

  // Velocities in the frame of the body; executed with a lag of 0.1 s and at most 2.5 m/s².
  void Command(std::size_t robot, const navigation::Velocity& velocity);
  void Step(double seconds);

  const navigation::Pose& pose(std::size_t robot) const { return bodies_[robot].pose; }
  // In the frame of the body.
  navigation::Velocity velocity(std::size_t robot) const { return bodies_[robot].velocity; }
  // 360 ranges from the direction of the body on, with an error of at most 5 mm; `most_m`: nothing.
  std::vector<float> Look(std::size_t robot, double most_m);

  // The nearest thing in the cone below the underside of a flyer, with an error of at most 1 cm;
  // infinite: nothing within kSceneDownM.
  double LookDown(std::size_t robot);

  int contacts(std::size_t robot) const { return bodies_[robot].contacts; }
  int from_above(std::size_t robot) const { return bodies_[robot].from_above; }
  int hits_of_movers() const { return hits_of_movers_; }
  double travelled_m(std::size_t robot) const { return bodies_[robot].travelled_m; }
  double least_room_m(std::size_t robot) const { return bodies_[robot].least_room_m; }
  double now_s() const { return now_s_; }
  // Whether an event of this kind holds now.
  bool Holds(SceneEvent::Kind kind) const;
  // What a wrong localisation adds to the poses.
  navigation::Point JumpNow() const;

 private:
  struct Body {
    navigation::Pose pose;
    navigation::Velocity command{};
    navigation::Velocity wanted{};    // behind the lag
    navigation::Velocity velocity{};  // all of them in the frame of the body
    double travelled_m = 0;
    double least_room_m = 10;
    int contacts = 0;
    int from_above = 0;
    bool touches = false;
  };
  struct Mover {
    navigation::Point at;
    std::size_t to = 1;  // index in its path
    int direction = 1;
    double rests_until_s = 0;
    bool touches = false;
    double waited_s = 0;  // for a robot in its way
  };

  struct Ray {
    navigation::Point from;
    double off_rad = 0, turn_rad = 0;  // from straight down; around that
  };
  struct Column {
    navigation::Point at;
    double bottom_m = 0, top_m = 0, radius_m = 0;
  };
  static double ToColumn(const Ray& ray, const Column& column, double most_m);
  static bool IsOver(const SceneEvent& event, double now_s);
  double ToWalls(const navigation::Point& centre, double within_m) const;
  bool Reaches(const SceneMover& mover, double height_m) const;
  bool SinksOntoMover(const navigation::Point& from, const navigation::Point& to) const;
  // From the rim of a robot at a place to what is nearest.
  double RoomOf(std::size_t robot, const navigation::Point& at) const;
  double DownAlong(std::size_t robot, const navigation::Point& from, double off_rad,
                   double turn_rad) const;
  double ToWallAlong(const navigation::Point& from, double angle_rad, double most_m) const;
  void MoveBody(std::size_t robot, double seconds);
  void MoveMover(std::size_t index, double seconds);
  void Turn(std::size_t index);
  void TurnRound(std::size_t index);

  const Scene& scene_;
  std::mt19937_64 random_;
  std::vector<Body> bodies_;
  std::vector<Mover> movers_;
  int hits_of_movers_ = 0;
  double now_s_ = 0;
};

}  // namespace musher::skills::testing
