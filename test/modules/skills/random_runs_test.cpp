// Random runs of each skill that moves a robot on the ground, and of a person who does so by
// teleop: on random maps, with faults of what it senses and things that appear, cancelled or not;
// planner, controller, skills, gate and body on a simulated network. The body touches nothing that
// its scan sees, each run ends within its time, and then the robot stands. Flights have
// body_property_test.cpp.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/test/modules/navigation/servers_on_network.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/scanned_body.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::random_runs_test {

using navigation::testing::ServersOnNetwork;
using navigation::testing::SimulatedRobot;

constexpr double kRadiusM = 0.2;
constexpr double kTimeoutS = 25;
constexpr const char* kTeleop = "teleop";  // no skill: commands of a person

struct Outcome {
  bool ended = false;
  bool stands = false;
  double least_room_m = 0;
  double travelled_m = 0;  // turns too, at its edge
  std::string text;
};

class RandomRun {
 public:
  RandomRun(const std::string& skill, std::uint64_t seed)
      : skill_(skill),
        seed_(seed),
        random_(seed),
        walls_(navigation::testing::Fenced(
            navigation::testing::RandomBoxes(seed, 9, 0.05, 0.02 + 0.08 * Share()))),
        robot_(Config()),
        endpoints_(*node_, "") {
    SimulatedRobot::Options options;
    options.name = "r";
    options.start = {navigation::testing::FreePlace(walls_, 0.3, random_), Between(-3, 3)};
    options.lag_s = OneIn(2) ? 0 : Between(0, 0.1);
    body_ = std::make_unique<SimulatedRobot>(*peers_, walls_, options);
    last_ = body_->pose();
    StartServers();
    grid_ =
        Must(transport::MakePublisher<msg::OccupancyGrid>(*peers_, "map", transport::kLatchedQos));
    line_ = Must(
        transport::MakePublisher<msg::YellowLines>(*peers_, "line", transport::kSensorDataQos));
    target_ = Must(transport::MakePublisher<msg::Odometry>(*peers_, "target/odom"));
    detections_ = Must(transport::MakePublisher<msg::ObjectStates>(*peers_, "r/detections",
                                                                   transport::kSensorDataQos));
    OpenBodyParts();
    PublishMap();
    watch_ = peers_->loop().Every(Milliseconds(10), [this] { Watch(); });
    inputs_ = peers_->loop().Every(Milliseconds(100), [this] { PublishInputs(); });
    robot_.Open(endpoints_, "");
    skill::Registry registry;
    EXPECT_TRUE(RegisterNavigationSkills(registry, robot_));
    EXPECT_TRUE(RegisterBodySkills(registry, robot_));
    manager_ = std::make_unique<skill::Manager>(registry.All());
    steps_ = node_->loop().Every(Milliseconds(100), [this] {
      robot_.BeginStep(node_->loop().Now());
      manager_->RunOnce(node_->loop().Now());
    });
    network_.RunFor(FromSeconds(1.5));
  }

  Outcome Run() {
    Outcome outcome;
    const bool teleoperates = skill_ == kTeleop;
    if (!teleoperates) {
      const auto started = manager_->StartWithTexts(skill_, Parameters());
      EXPECT_TRUE(started) << skill_ << ": " << started.error().message;
      if (!started) return outcome;
    }
    person_ = teleoperates;
    const double cancel_s = OneIn(4) ? Between(0, 20) : 1e9;
    const double bound_s = teleoperates ? kTimeoutS : kTimeoutS + 8;  // a cancellation has 5 s
    for (double at_s = 0; at_s < bound_s && (teleoperates || !run().ended()); at_s += 0.5) {
      if (OneIn(16)) HasFaults() ? InjectFault() : AddDisc();
      if (at_s >= cancel_s) static_cast<void>(manager_->Cancel(skill_, "by the test"));
      network_.RunFor(FromSeconds(0.5));
    }
    person_ = false;
    body_->stuck = false;
    network_.RunFor(FromSeconds(2));
    const int commands = body_->commands();
    if (teleoperates) network_.RunFor(FromSeconds(1));
    outcome.ended = teleoperates ? body_->commands() == commands : run().ended();
    outcome.text = teleoperates ? robot_.HeldBy() : skill::ToText(run().feedback());
    outcome.stands = body_->speed_m_s() < 0.01;
    outcome.least_room_m = std::min(body_->least_room_m(), least_disc_m_);
    outcome.travelled_m = travelled_m_;
    return outcome;
  }

