#pragma once
// A robot for tests of skills: a body with inertia, ground and wind, a hand, a camera and objects.
// Replies come in the step after the request, or as the test decides. Simulated time only.

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/skill/manager.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills::testing {

// What becomes of a request.
enum class Reply { kGiven, kFails, kAbandoned, kNever };

class FakeRobot : public Robot {
 public:
  FakeRobot(std::string name, std::string kind) : name_(std::move(name)), kind_(std::move(kind)) {}

  // --- what a test sets and reads ---

  navigation::Pose body;
  navigation::Velocity motion{};   // in the map
  navigation::Velocity wind{};     // of a body in the air, in the map
  navigation::Velocity command{};  // of the body; zero when none is sent
  double lag_s = 0.2;              // of its motion to the command
  double ground_m = 0;
  double stopped_above_m = -1;  // a flyer descends no lower: held up by something
  std::optional<double> ceiling;
  bool has_odometry = true;
  bool has_scan = true;
  bool has_objects = true;
  bool has_detector = true;
  bool has_hand = true;
  double reach_m = 100;  // of the hand
  std::string held_by;   // what its gate stops it for; empty: nothing
  std::string below;     // what its gate stops a descent for; empty: nothing
  double below_m_s = 0;  // or slows it down to
  std::function<bool(const navigation::Point&)> is_below;  // where; empty: everywhere
  std::string not_held;  // why a flyer is not held at its place; empty: it is
  bool slips = false;    // the hand takes the object and loses it
  std::vector<SeenObject> seen;
  std::vector<navigation::Point> scan;
  std::vector<std::string> camera_names;
  Picture picture{2, 1, {1, 2, 3, 4, 5, 6}};
  std::map<std::string, Picture> files;

  std::function<Reply(const HandRequest&)> hand_replies = [](const HandRequest&) {
    return Reply::kGiven;
  };
  Reply camera_replies = Reply::kGiven;
  Reply file_replies = Reply::kGiven;
  std::vector<HandRequest> hand_requests;
  int pictures_taken = 0;

  void Advance(Duration step);
  SeenObject& Object(const std::string& name);
  std::string Held() const;

  // --- Robot ---

  const std::string& name() const override { return name_; }
  const std::string& kind() const override { return kind_; }
  bool flies() const override { return kind_ != "jetbot" && kind_ != "g1" && kind_ != "h1"; }
  double radius_m() const override { return 0.2; }
  std::optional<double> ceiling_m() const override { return ceiling; }
  Time Now() const override { return now_; }
  std::optional<navigation::Pose> pose() const override {
    return has_odometry ? std::optional(body) : std::nullopt;
  }
  navigation::Velocity velocity() const override { return motion; }
  void SetVelocity(const navigation::Velocity& velocity) override {
    command = held_by.empty() ? velocity : navigation::Velocity{};
    const bool there = !is_below || is_below(body.at);
    descent_held_ = command.z_m_s < 0 && !below.empty() && there;
    if (descent_held_) command.z_m_s = std::max(command.z_m_s, -below_m_s);
  }
  std::string HeldBy() const override { return held_by; }
  std::string WhyNotDescending() const override { return descent_held_ ? below : ""; }
  std::string WhyNotHeld() const override { return not_held; }
  void StopMotion() override {
    command = {};
    descent_held_ = false;
  }
  bool HasPlanner() const override { return false; }
  bool HasController() const override { return false; }
  bool Drives() const override { return false; }
  skill::Future<navigation::Path> ComputePath(const navigation::Pose&,
                                              const std::optional<navigation::Pose>&) override {
    return {};
  }
  std::unique_ptr<Drive> FollowPath(const navigation::Path&) override { return nullptr; }
  std::vector<navigation::Point> obstacles() const override { return scan; }
  bool HasScan() const override { return has_scan; }
  bool ScanCovers(const navigation::Point&) const override { return has_scan; }
  std::vector<SeenObject> objects() const override {
    return has_objects ? seen : std::vector<SeenObject>();
  }
  bool HasObjects() const override { return has_objects; }
  std::optional<std::vector<SeenObject>> Detect() override {
    return has_objects ? std::optional(seen) : std::nullopt;
  }
  std::optional<Look> LookFor(const std::string& target) override;
  std::optional<navigation::Pose> PoseOf(const std::string&) override { return std::nullopt; }
  std::uint64_t PosesOf(const std::string&) const override { return 0; }
  bool HasCamera(const std::string& camera) const override;
  std::vector<std::string> cameras() const override { return camera_names; }
  skill::Future<Picture> TakePicture(const std::string& camera) override;
  skill::Future<std::string> SavePng(const Picture& saved, const std::string& path) override;
  std::optional<Line> line() const override { return std::nullopt; }
  bool HasHand() const override { return has_hand; }
  skill::Future<HandReply> UseHand(const HandRequest& request) override;

 private:
  HandReply Use(const HandRequest& request);
  void Move(double step_s);
  // Keeps the source until the work is done in the next step.
  template <class T>
  skill::Future<T> Later(Reply reply, std::function<T()> work);

  const std::string name_;
  const std::string kind_;
  bool descent_held_ = false;
  Time now_{};
  std::vector<std::function<void()>> due_;
  std::vector<std::shared_ptr<void>> unanswered_;
};

// A robot with the skills of its body, stepped each 100 ms of simulated time.
class Bench {
 public:
  Bench(const std::string& name, const std::string& kind);

  FakeRobot robot;

  void Start(const std::string& skill, const skill::Values& parameters = {});
  // One step. Each message of a run is noted once, as "10 Taking off".
  void Step();
  void StepFor(double seconds);
  // Until the skill has ended, or five minutes have passed.
  const skill::Feedback& RunOut();
  // Start() and RunOut().
  const skill::Feedback& Execute(const std::string& skill, const skill::Values& parameters = {});

  // Continues in another process, from a snapshot of this moment.
  void Restore();

  const skill::Run& run() const { return *manager_->Find(skill_); }
  const skill::Feedback& feedback() const { return run().feedback(); }
  skill::Manager& manager() { return *manager_; }
  const std::vector<skill::Entry>& entries() const { return registry_.All(); }
  double seconds() const { return ToSeconds(now_.time_since_epoch()); }

  std::vector<std::string> messages;

 private:
  skill::Registry registry_;
  std::unique_ptr<skill::Manager> manager_;
  std::string skill_;
  Time now_{};
};

}  // namespace musher::skills::testing
