#include "musher/modules/skills/robot/wire.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/transport/action_names.hpp"

namespace musher::skills {
namespace {

// Topics that skills have named; of more, the one that was not asked for longest is dropped.
constexpr std::size_t kMostTracked = 16;
constexpr double kBatteryHysteresisPercent = 2;
constexpr Duration kBatterySettles = std::chrono::seconds(2);  // samples of so long agree
constexpr double kSinkingMS = -0.01;  // a command that reaches the body and leads down
constexpr Duration kHoldPeriod = Milliseconds(100);  // of a flyer at its place
// A command of the controller may come after the report that its drive has ended.
constexpr Duration kLastOfDrive = std::chrono::seconds(1);
constexpr double kReachesShare = 0.5;                     // of a command that reaches the body
constexpr Duration kClearTime = std::chrono::seconds(2);  // of planner and controller
constexpr Duration kActiveWithin = Milliseconds(500);     // skills are stepped in Active only
// As tf2 has it.
constexpr transport::Qos kTfQos{transport::Qos::Reliability::kReliable,
                                transport::Qos::Durability::kVolatile, 100};

}  // namespace

RosRobot::Wire::Wire(const SkillsConfig& robot_config, transport::Endpoints& endpoints,
                     std::string machine_name_space, RosRobot::WriteLine log,
                     std::string flight_file)
    : config(robot_config),
      node(endpoints.node()),
      clock(endpoints.clock()),
      name_space(std::move(machine_name_space)),
      log_(std::move(log)),
      saved_flight_(std::move(flight_file)),
      frames_(robot_config.tf_stale) {
  const InterfaceNames& names = config.names;
  velocity = std::make_unique<VelocityOutput>(
      endpoints.Advertise<msg::Twist>(names.velocity), clock, config.gate,
      navigation::GuardRules{.speed_m_s = config.speed_m_s, .yaw_rad_s = config.yaw_rad_s},
      config.flies);
  navigator = std::make_unique<Navigator>(
      node.loop(), endpoints.OpenActionClient<msg::ComputePathToPose>(names.planner),
      endpoints.OpenActionClient<msg::FollowPath>(names.controller),
      [this] { return clock.Stamp(); }, [this](const std::string& frame) { return InMap(frame); });
  traffic = std::make_unique<Traffic>(
      config, "/" + transport::ResolveName(name_space, config.robot),
      Traffic::Body{[this] { return PoseNow(); }, [this] { return navigator->Drives(); },
                    [this](const std::string& frame) { return InMap(frame); }},
      endpoints);
  std::map<std::string, std::string> topics;
  for (const auto& [camera, topic] : config.cameras) {
    topics[camera] = transport::ResolveName(name_space, topic);
  }
  cameras = std::make_unique<CameraFeeds>(node, std::move(topics));
  photos = std::make_unique<PhotoFolder>(config.photo_folder, node.loop());
  if (!config.detectors.empty()) {
    detectors = std::make_unique<DetectorFeeds>(node, clock, name_space, config.detectors,
                                                [this] { return PoseNow(); });
  }
  looks = std::make_unique<LookFeeds>(node, clock, name_space, config,
                                      [this](const std::string& frame) { return OnBody(frame); });
  maps = std::make_unique<MapFeed>(
      node, clock, names.map.empty() ? "" : transport::ResolveName(name_space, names.map),
      [this](const std::string& frame) { return InMap(frame); });
  if (config.hand) hand = endpoints.OpenClient<msg::ManipulationControl>(names.hand);
  for (const std::string& name : {names.clear_planner, names.clear_controller}) {
    if (!name.empty()) memories.push_back(endpoints.OpenClient<msg::Trigger>(name));
  }
  SubscribeFrames(endpoints);
  Subscribe(endpoints);
  SubscribeScans(endpoints);
  SubscribeRanges(endpoints);
  SubscribeDrives(endpoints);
  if (!config.flies) return;
  SubscribeCommandsOfOthers(endpoints);
  hold.SetSight([this](const navigation::Point& place) { return SeesTowards(place); });
  holds_ = clock.Every(kHoldPeriod, [this] {
    HoldPlace();
    SavePlace();
  });
}

std::optional<navigation::Pose> RosRobot::Wire::PoseNow() const {
  const Motion* now = motion.At(Now());
  return now == nullptr ? std::nullopt : std::optional(now->pose);
}

Result<navigation::Pose> RosRobot::Wire::InMap(const std::string& frame) const {
  if (frame.empty() || frame == kMapFrame) return navigation::Pose{};
  const auto placed = frames_.Find(kMapFrame, frame, Now());
  if (!placed) return placed.error();
  if (!placed.value().upside_down) return placed.value().pose;
  return navigation::MakeError(navigation::Fault::kFrame, "its frame is upside down in the map");
}

Result<navigation::Pose> RosRobot::Wire::OnBody(const std::string& frame) const {
  if (frame.empty() || frame == body_frame_) return navigation::Pose{};
  const auto placed = frames_.Find(body_frame_, frame, Now());
  if (!placed) return placed.error();
  if (!placed.value().upside_down) return placed.value().pose;
  return navigation::MakeError(navigation::Fault::kFrame, "its frame is upside down on the body");
}

bool RosRobot::Wire::HasTransform(const std::string& parent, const std::string& child) const {
  const auto lies = [this](const std::string& in, const std::string& frame) {
    return frames_.Find(in, frame, Now()).ok();
  };
  if (lies(parent, child)) return true;
  const std::string odom_frame = odom_frame_.empty() ? kMapFrame : odom_frame_;
  return odometry.At(Now()) != nullptr && lies(parent, odom_frame) && lies(body_frame_, child);
}

std::optional<BatteryLevel> RosRobot::Wire::Battery() const {
  const BatteryReport* lowest = LowestBattery();
  if (lowest == nullptr) return std::nullopt;
  BatteryLevel level{.share = lowest->percent / 100,
                     .charges = lowest->charges && !lowest->is_full};
  if (std::isfinite(lowest->voltage_v)) level.voltage_v = lowest->voltage_v;
  return level;
}

const RosRobot::Wire::BatteryReport* RosRobot::Wire::LowestBattery() const {
  if (batteries_.empty()) return nullptr;
  return &std::ranges::min_element(batteries_, {}, [](const auto& one) {
            return one.second.percent;
          })->second;
}

void RosRobot::Wire::SubscribeFrames(transport::Endpoints& endpoints) {
  const std::string& topic = config.names.tf;
  if (topic.empty()) return;
  const auto take = [this](bool fixed) {
    return [this, fixed](const msg::TfMessage& message) { frames_.Take(message, fixed, Now()); };
  };
  endpoints.Subscribe<msg::TfMessage>(topic, take(false), kTfQos);
  endpoints.Subscribe<msg::TfMessage>(topic + "_static", take(true),
                                      transport::kLatchedFromManyQos);
}

void RosRobot::Wire::SubscribeScans(transport::Endpoints& endpoints) {
  const auto& scanners = config.gate.scanners;
  obstacles.resize(scanners.size());
  for (std::size_t i = 0; i < scanners.size(); ++i) {
    optional[scanners[i].topic] = endpoints.Subscribe<msg::LaserScan>(
        scanners[i].topic,
        [this, i](const msg::LaserScan& scan) {
          const auto mount = frames_.Find(body_frame_, scan.header.frame_id, Now());
          if (mount) velocity->Mount(i, mount.value());
          const Motion* here = motion.At(Now());
          if (!velocity->OnScan(i, scan) || here == nullptr) return;
          obstacles[i].Set(navigation::PlacedAt(here->pose, velocity->PointsOf(i)), Now());
        },
        transport::kSensorDataQos);
  }
}

void RosRobot::Wire::SubscribeRanges(transport::Endpoints& endpoints) {
  const std::string& topic = config.gate.down.topic;
  if (topic.empty()) return;
  optional[topic] = endpoints.Subscribe<msg::Range>(
      topic, [this](const msg::Range& range) { velocity->OnRange(range); },
      transport::kSensorDataQos);
}

// The gate knows heights in the frame of the odometry.
void RosRobot::Wire::ExpectGround(double height_m) {
  const Motion *own = odometry.At(Now()), *mapped = motion.At(Now());
  if (own == nullptr || mapped == nullptr) return;
  velocity->ExpectGround(height_m + own->pose.at.z_m - mapped->pose.at.z_m);
}

void RosRobot::Wire::SubscribeDrives(transport::Endpoints& endpoints) {
  endpoints.SubscribeEach<msg::GoalStatusArray>(
      transport::StatusTopic(config.names.controller),
      [this](const msg::GoalStatusArray& goals, transport::EndpointId controller) {
        navigator->TakeStatus(goals, controller);
      },
      [this](transport::EndpointId controller) { navigator->ForgetStatus(controller); },
      transport::kLatchedQos);
}

// For example a person's own teleop, or a program that lands it: the hold leaves the base to it as
// long as it sends. A program at rest may send 0 on.
void RosRobot::Wire::SubscribeCommandsOfOthers(transport::Endpoints& endpoints) {
  endpoints.SubscribeWithInfo<msg::Twist>(
      config.names.velocity,
      [this](const msg::Twist& twist, const transport::SampleInfo& info) {
        if (info.participant == node.participant() || twist == msg::Twist{}) return;
        if (Drives() || Now() - driven_until_ < kLastOfDrive) return;
        hold.NoteOther(ToMapFrame(twist, 0));
      },
      {});
}

bool RosRobot::Wire::Drives() const {
  return navigator->Drives() || navigator->ControllerDrives();
}

std::vector<navigation::Point> RosRobot::Wire::Seen() const {
  std::vector<navigation::Point> seen;
  for (const auto& points : obstacles) {
    const auto* recent = points.At(Now());
    if (recent != nullptr) seen.insert(seen.end(), recent->begin(), recent->end());
  }
  return seen;
}

bool RosRobot::Wire::HasScan() const {
  return !obstacles.empty() && std::ranges::all_of(obstacles, [this](const auto& points) {
    return points.At(Now()) != nullptr;
  });
}

// In the frame of the odometry.
bool RosRobot::Wire::SeesTowards(const navigation::Point& place) const {
  const Motion* own = odometry.At(Now());
  if (own == nullptr) return false;
  const navigation::Pose& here = own->pose;
  const navigation::Velocity off = navigation::InBodyFrame(
      {place.x_m - here.at.x_m, place.y_m - here.at.y_m, 0, 0}, here.yaw_rad);
  return velocity->Covers({off.x_m_s, off.y_m_s, 0});
}

// A person moves the robot only in Active, and while no skill does.
void RosRobot::Wire::OnTeleop(const msg::Twist& twist) {
  const bool active = active_at && Now() - *active_at <= kActiveWithin;
  if (!active || Drives()) return;
  // A stick at rest may send 0 on. That moves nothing: a flyer in the air is held, and one in a
  // hand is not used.
  if (config.flies && twist == msg::Twist{}) {
    if (velocity->teleoperated()) StopMotion();
    return;
  }
  if (holding_) StopMotion();
  navigation::Velocity command = ToMapFrame(twist, 0);
  if (config.flies && !low_battery_.empty()) {  // a person chooses where it lands, and not whether
    command.z_m_s = std::min(command.z_m_s, -FlightHold::kLastDescentMps);
  }
  velocity->Teleoperate(command);
}

// A value that is not measured changes nothing, and neither do a silent battery and one sample that
// differs from those around it.
void RosRobot::Wire::OnBattery(const msg::BatteryState& battery, transport::EndpointId publisher) {
  if (std::isnan(battery.percentage)) return;
  const bool in_range = battery.percentage >= 0 && battery.percentage <= 1;
  if (!in_range) return RefuseBattery(battery);
  if (!presence_.Counts(battery.present, battery.percentage, battery.voltage)) {
    return RefuseBattery(battery);
  }
  if (!battery.present && !std::exchange(battery_doubted_, true)) {
    Log(LogLevel::kWarning, config.names.battery +
                                " says that no battery is present, but its level or voltage "
                                "changes: it is used");
  }
  const bool full = battery.power_supply_status == msg::BatteryState::kStatusFull;
  const bool charging = battery.power_supply_status == msg::BatteryState::kStatusCharging || full;
  batteries_[publisher] = {100 * static_cast<double>(battery.percentage), charging, full,
                           static_cast<double>(battery.voltage)};
  const bool several = batteries_.size() > 1;
  if (several && !std::exchange(batteries_logged_, true)) {
    Log(LogLevel::kWarning, config.names.battery + " has two publishers: the lower level counts");
  }
  batteries_logged_ = several;
  const BatteryReport& lowest = *LowestBattery();
  const double percent = lowest.percent;
  const bool charges = lowest.charges;
  const double limit = config.low_battery_percent;
  const bool was_low = !low_battery_.empty();
  const double ends_above = limit + (was_low ? kBatteryHysteresisPercent : 0);
  const bool low = !charges && percent <= ends_above;
  if (low == was_low) {
    battery_differs_since_.reset();
  } else {
    if (!battery_differs_since_) battery_differs_since_ = Now();
    if (Now() - *battery_differs_since_ < kBatterySettles) return;
    battery_differs_since_.reset();
  }
  low_battery_ = low ? fmt::format("the battery of {} is at {:.0f} %, its limit is {:.0f} %",
                                   config.robot, percent, limit)
                     : "";
  if (!config.flies) return;
  if (!low) stood_high_ = held_high_ = false;
  velocity->MustLand(low);
  if (charges) hold.NoteCharging();
  hold.SetBatteryLow(low);
}

void RosRobot::Wire::RefuseBattery(const msg::BatteryState& battery) {
  if (std::exchange(battery_refused_, true)) return;
  const std::string& topic = config.names.battery;
  const bool in_range = battery.percentage >= 0 && battery.percentage <= 1;
  Log(LogLevel::kWarning,
      in_range ? fmt::format("{} is not used: it says that no battery is present", topic)
               : fmt::format("{} is not used: its percentage is {:g}, expected 0 to 1", topic,
                             battery.percentage));
}

// Without odometry the last place counts, as long as it is not old.
void RosRobot::Wire::SavePlace() {
  const Motion* now = odometry.At(Now());
  if (now == nullptr) return;
  const bool flies = hold.armed() && now->pose.at.z_m >= FlightHold::kInTheAirM;
  const Result<> saved = saved_flight_.Save(flies ? std::optional(now->pose.at) : std::nullopt);
  if (!saved) Log(LogLevel::kWarning, config.robot + ": " + saved.error().message);
}

// By its odometry alone: a flyer holds its place also while it has none in the map.
void RosRobot::Wire::HoldPlace() {
  // Not before its first pose: until then a person may have taken it.
  if (odometry.At(Now()) != nullptr && !std::exchange(looked_for_flight_, true)) {
    if (const auto place = saved_flight_.Found()) hold.Restore(*place);
  }
  if (!low_battery_.empty() && Drives()) navigator->CancelEarlierDrives();  // of other clients, too
  if (Drives()) driven_until_ = Now();
  if (Drives() || (velocity->sending() && !holding_)) {
    if (holding_) StopMotion();
    hold.Use();
    end_logged_.clear();
    return;
  }
  const Motion* now = odometry.At(Now());
  const auto command = now == nullptr
                           ? hold.Command(std::nullopt, 0, kHoldPeriod)
                           : hold.Command(now->pose, navigation::Speed(now->velocity), kHoldPeriod);
  if (!command) {
    if (holding_) StopMotion();
    LogEndOfHold();
    return;
  }
  velocity->Set(*command);
  holding_ = true;
  const navigation::Velocity& passed = velocity->passed();
  const bool sinks = command->z_m_s >= kSinkingMS || passed.z_m_s < kSinkingMS;
  const bool reaches = navigation::Speed(passed) >= kReachesShare * navigation::Speed(*command);
  if (!sinks || !reaches) hold.NoteStopped();
  if (!sinks && !velocity->WhyNotDescending().empty()) hold.NoteHeldDescent();
  LogHeldDescent();
  const bool stands_high = hold.StandsHigh();
  if (stands_high && !std::exchange(stood_high_, stands_high)) {
    Log(LogLevel::kWarning,
        fmt::format("{} lands with a low battery and comes no lower at {:.2f} m above the zero of "
                    "its odometry; it descends on until it is charged",
                    config.robot, now == nullptr ? 0.0 : now->pose.at.z_m));
  }
}

void RosRobot::Wire::LogHeldDescent() {
  const std::string why = velocity->WhyNotDescending();
  if (low_battery_.empty() || why.empty() || std::exchange(held_high_, true)) return;
  const std::string stays = HasScan() ? "" : "; without a scan it does not go aside";
  Log(LogLevel::kWarning, config.robot + " lands with a low battery: " + why + stays);
}

void RosRobot::Wire::LogEndOfHold() {
  if (hold.ended().empty() || hold.ended() == end_logged_) return;
  end_logged_ = hold.ended();
  Log(LogLevel::kWarning,
      WhyNotHeld() + (hold.of_other()
                          ? "; it is held again if that leaves it in the air"
                          : "; it is held again after a skill, a drive or another program has "
                            "moved it"));
}

std::string RosRobot::Wire::WhyNotHeld() const {
  if (hold.ended().empty()) return "";
  return config.robot + " is not held at its place any more: " + hold.ended();
}

void RosRobot::Wire::OnOdometry(const msg::Odometry& message) {
  const auto pose = ToPose(message.pose.pose);
  const Duration stamp = msg::FromStamp(message.header.stamp);
  if (!pose) return;
  // Stamps that stand are of odometry that stands.
  if (!odometry_order_.Take(stamp)) return refused.Set("its stamps do not go on", Now());
  body_frame_ = message.child_frame_id;
  odom_frame_ = message.header.frame_id;
  velocity->OnMotion(*pose, ToMapFrame(message.twist.twist, 0), stamp);
  odometry.Set({*pose, ToMapFrame(message.twist.twist, pose->yaw_rad)}, Now());
  travelled.Add(*pose);
  const auto frame = InMap(message.header.frame_id);
  if (!frame) return refused.Set(frame.error().message, Now());
  const navigation::Pose here = navigation::PlacedAt(frame.value(), *pose);
  motion.Set({here, ToMapFrame(message.twist.twist, here.yaw_rad)}, Now());
}

void RosRobot::Wire::Subscribe(transport::Endpoints& endpoints) {
  const InterfaceNames& names = config.names;
  endpoints.Subscribe<msg::Odometry>(names.odometry,
                                     [this](const msg::Odometry& message) { OnOdometry(message); });
  if (!names.battery.empty()) {
    const auto take = [this](const msg::BatteryState& battery, transport::EndpointId publisher) {
      OnBattery(battery, publisher);
    };
    const auto forget = [this](transport::EndpointId publisher) { batteries_.erase(publisher); };
    const auto* battery = endpoints.SubscribeEach<msg::BatteryState>(names.battery, take, forget,
                                                                     transport::kSensorDataQos);
    if (config.flies) optional[names.battery] = battery;
    // One that is only published when it changes. Its last sample may arrive after the other
    // subscription has lost the publisher.
    endpoints.SubscribeEach<msg::BatteryState>(names.battery, take, forget, transport::kLatchedQos);
  }
  if (!names.teleop.empty()) {
    endpoints.Subscribe<msg::Twist>(names.teleop,
                                    [this](const msg::Twist& twist) { OnTeleop(twist); });
  }
  if (!names.objects.empty()) {
    optional[names.objects] = endpoints.Subscribe<msg::ObjectStates>(
        names.objects, [this](const msg::ObjectStates& states) {
          const auto frame = InMap(states.header.frame_id);
          if (!frame) return refused_objects.Set(frame.error().message, Now());
          objects.Set(ToObjects(states, frame.value()), Now());
        });
  }
  if (!names.line.empty()) {
    optional[names.line] = endpoints.Subscribe<msg::YellowLines>(
        names.line,
        [this](const msg::YellowLines& lines) {
          const Duration stamp = msg::FromStamp(lines.header.stamp);
          const bool again = stamp != Duration::zero() && stamp == line_stamp_;
          if (again) return;  // of a camera that stands: the line gets old
          line_stamp_ = stamp;
          if (const auto seen = ToLine(lines, config.line)) {
            line.Set(*seen, Now());
          } else {
            line.Clear();
          }
        },
        transport::kSensorDataQos);
  }
}

RosRobot::MissingInterfaces RosRobot::Wire::Look() const {
  MissingInterfaces missing;
  if (motion.At(Now()) == nullptr) {
    const std::string& topic = config.names.odometry;
    const std::string* why = refused.At(Now());
    missing.odometry =
        why == nullptr ? "no odometry on " + topic : "no pose in the map: " + topic + ": " + *why;
  }
  const auto add = [&](bool there, const std::string& what) {
    if (!there) missing.others.push_back("no " + what);
  };
  add(navigator->HasPlanner(), "server of " + config.names.planner);
  add(navigator->HasController(), "server of " + config.names.controller);
  if (hand != nullptr) add(hand->Ready(), "server of " + config.names.hand);
  const std::string* refused_by = refused_objects.At(Now());
  if (refused_by != nullptr && objects.At(Now()) == nullptr) {
    add(false, "place in the map for " + config.names.objects + ": " + *refused_by);
  }
  for (const auto& [topic, subscription] : optional) {
    add(subscription == nullptr || subscription->MatchedWriters() > 0, "publisher of " + topic);
  }
  return missing;
}

// The first reason of a failure counts.
skill::Future<bool> RosRobot::Wire::ClearMemory() {
  const auto source = std::make_shared<skill::Source<bool>>();
  const auto left = std::make_shared<std::size_t>(memories.size());
  if (memories.empty()) source->Fail("the config names no memory to clear");
  for (auto* memory : memories) {
    if (memory == nullptr) continue;
    memory->Call({}, kClearTime, [source, left](const auto& reply) {
      if (!reply) return source->Fail("the memory is not cleared: " + reply.error().message);
      if (!reply.value().success) return source->Fail(reply.value().message);
      if (--*left == 0) source->Finish(true);
    });
  }
  return source->future();
}

const navigation::Pose* RosRobot::Wire::PoseOf(const std::string& topic) {
  auto found = tracked.find(topic);
  if (found == tracked.end()) {
    if (!config_toml::IsTopic(topic)) return nullptr;
    if (tracked.size() >= kMostTracked) {
      tracked.erase(std::ranges::min_element(tracked, {},
                                             [](const auto& named) { return named.second.asked; }));
    }
    found = tracked.emplace(topic, Tracked{}).first;
    Tracked& made = found->second;
    auto subscription = transport::MakeSubscription<msg::Odometry>(
        node, transport::ResolveName(name_space, topic),
        [this, &made](const msg::Odometry& odometry, const transport::SampleInfo&) {
          const auto pose = ToPose(odometry.pose.pose);
          const Duration stamp = msg::FromStamp(odometry.header.stamp);
          const bool again = stamp == made.stamp && stamp != Duration{};  // it is not seen any more
          if (!pose || again) return;
          made.stamp = stamp;
          const auto frame = InMap(odometry.header.frame_id);
          if (!frame) return made.refused.Set(frame.error().message, Now());
          made.pose.Set(navigation::PlacedAt(frame.value(), *pose), Now());
          ++made.count;
        });
    if (subscription) made.subscription = std::move(subscription).value();
  }
  found->second.asked = Now();
  return found->second.pose.At(Now());
}

}  // namespace musher::skills