 private:
  template <class T>
  static T Must(Result<T> result) {
    if (!result) ADD_FAILURE() << result.error().message;
    return std::move(result).value();
  }
  static skills::SkillsConfig Config() {
    const auto reading = skills::ReadSkillsText(
        "robot = \"r\"\nkind = \"jetbot\"\nradius_m = 0.2\nhand = true\n"
        "[topics]\nobjects = \"objects\"\nline = \"line\"\nteleop = \"r/teleop\"\n"
        "[cameras]\nfront = \"r/camera\"\n[gate]\nreaction_ms = 300\n",
        "/tmp/r.toml");
    return *reading.config;
  }
  void StartServers() {
    navigation::PlannerConfig planner;
    planner.robots = {navigation::testing::PlannerTable("r")};
    navigation::ControllerConfig controller;
    controller.robots = {navigation::testing::ControllerTable("r")};
    controller.robots[0].gate.reaction_s = 0.3;
    servers_.Start(planner, controller);
  }

  // A box beside the start, which no scan sees, and a hand; in `place` it holds the box.
  void OpenBodyParts() {
    teleop_ = Must(transport::MakePublisher<msg::Twist>(*peers_, "r/teleop"));
    objects_ = Must(transport::MakePublisher<msg::ObjectStates>(*peers_, "objects"));
    camera_ =
        Must(transport::MakePublisher<msg::Image>(*peers_, "r/camera", transport::kSensorDataQos));
    std::uniform_real_distribution<double> away_m(0.5, 1.9), angle_rad(-M_PI, M_PI);
    const double m = away_m(others_), rad = angle_rad(others_);
    const navigation::Point& start = body_->pose().at;
    box_ = {start.x_m + m * std::cos(rad), start.y_m + m * std::sin(rad), 0};
    if (skill_ == "place") box_held_by_ = "r";
    hand_ = Must(transport::MakeServer<msg::ManipulationControl>(
        *peers_, "r/manipulation_control",
        [this](const auto& request, const auto& reply) { reply(UseHand(request)); }));
  }
  msg::ManipulationControl::Response UseHand(const msg::ManipulationControl::Request& request) {
    using Action = msg::ManipulationControl;
    msg::ManipulationControl::Response response;
    response.distance_m = navigation::Distance(box_, body_->pose().at);
    response.success = request.action == Action::kPlace || request.action == Action::kRelease ||
                       response.distance_m <= request.distance_threshold_m;
    if (!response.success) response.message = "Too far";
    if (!response.success || request.action == Action::kCheckDistance) return response;
    box_held_by_ = request.action == Action::kAttach ? "r" : "";
    return response;
  }

  double Share() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double Between(double least, double most) { return least + (most - least) * Share(); }
  bool OneIn(int count) { return random_() % static_cast<std::uint64_t>(count) == 0; }
  // Half of them, so that the others come far.
  bool HasFaults() const { return seed_ % 2 == 0; }
  const skill::Run& run() const { return *manager_->Find(skill_); }

  // The true one, or one without the boxes.
  void PublishMap() {
    const navigation::CellMap empty =
        navigation::testing::Fenced(navigation::testing::RandomBoxes(1, 9, 0.05, 0));
    EXPECT_TRUE(grid_->Publish(navigation::testing::GridOf(OneIn(3) ? empty : walls_.map())));
  }

