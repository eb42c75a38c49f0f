#pragma once
// A whole run of the course without processes: the world, its cameras, the detectors of
// config/vision/course.toml, the line walker, the motion manager's decisions and the race, in
// virtual time. What the robot knows comes from rendered pictures.
//
//   world -> camera -> detector -> race, walker -> motion manager -> world
//
// Threads: one at a time. A run takes some tens of seconds of CPU.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/modules/line_walker/walker_config.hpp"
#include "musher/modules/race/race.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/test/modules/race/drive/hall_painter.hpp"
#include "musher/test/modules/race/drive/hall_scene.hpp"
#include "musher/test/modules/race/drive/simulated_dog.hpp"

namespace musher::race::testing {

// Another hall than that of config/scenes/course.toml.
struct OtherHall {
  Hall hall;
  SCurve s;
  Flooring flooring = Flooring::kShipped;
  HallLight light;
  bool painted = false;  // its pictures are of HallPainter, not of the world's renderer
};

struct DriveSettings {
  std::string course = "race/course.toml";  // in config/
  // With a course, detectors and a walker that `musher-race course` writes for it.
  std::optional<OtherHall> hall;
  std::uint64_t seed = 1;
  bool over_lcm = false;  // the body is on a motion board on LCM, by real datagrams
  std::map<std::string, std::string> chosen;  // of the scene: qr_a, qr_b, arrow
  bool yellow_light = false;  // appears before the robot in the START lane, for some seconds
  // The same over another place, in the scene's frame.
  std::optional<Eigen::Vector2d> light_at_m;
  std::optional<double> slip;    // of the feet, ahead and aside; else that of the scene
  std::set<std::string> unseen;  // detectors of the race that never see their thing
  Duration limit = std::chrono::minutes(15);
  std::string from;                      // begins in this state; empty: in START
  std::optional<world::Pose2> pose;      // there, and not where the scene has it
  std::string until;                     // ends when this state begins; empty: at END
  Duration latency = Milliseconds(100);  // from a picture to what is found in it
  std::string pictures;                  // a folder for what the checks saw; empty: none
  // Called when a state begins, with the pose at that moment.
  std::function<void(const std::string& state, const world::World& world)> on_state;
  std::function<void(const std::string& line)> on_log;
  // After each step of 20 ms; whether the line walker walks.
  std::function<void(const world::World& world, bool walker)> on_step;
};

// From a picture to what is done by it, in virtual time; and CPU time.
struct Latencies {
  std::vector<Duration> of_walker;  // to the first frame with what the picture showed
  std::vector<Duration> of_race;    // to the end of a check, a wait or a walk until something
  std::vector<Duration> walker_cpu, race_cpu;  // of the same, without the detector
};

struct DriveResult {
  std::string state;   // the last one
  std::string reason;  // of ERROR, as in state_info
  std::vector<std::string> states;
  std::vector<std::string> wrong_words;  // read, and not those of the scene: "qr_a is A-2"
  std::vector<std::string> log;
  Duration took{};
  std::size_t pictures = 0;
  std::size_t datagrams = 0;              // of LCM
  std::vector<std::string> reservations;  // what the race is not sure of, with the states
  Latencies latencies;
  std::optional<world::World> world;  // at the end; its referee has the judgement
};

class CourseDrive : private RaceOutputs {
 public:
  explicit CourseDrive(DriveSettings settings);
  ~CourseDrive() override;

  // From START to END, to ERROR, to `until`, or to the limit.
  DriveResult Run();

  // What each detector of lines finds from a standing robot at a pose, a line for each: to tune the
  // regions and targets of config/vision/course.toml.
  std::vector<std::string> LinesFrom(const world::Pose2& pose);
  // What one of the race's detectors of lines finds there.
  msg::YellowLines LinesFrom(Index detector, const world::Pose2& pose);

  const Course& course() const { return race_.course(); }

 private:
  // A detector of the vision module, and who gets what it finds.
  struct DetectorChannel {
    vision::CourseEntry entry;
    std::unique_ptr<vision::CourseDetector> detector;
    vision::StampGate gate;
    std::size_t camera = 0;
    std::optional<Index> of_race;
    std::optional<line_walker::View> of_walker;
    bool wanted_by_race = false;
    std::optional<Time> shown_to_race;  // the newest picture
  };
  struct Due {
    Time at;
    std::function<void()> work;
  };

  void Step();
  void LookAround();
  cv::Mat PictureOf(std::size_t camera, const world::View& view) const;
  cv::Mat PictureFrom(std::size_t camera, const world::Pose2& pose) const;
  void Look(DetectorChannel& channel, const cv::Mat& picture);
  void ShowWalker(line_walker::View view, const msg::YellowLines& lines, Time taken);
  void Deliver();
  void TickWalker();
  void TickRace(Time now);
  void Later(Duration by, std::function<void()> work) {
    due_.push_back({dog_.now() + by, std::move(work)});
  }
  bool Wanted(const DetectorChannel& channel) const;
  void Log(const std::string& who, const std::string& line);
  std::string Where() const;

  void Walk(const ServoFrame& frame) override;
  void Move(std::int32_t motion_id, std::uint64_t number) override;
  void CommandWalker(const LaneWalk& walk, bool start) override;
  void Watch(const std::vector<bool>& detectors) override;
  void Speak(const std::string& text, std::uint64_t number) override;
  void ShowState(int number) override;
  void Log(const std::string& line) override { Log("race", line); }

  const DriveSettings settings_;
  SimulatedDog dog_;
  std::unique_ptr<world::Scenery> scenery_;
  std::optional<HallPainter> painter_;
  std::array<std::optional<world::Camera>, world::kCameras> cameras_;
  std::vector<DetectorChannel> channels_;
  line_walker::WalkerConfig walker_config_;
  line_walker::LineWalker walker_;
  fsm::Machine machine_;
  Race race_;
  std::vector<Due> due_;
  std::size_t logged_by_dog_ = 0;
  std::size_t feet_ = 0;  // wholly on a line so far
  std::size_t shots_ = 0;
  std::optional<Time> shown_to_walker_;  // a picture that no frame has followed yet
  Duration walker_cpu_{};                // of that picture
  DriveResult result_;
};

}  // namespace musher::race::testing
