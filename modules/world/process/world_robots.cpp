#include "musher/modules/world/process/world_robots.hpp"

#include <cmath>
#include <utility>

#include "musher/messages/nav_msgs/path.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/modules/world/scene/solids.hpp"
#include "musher/modules/world/sensors/fleet_sensing.hpp"
#include "musher/modules/world/simulation/fleet_report.hpp"

namespace musher::world {
namespace {

constexpr double kObjectsHz = 10;
constexpr double kBatteryHz = 1;

}  // namespace

WorldRobots::WorldRobots(transport::Endpoints& endpoints, World& world,
                         std::function<void(const std::string&)> log)
    : world_(world), log_(std::move(log)) {
  const Scene& scene = world_.scene();
  outlets_.resize(scene.robots.size());
  for (std::size_t i = 0; i < scene.robots.size(); ++i) Open(endpoints, i);
  for (const MoverSpec& mover : scene.movers) {
    mover_odometry_.push_back(
        mover.tracked ? endpoints.Advertise<msg::Odometry>(mover.name + "/odom") : nullptr);
  }
  if (!scene.robots.empty() || !scene.objects.empty()) {
    objects_ = endpoints.Advertise<msg::ObjectStates>("world/objects");
  }
  if (!scene.robots.empty()) OpenMaps(endpoints);
  endpoints.Serve<msg::Trigger>("world/robots", [this](const auto&, auto reply) {
    reply({true, FleetText(world_)});
  });
  endpoints.Serve<msg::Trigger>("world/robots_json", [this](const auto&, auto reply) {
    reply({true, FleetJson(world_)});
  });
}

void WorldRobots::Open(transport::Endpoints& endpoints, std::size_t robot) {
  const RobotSpec& spec = world_.scene().robots[robot];
  const std::string prefix = spec.name + "/";
  Outlet& outlet = outlets_[robot];
  outlet.odometry = endpoints.Advertise<msg::Odometry>(prefix + "odom");
  if (spec.lidar.enabled) {
    outlet.scan = endpoints.Advertise<msg::LaserScan>(prefix + "scan", transport::kSensorDataQos);
  }
  if (spec.range_down) {
    outlet.range_down =
        endpoints.Advertise<msg::Range>(prefix + "range_down", transport::kSensorDataQos);
  }
  outlet.battery = endpoints.Advertise<msg::BatteryState>(prefix + "battery");
  outlet.in_sight = endpoints.Advertise<msg::ObjectStates>(prefix + "objects_in_sight");
  if (spec.detector) {
    outlet.detections =
        endpoints.Advertise<msg::ObjectStates>(prefix + "detections", transport::kSensorDataQos);
  }
  if (spec.line_view) outlet.lines = endpoints.Advertise<msg::YellowLines>(prefix + "lines");
  if (spec.stamped_command) {
    endpoints.Subscribe<msg::TwistStamped>(prefix + "cmd_vel", [this, robot](const auto& stamped) {
      Drive(robot, FromMessage(stamped.twist));
    });
  } else {
    endpoints.Subscribe<msg::Twist>(
        prefix + "cmd_vel", [this, robot](const auto& twist) { Drive(robot, FromMessage(twist)); });
  }
  endpoints.Subscribe<msg::Path>(
      prefix + "planned_path",
      [this, robot](const msg::Path& path) {
        std::vector<Eigen::Vector2d> points;
        for (const msg::PoseStamped& pose : path.poses) {
          const Eigen::Vector2d point(pose.pose.position.x, pose.pose.position.y);
          const bool drawable =
              point.allFinite() && IsWithin(world_.scene(), {{point.x(), point.y(), 0}, 0, 0});
          if (drawable) points.push_back(point);
        }
        world_.SetPlanned(robot, std::move(points));
      },
      transport::kLatchedFromManyQos);
  endpoints.Subscribe<msg::Float32>(
      "world/" + prefix + "set_battery",
      [this, robot](const auto& message) { Log(world_.SetBattery(robot, message.data)); });
  endpoints.Subscribe<msg::PoseStamped>("world/" + prefix + "place",
                                        [this, robot](const auto& message) {
                                          Log(world_.PutDown(robot, FromMessage(message.pose)));
                                        });
  endpoints.Subscribe<msg::String>(
      "world/" + prefix + "odometry",
      [this, robot](const auto& message) { SetOdometry(robot, message.data); });
  if (!spec.hand) return;
  endpoints.Serve<msg::ManipulationControl>(
      prefix + "manipulation_control", [this, robot](const auto& request, auto reply) {
        const auto hand = FromMessage(request);
        if (!hand) return reply({false, hand.error().message, -1});
        const HandReply done = world_.UseHand(robot, hand.value());
        reply({done.success, done.message, done.distance_m});
      });
}

void WorldRobots::Log(const std::optional<std::string>& line) const {
  if (line) log_(*line);
}

void WorldRobots::OpenMaps(transport::Endpoints& endpoints) {
  grid_ = endpoints.Advertise<msg::OccupancyGrid>("map", transport::kLatchedQos);
  cloud_ = endpoints.Advertise<msg::PointCloud2>("map_point_cloud", transport::kLatchedQos);
  endpoints.Serve<msg::SetBool>("world/map", [this](const auto& request, auto reply) {
    PublishMaps(request.data);
    reply({true, ""});
  });
  if (endpoints.opened()) PublishMaps(false);
}

void WorldRobots::PublishMaps(bool with_objects) {
  Scene scene = world_.scene();
  const auto& objects = world_.fleet().objects();
  for (std::size_t i = 0; with_objects && i < objects.size(); ++i) {
    if (objects[i].held_by) continue;
    const Solid solid = SolidOf(scene.objects[i], objects[i]);
    if (const auto* box = std::get_if<Box>(&solid.shape)) scene.boxes.push_back(*box);
    if (const auto* circle = std::get_if<Circle>(&solid.shape)) scene.circles.push_back(*circle);
  }
  const auto publish = [this](const char* name, const Result<>& sent) {
    if (!sent) log_(std::string(name) + " could not be published: " + sent.error().message);
  };
  publish("map", grid_->Publish(MapOfGround(scene, TallestOnGround(scene))));
  publish("map_point_cloud", cloud_->Publish(CloudOfSurfaces(scene)));
}

void WorldRobots::SetOdometry(std::size_t robot, const std::string& text) {
  const auto fault = OdometryFaultFrom(text);
  if (!fault) return log_(world_.scene().robots[robot].name + ": " + fault.error().message);
  outlets_[robot].fault = fault.value();
  outlets_[robot].frozen.reset();
}

msg::Odometry WorldRobots::OdometryOf(std::size_t robot) {
  Outlet& outlet = outlets_[robot];
  msg::Odometry odometry = OdometryOfRobot(world_, robot);
  odometry.pose.pose.position.x += outlet.fault.off_m.x();
  odometry.pose.pose.position.y += outlet.fault.off_m.y();
  if (!outlet.fault.freezes) return odometry;
  if (!outlet.frozen) outlet.frozen = odometry.pose.pose;
  odometry.pose.pose = *outlet.frozen;
  return odometry;
}

// A refusal is logged once until a command is accepted.
void WorldRobots::Drive(std::size_t robot, const BodyVelocity& velocity) {
  const auto refused = world_.Drive(robot, velocity);
  std::string& last = outlets_[robot].refused;
  if (refused && last != *refused) log_(world_.scene().robots[robot].name + ": " + *refused);
  last = refused.value_or("");
}

void WorldRobots::OnStep() {
  const Scene& scene = world_.scene();
  const Duration now = world_.now();
  // The next ones follow soon.
  for (std::size_t i = 0; i < outlets_.size(); ++i) {
    const Outlet& outlet = outlets_[i];
    static_cast<void>(outlet.odometry->Publish(OdometryOf(i)));
    if (outlet.scan != nullptr && IsDue(now, scene.robots[i].lidar.reach.rate_hz) &&
        outlet.scan->MatchedReaders() > 0) {
      static_cast<void>(outlet.scan->Publish(MeasureRobotScan(world_, i)));
    }
    if (outlet.range_down != nullptr && IsDue(now, scene.robots[i].range_down->reach.rate_hz) &&
        outlet.range_down->MatchedReaders() > 0) {
      static_cast<void>(outlet.range_down->Publish(MeasureRobotRange(world_, i)));
    }
    if (IsDue(now, kObjectsHz) && outlet.in_sight->MatchedReaders() > 0) {
      static_cast<void>(outlet.in_sight->Publish(ObjectsInSightOf(world_, i)));
    }
    if (outlet.detections != nullptr && IsDue(now, scene.robots[i].detector->rate_hz) &&
        outlet.detections->MatchedReaders() > 0) {
      static_cast<void>(outlet.detections->Publish(DetectionsOf(world_, i)));
    }
    if (outlet.lines != nullptr && IsDue(now, kObjectsHz)) {
      static_cast<void>(outlet.lines->Publish(LinesInView(world_, i)));
    }
    if (!IsDue(now, kBatteryHz) && now != kStep) continue;
    const Battery& battery = world_.fleet().robots()[i].battery;
    static_cast<void>(
        outlet.battery->Publish(ToBatteryState(battery, scene.robots[i].battery, now)));
  }
  for (std::size_t i = 0; i < mover_odometry_.size(); ++i) {
    if (mover_odometry_[i] != nullptr) {
      static_cast<void>(mover_odometry_[i]->Publish(OdometryOfMover(world_, i)));
    }
  }
  if (objects_ != nullptr && IsDue(now, kObjectsHz)) {
    static_cast<void>(objects_->Publish(ToObjectStates(world_)));
  }
}

}  // namespace musher::world