  std::string AnyPlace() {
    const auto place = navigation::testing::FreePlace(walls_, 0.35, random_);
    return "[" + std::to_string(place.x_m) + ", " + std::to_string(place.y_m) + ", 0]";
  }
  std::vector<std::pair<std::string, std::string>> Parameters() {
    std::vector<std::pair<std::string, std::string>> texts{{"timeout", std::to_string(kTimeoutS)}};
    if (skill_ == "navigate_to") texts.emplace_back("goal_pos", AnyPlace());
    if (skill_ == "move") {
      texts.emplace_back("path", "[" + AnyPlace() + ", " + AnyPlace() + "]");
    }
    if (skill_ == "explore") {
      texts.emplace_back("boundary", "[[0.5, 0.5], [8.5, 0.5], [8.5, 8.5], [0.5, 8.5]]");
    }
    if (skill_ == "avoid_obstacle") {
      texts.emplace_back("heading", std::to_string(Between(-3, 3)));
      texts.emplace_back("speed", "1");
    }
    if (skill_ == "follow_line") texts.emplace_back("speed", std::to_string(Between(0.3, 1)));
    if (skill_ == "visual_servoing") {
      texts.emplace_back("target", "dock");
      texts.emplace_back("distance", std::to_string(Between(0.3, 1.5)));
      texts.emplace_back("speed", "0.5");
    }
    if (skill_ == "grasp" || skill_ == "place") {
      texts.emplace_back("distance_threshold", "0.3");
      texts.emplace_back("approach", "2");
      texts.emplace_back("object_prim_path", "box");
    }
    if (skill_ == "place") {
      texts.emplace_back("target_location",
                         "[" + std::to_string(box_.x_m) + ", " + std::to_string(box_.y_m) + ", 0]");
    }
    if (skill_ == "take_photo") texts.emplace_back("target", "box");
    if (skill_ == "track") {
      texts.emplace_back("target_topic", "/target/odom");
      texts.emplace_back("track_period", "2");
    }
    return texts;
  }

  void InjectFault() {
    switch (random_() % 7) {
      case 0:
        body_->odometry_off = {Between(-1, 1), Between(-1, 1), 0};
        break;
      case 1:
        body_->odometry_frozen = !body_->odometry_frozen;
        break;
      case 2:
        body_->odometry_silent = !body_->odometry_silent;
        break;
      case 3:
        // What appears while it sees nothing is not what its scan sees.
        if (body_->discs.empty()) body_->scan_silent = !body_->scan_silent;
        break;
      case 4:
        body_->stuck = !body_->stuck;
        break;
      case 5:
        if (!body_->scan_silent) AddDisc();
        break;
      default:
        PublishMap();
        body_->odometry_off = {};
        body_->odometry_frozen = body_->odometry_silent = false;
    }
  }
  // A person stands there all of a sudden, farther away than the body brakes from its highest
  // speed.
  void AddDisc() {
    const double angle_rad = Between(-M_PI, M_PI), away_m = Between(2, 4);
    const navigation::Point& at = body_->pose().at;
    body_->discs.push_back(
        {{at.x_m + away_m * std::cos(angle_rad), at.y_m + away_m * std::sin(angle_rad), 0},
         kRadiusM});
  }
  void Watch() {
    for (const auto& disc : body_->discs) {
      const double room_m =
          navigation::Distance(disc.at, body_->pose().at) - disc.radius_m - kRadiusM;
      least_disc_m_ = std::min(least_disc_m_, room_m);
    }
    travelled_m_ += navigation::Distance(last_.at, body_->pose().at) +
                    kRadiusM * std::abs(navigation::Wrapped(body_->pose().yaw_rad - last_.yaw_rad));
    last_ = body_->pose();
  }
  // A line that bends, and a target that goes round.
  void PublishInputs() {
    const Duration now = peers_->loop().Now().time_since_epoch();
    const double now_s = ToSeconds(now);
    msg::YellowLines lines;
    lines.header.stamp = msg::ToStamp(now);
    lines.contours = 1;
    lines.middle_offset = static_cast<float>(0.2 * std::sin(now_s / 3));
    static_cast<void>(line_->Publish(lines));
    msg::Odometry target;
    target.header.stamp = msg::ToStamp(now);
    target.header.frame_id = "map";
    target.pose.pose.position.x = 4.5 + 3 * std::cos(now_s / 10);
    target.pose.pose.position.y = 4.5 + 3 * std::sin(now_s / 10);
    target.pose.pose.orientation.w = 1;
    static_cast<void>(target_->Publish(target));
    PublishDetections(target.pose.pose.position);
    msg::ObjectStates objects;
    objects.header = target.header;
    objects.objects.push_back({"box", "box", {}, box_held_by_});
    objects.objects[0].pose.position = {box_.x_m, box_.y_m, 0};
    objects.objects[0].pose.orientation.w = 1;
    static_cast<void>(objects_->Publish(objects));
    msg::Image picture;
    picture.width = picture.height = 1;
    picture.encoding = "mono8";
    picture.step = 1;
    picture.data = {7};
    static_cast<void>(camera_->Publish(picture));
    if (person_) Teleoperate();
  }
  // Any velocity for a while, and then another one; the stick is at rest in a quarter of the time.
  void Teleoperate() {
    if (others_() % 10 == 0) {
      std::uniform_real_distribution<double> ahead_m_s(-1.5, 1.5), turn_rad_s(-1, 1);
      const double ahead = ahead_m_s(others_), turn = turn_rad_s(others_);
      stick_ = {};
      if (others_() % 4 != 0) {
        stick_.linear.x = ahead;
        stick_.angular.z = turn;
      }
    }
    static_cast<void>(teleop_->Publish(stick_));
  }
  // The target as a detector of the body sees it, which looks all around and through walls. Half of
  // them have pictures that are empty or lost, or show a second thing, or one that jumps.
  void PublishDetections(const msg::Point& target) {
    const navigation::Pose& body = body_->pose();
    const double x = target.x - body.at.x_m, y = target.y - body.at.y_m;
    const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
    msg::ObjectStates found;
    found.header = {msg::ToStamp(peers_->loop().Now().time_since_epoch()), "r"};
    found.objects.push_back({"dock", "station", {}, ""});
    found.objects[0].pose.position = {c * x + s * y, c * y - s * x, 0};
    found.objects[0].pose.orientation.w = 1;
    const std::uint64_t fault = HasFaults() ? detector_faults_() % 40 : 40;
    if (fault < 4) return;
    if (fault < 8) found.objects.clear();
    if (fault == 8) found.objects.push_back(found.objects[0]);
    if (fault == 9) found.objects[0].pose.position.y += 3;
    static_cast<void>(detections_->Publish(found));
  }

