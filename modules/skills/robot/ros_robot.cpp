#include "musher/modules/skills/robot/ros_robot.hpp"

#include <algorithm>
#include <utility>

#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/modules/skills/robot/wire.hpp"

namespace musher::skills {
namespace {

constexpr Duration kHandTime = std::chrono::seconds(2);  // of its server, to a request

static_assert(static_cast<std::uint8_t>(HandAction::kPlace) == msg::ManipulationControl::kPlace);

template <class T>
skill::Future<T> Failed(const std::string& why) {
  skill::Source<T> source;
  source.Fail(why);
  return source.future();
}

constexpr const char* kClosed = "the robot's topics are not open";

// A drive that could not begin.
class NoDrive : public Drive {
 public:
  std::optional<double> distance_to_goal_m() const override { return std::nullopt; }
  void Cancel() override {}
  skill::Future<bool> end() const override { return Failed<bool>(kClosed); }
};

}  // namespace

void RosRobot::Open(transport::Endpoints& endpoints, const std::string& name_space, WriteLine log,
                    std::string flight_file) {
  const auto wire = std::make_shared<Wire>(config_, endpoints, name_space, std::move(log),
                                           std::move(flight_file));
  now_ = wire->Now();
  wire_ = wire;
  if (std::exchange(cancels_earlier_, false)) wire->navigator->CancelEarlierDrives();
  endpoints.Keep(wire);  // dropped before what it uses
}

void RosRobot::BeginStep(Time now) {
  now_ = now;
  const auto wire = wire_.lock();
  if (!wire) return;
  wire->active_at = now;
  wire->navigator->Update();
  wire->cameras->Update();
  if (wire->detectors) wire->detectors->Update();
  wire->looks->Update();
  wire->maps->Update();
}

void RosRobot::StandStill() {
  if (const auto wire = wire_.lock()) wire->StandStill();
}

RosRobot::MissingInterfaces RosRobot::Look() const {
  const auto wire = wire_.lock();
  return wire ? wire->Look() : MissingInterfaces{kClosed, {}};
}

std::string RosRobot::LowBattery() const {
  const auto wire = wire_.lock();
  return wire ? wire->LowBattery() : "";
}

std::optional<navigation::Pose> RosRobot::pose() const {
  const auto wire = wire_.lock();
  return wire ? wire->PoseNow() : std::nullopt;
}

std::string RosRobot::WhyNoPose() const {
  const auto wire = wire_.lock();
  const std::string* why = wire ? wire->refused.At(wire->Now()) : nullptr;
  if (why == nullptr) return Robot::WhyNoPose();
  return "No pose of " + name() + " in the map (" + config_.names.odometry + ": " + *why + ")";
}

navigation::Velocity RosRobot::velocity() const {
  const auto wire = wire_.lock();
  const Wire::Motion* motion = wire ? wire->motion.At(wire->Now()) : nullptr;
  return motion == nullptr ? navigation::Velocity{} : motion->velocity;
}

std::optional<navigation::Pose> RosRobot::odometry() const {
  const auto wire = wire_.lock();
  const Wire::Motion* now = wire ? wire->odometry.At(wire->Now()) : nullptr;
  return now == nullptr ? std::nullopt : std::optional(now->pose);
}

navigation::Path RosRobot::travelled() const {
  const auto wire = wire_.lock();
  return wire ? wire->travelled.Back() : navigation::Path{};
}

void RosRobot::SetVelocity(const navigation::Velocity& command) {
  if (const auto wire = wire_.lock()) wire->SetVelocity(command);
}

std::string RosRobot::HeldBy() const {
  const auto wire = wire_.lock();
  return wire ? wire->velocity->HeldBy() : "";
}

std::string RosRobot::WhyNotDescending() const {
  const auto wire = wire_.lock();
  return wire ? wire->velocity->WhyNotDescending() : "";
}

void RosRobot::ExpectGround(double height_m) {
  if (const auto wire = wire_.lock()) wire->ExpectGround(height_m);
}

void RosRobot::NoteLanding() {
  if (const auto wire = wire_.lock()) wire->hold.Land();
}

std::string RosRobot::WhyNotHeld() const {
  const auto wire = wire_.lock();
  return wire ? wire->WhyNotHeld() : "";
}

std::optional<BatteryLevel> RosRobot::battery() const {
  const auto wire = wire_.lock();
  return wire ? wire->Battery() : std::nullopt;
}

bool RosRobot::HasTransform(const std::string& parent, const std::string& child) const {
  const auto wire = wire_.lock();
  return wire && wire->HasTransform(parent, child);
}

void RosRobot::StopMotion() {
  if (const auto wire = wire_.lock()) wire->StopMotion();
}

bool RosRobot::HasPlanner() const {
  const auto wire = wire_.lock();
  return wire && wire->navigator->HasPlanner();
}

bool RosRobot::HasController() const {
  const auto wire = wire_.lock();
  return wire && wire->navigator->HasController();
}

bool RosRobot::Drives() const {
  const auto wire = wire_.lock();
  return wire && wire->Drives();
}

void RosRobot::CancelEarlierDrives() {
  const auto wire = wire_.lock();
  cancels_earlier_ = wire == nullptr;
  if (wire) wire->navigator->CancelEarlierDrives();
}

skill::Future<navigation::Path> RosRobot::ComputePath(
    const navigation::Pose& goal, const std::optional<navigation::Pose>& start) {
  const auto wire = wire_.lock();
  return wire ? wire->navigator->ComputePath(goal, start) : Failed<navigation::Path>(kClosed);
}

std::unique_ptr<Drive> RosRobot::FollowPath(const navigation::Path& path) {
  const auto wire = wire_.lock();
  if (!wire) return std::make_unique<NoDrive>();
  wire->FreeBase();
  auto drive = wire->navigator->FollowPath(path);
  wire->traffic->Begin(path);
  return drive;
}

skill::Future<bool> RosRobot::ClearMemory() {
  const auto wire = wire_.lock();
  return wire ? wire->ClearMemory() : Failed<bool>(kClosed);
}

navigation::RobotIntent RosRobot::intent() {
  const auto wire = wire_.lock();
  return wire ? wire->traffic->Intent() : navigation::RobotIntent{};
}

std::vector<navigation::RobotIntent> RosRobot::others() const {
  const auto wire = wire_.lock();
  return wire ? wire->traffic->Others() : std::vector<navigation::RobotIntent>{};
}

void RosRobot::NoteCornered(Duration time) {
  if (const auto wire = wire_.lock()) wire->traffic->NoteCornered(time);
}

skill::Future<navigation::Path> RosRobot::ComputeRefuge() {
  const auto wire = wire_.lock();
  return wire ? wire->traffic->ComputeRefuge() : Failed<navigation::Path>(kClosed);
}

GroundMap RosRobot::map() {
  const auto wire = wire_.lock();
  return wire ? wire->maps->Ask() : GroundMap{};
}

std::vector<navigation::Point> RosRobot::obstacles() const {
  const auto wire = wire_.lock();
  return wire ? wire->Seen() : std::vector<navigation::Point>{};
}

bool RosRobot::HasScan() const {
  const auto wire = wire_.lock();
  return wire && wire->HasScan();
}

bool RosRobot::ScanCovers(const navigation::Point& place) const {
  const auto wire = wire_.lock();
  return wire && wire->velocity->Covers(place);
}

std::vector<SeenObject> RosRobot::objects() const {
  const auto wire = wire_.lock();
  const auto* seen = wire ? wire->objects.At(wire->Now()) : nullptr;
  return seen == nullptr ? std::vector<SeenObject>{} : *seen;
}

bool RosRobot::HasObjects() const {
  const auto wire = wire_.lock();
  return wire && wire->objects.At(wire->Now()) != nullptr;
}

std::optional<std::vector<SeenObject>> RosRobot::Detect() {
  const auto wire = wire_.lock();
  if (wire && wire->detectors) return wire->detectors->Look();
  if (!HasObjects()) return std::nullopt;
  return objects();
}

std::string RosRobot::WhyNothingSeen() const {
  const auto wire = wire_.lock();
  const std::string* why = wire ? wire->refused_objects.At(wire->Now()) : nullptr;
  if (why == nullptr) return Robot::WhyNothingSeen();
  return "no objects with a place in the map (" + config_.names.objects + ": " + *why + ")";
}

std::optional<skills::Look> RosRobot::LookFor(const std::string& target) {
  const auto wire = wire_.lock();
  return wire ? wire->looks->LookFor(target) : std::nullopt;
}

std::string RosRobot::WhyNoLook() const {
  const auto wire = wire_.lock();
  return wire ? wire->looks->WhyNone() : kClosed;
}

std::optional<navigation::Pose> RosRobot::PoseOf(const std::string& topic) {
  const auto wire = wire_.lock();
  const navigation::Pose* pose = wire ? wire->PoseOf(topic) : nullptr;
  if (pose == nullptr) return std::nullopt;
  return *pose;
}

std::string RosRobot::WhyNoPoseOf(const std::string& topic) const {
  const auto wire = wire_.lock();
  if (!wire) return Robot::WhyNoPoseOf(topic);
  const auto found = wire->tracked.find(topic);
  const std::string* why =
      found == wire->tracked.end() ? nullptr : found->second.refused.At(wire->Now());
  return Robot::WhyNoPoseOf(topic) + (why == nullptr ? "" : " in the map (" + *why + ")");
}

std::uint64_t RosRobot::PosesOf(const std::string& topic) const {
  const auto wire = wire_.lock();
  if (!wire) return 0;
  const auto found = wire->tracked.find(topic);
  return found == wire->tracked.end() ? 0 : found->second.count;
}

bool RosRobot::HasCamera(const std::string& camera) const {
  return std::ranges::any_of(config_.cameras,
                             [&](const auto& named) { return named.first == camera; });
}

std::vector<std::string> RosRobot::cameras() const {
  std::vector<std::string> names;
  for (const auto& [name, topic] : config_.cameras) names.push_back(name);
  return names;
}

skill::Future<Picture> RosRobot::TakePicture(const std::string& camera) {
  const auto wire = wire_.lock();
  return wire ? wire->cameras->Take(camera) : Failed<Picture>(kClosed);
}

skill::Future<std::string> RosRobot::SavePng(const Picture& picture, const std::string& path) {
  const auto wire = wire_.lock();
  return wire ? wire->photos->Save(picture, path) : Failed<std::string>(kClosed);
}

std::optional<Robot::Line> RosRobot::line() const {
  const auto wire = wire_.lock();
  const Line* seen = wire ? wire->line.At(wire->Now()) : nullptr;
  if (seen == nullptr) return std::nullopt;
  return *seen;
}

skill::Future<HandReply> RosRobot::UseHand(const HandRequest& request) {
  const auto wire = wire_.lock();
  if (!wire) return Failed<HandReply>(kClosed);
  if (wire->hand == nullptr) return Failed<HandReply>(name() + " has no hand");
  const auto source = std::make_shared<skill::Source<HandReply>>();
  wire->hand->Call(ToMessage(request), kHandTime, [source](const auto& reply) {
    if (reply) {
      source->Finish({reply.value().success, reply.value().message, reply.value().distance_m});
    } else {
      source->Fail("the hand: " + reply.error().message);
    }
  });
  return source->future();
}

}  // namespace musher::skills
