#include "musher/modules/skills/robot/traffic.hpp"

#include <algorithm>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {
namespace {

constexpr Duration kRefugeTime = std::chrono::seconds(6);  // of the planner's service

}  // namespace

Traffic::Traffic(const SkillsConfig& config, const std::string& name, Body body,
                 transport::Endpoints& endpoints)
    : body_(std::move(body)), clock_(endpoints.clock()), known_(name) {
  own_.robot = name;
  own_.priority = config.priority;
  own_.radius_m = config.radius_m;
  own_.flies = config.flies;
  const std::string& topic = config.names.robot_paths;
  if (topic.empty()) return;
  publisher_ = endpoints.Advertise<msg::RobotPath>(topic);
  refuge_ = endpoints.OpenClient<msg::ComputeRefuge>(config.names.refuge);
  endpoints.Subscribe<msg::RobotPath>(topic, [this](const msg::RobotPath& path) {
    auto intent = ToIntent(path);
    if (!intent) return;  // of another map: its places say nothing here
    static_cast<void>(
        known_.Take(*std::move(intent), msg::FromStamp(path.header.stamp), clock_.Now()));
  });
  ticks_ = clock_.Every(kPeriod, [this] { Publish(); });
}

void Traffic::Begin(const navigation::Path& path) {
  path_.Start(path);
  drove_at_ = clock_.Now();
  Publish();
}

void Traffic::NoteCornered(Duration time) {
  const Time until = clock_.Now() + time;
  cornered_until_ = std::max(cornered_until_.value_or(until), until);
}

navigation::RobotIntent Traffic::Intent() {
  const Time now = clock_.Now();
  if (body_.drives()) drove_at_ = now;
  navigation::RobotIntent intent = own_;
  intent.cornered = cornered_until_ && now < *cornered_until_;
  const auto pose = body_.pose();
  if (!pose) return intent;
  intent.at = pose->at;
  const bool wants_to_go = drove_at_ && now - *drove_at_ <= kPathStays;
  if (wants_to_go) intent.path = path_.From(pose->at);
  if (intent.path.size() > navigation::KnownRobots::kMostPoints) {
    intent.path.resize(navigation::KnownRobots::kMostPoints);
  }
  return intent;
}

void Traffic::Publish() {
  if (publisher_ == nullptr || !body_.pose()) return;
  // One that is lost is followed by the next.
  static_cast<void>(publisher_->Publish(ToMessage(Intent(), clock_.Stamp())));
}

skill::Future<navigation::Path> Traffic::ComputeRefuge() {
  const auto source = std::make_shared<skill::Source<navigation::Path>>();
  if (refuge_ == nullptr) {
    source->Fail("it knows no other robots");
    return source->future();
  }
  msg::ComputeRefuge::Request request;
  for (const navigation::RobotIntent& other : Others()) {
    request.robots.push_back(ToMessage(other, clock_.Stamp()));
  }
  refuge_->Call(request, kRefugeTime, [source, in_map = body_.in_map](const auto& reply) {
    if (!reply) return source->Fail("the planner: " + reply.error().message);
    if (!reply.value().success) return source->Fail(reply.value().message);
    source->Set(ToPath(reply.value().path, in_map));
  });
  return source->future();
}

}  // namespace musher::skills