  const std::string skill_;
  const std::uint64_t seed_;
  std::mt19937_64 random_;
  transport::sim::Network network_{1};
  ServersOnNetwork servers_{network_};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peers_ = network_.MakeNode("robot");
  const navigation::Clearance walls_;
  std::unique_ptr<SimulatedRobot> body_;
  navigation::Pose last_;
  double least_disc_m_ = 10;
  double travelled_m_ = 0;
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> grid_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> line_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> target_;
  std::unique_ptr<transport::Publisher<msg::ObjectStates>> detections_;
  std::mt19937_64 detector_faults_{seed_};
  std::mt19937_64 others_{seed_ + 1};  // of the box and the person
  navigation::Point box_;
  std::string box_held_by_;
  bool person_ = false;  // moves it
  msg::Twist stick_;
  std::unique_ptr<transport::Publisher<msg::Twist>> teleop_;
  std::unique_ptr<transport::Publisher<msg::ObjectStates>> objects_;
  std::unique_ptr<transport::Publisher<msg::Image>> camera_;
  std::unique_ptr<transport::Server<msg::ManipulationControl>> hand_;
  skills::RosRobot robot_;
  transport::Endpoints endpoints_;
  std::unique_ptr<skill::Manager> manager_;
  transport::LoopHandlePtr watch_, inputs_, steps_;
};

void ExpectNoContact(std::uint64_t from, std::uint64_t to) {
  for (const char* skill : {"navigate_to", "move", "explore", "avoid_obstacle", "follow_line",
                            "track", "visual_servoing", "back_up", "spin", "leave_tight_start",
                            "grasp", "place", "take_photo", kTeleop}) {
    double travelled_m = 0;
    std::string ends;
    for (std::uint64_t seed = from; seed < to; ++seed) {
      const Outcome outcome = RandomRun(skill, seed).Run();
      const std::string what = std::string(skill) + ", seed " + std::to_string(seed) + ": ";
      EXPECT_TRUE(outcome.ended) << what << outcome.text;
      EXPECT_TRUE(outcome.stands) << what << outcome.text;
      EXPECT_GT(outcome.least_room_m, 0) << what << outcome.text;
      travelled_m += outcome.travelled_m;
      ends += outcome.text + "\n";
    }
    EXPECT_GT(travelled_m, 0) << skill << " moves the robot in some of them: " << ends;
  }
}

TEST(RandomRuns, OfEachSkillTouchNothingThatTheScanSeesAndEnd) {
  ExpectNoContact(2, 4);
}

TEST(RandomRunsNightly, OfEachSkillTouchNothingThatTheScanSeesAndEnd) {
  ExpectNoContact(100, 150);
}

}  // namespace musher::random_runs_test
