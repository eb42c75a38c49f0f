#include "musher/test/modules/navigation/simulated_robot.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/messages/stamp.hpp"

namespace musher::navigation::testing {
namespace {

constexpr double kMoveS = 0.01;
constexpr int kScanRays = 180;
constexpr double kBodyRadiusM = 0.2;
constexpr double kRangeM = 8;
constexpr Duration kDeadMan = Milliseconds(500);

}  // namespace

msg::PoseStamped At(double x_m, double y_m, double yaw_rad, double z_m) {
  msg::PoseStamped pose;
  pose.header.frame_id = "map";
  pose.pose = ToMessage(Pose{{x_m, y_m, z_m}, yaw_rad});
  return pose;
}

msg::OccupancyGrid GridOf(const CellMap& map) {
  msg::OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = static_cast<float>(map.resolution_m);
  grid.info.width = static_cast<std::uint32_t>(map.size_x);
  grid.info.height = static_cast<std::uint32_t>(map.size_y);
  grid.info.origin = ToMessage(map.origin);
  for (const std::uint8_t blocked : map.blocked) {
    grid.data.push_back(static_cast<std::int8_t>(blocked ? 100 : 0));
  }
  return grid;
}

SimulatedRobot::SimulatedRobot(transport::Node& node, const Clearance& walls,
                               const Options& options)
    : node_(node), walls_(walls), options_(options), pose_(options.start) {
  const std::string& name = options.name;
  odometry_ = transport::MakePublisher<msg::Odometry>(node, name + "/odom").value();
  scan_ = transport::MakePublisher<msg::LaserScan>(node, name + "/scan").value();
  commands_in_ = transport::MakeSubscription<msg::Twist>(
                     node, name + "/cmd_vel",
                     [this](const msg::Twist& twist, const auto&) { OnCommand(twist); })
                     .value();
  transport::EventLoop& loop = node.loop();
  timers_.push_back(loop.Every(Milliseconds(10), [this] { Move(); }));
  timers_.push_back(loop.Every(Milliseconds(20), [this] { SendOdometry(); }));
  timers_.push_back(loop.Every(Milliseconds(100), [this] { SendScan(); }));
}

void SimulatedRobot::OnCommand(const msg::Twist& twist) {
  const double before_m_s = std::hypot(command_.linear.x, command_.linear.y, command_.linear.z);
  const double after_m_s = std::hypot(twist.linear.x, twist.linear.y, twist.linear.z);
  if (commands_ > 0) {
    hardest_m_s2_ = std::max(hardest_m_s2_, std::abs(after_m_s - before_m_s) * 60);
  }
  command_ = twist;
  command_at_ = node_.loop().Now();
  ++commands_;
  zeros_ += twist == msg::Twist{} ? 1 : 0;
}

void SimulatedRobot::Move() {
  if (node_.loop().Now() - command_at_ > kDeadMan) command_ = {};
  const double aside_m_s = options_.differential ? 0 : command_.linear.y;
  const Velocity body{command_.linear.x, aside_m_s, command_.linear.z, command_.angular.z};
  const Velocity wanted = InBodyFrame(body, -pose_.yaw_rad);
  const double share = options_.lag_s > 0 ? 1 - std::exp(-kMoveS / options_.lag_s) : 1;
  velocity_.x_m_s += share * (wanted.x_m_s - velocity_.x_m_s);
  velocity_.y_m_s += share * (wanted.y_m_s - velocity_.y_m_s);
  velocity_.z_m_s += share * (wanted.z_m_s - velocity_.z_m_s);
  velocity_.yaw_rad_s += share * (wanted.yaw_rad_s - velocity_.yaw_rad_s);
  if (stuck) velocity_ = {};
  const double moved_s = slips * kMoveS;
  pose_.at.x_m += velocity_.x_m_s * moved_s;
  pose_.at.y_m += velocity_.y_m_s * moved_s;
  pose_.at.z_m += velocity_.z_m_s * moved_s;
  pose_.yaw_rad = Wrapped(pose_.yaw_rad + velocity_.yaw_rad_s * moved_s);
  if (walls_.map().flat()) {
    least_room_m_ = std::min(least_room_m_, walls_.At(pose_.at, 2) - kBodyRadiusM);
  }
}

msg::Header SimulatedRobot::HeaderNow() const {
  msg::Header header;
  header.stamp = msg::ToStamp(node_.loop().Now().time_since_epoch());
  header.frame_id = "map";
  return header;
}

void SimulatedRobot::SendOdometry() {
  if (odometry_silent) return;
  msg::Odometry odometry;
  odometry.header = HeaderNow();
  odometry.header.frame_id = odometry_frame;
  odometry.child_frame_id = options_.name;
  Pose believed = pose_;
  believed.at = {pose_.at.x_m + odometry_off.x_m, pose_.at.y_m + odometry_off.y_m,
                 pose_.at.z_m + odometry_off.z_m};
  odometry.pose.pose = ToMessage(believed);
  const Velocity body = InBodyFrame(velocity_, pose_.yaw_rad);
  odometry.twist.twist.linear = {body.x_m_s, body.y_m_s, body.z_m_s};
  odometry.twist.twist.angular.z = body.yaw_rad_s;
  if (odometry_frozen || stamps_stand) {
    const msg::Header header = stamps_stand ? last_odometry_.header : odometry.header;
    odometry = last_odometry_;
    odometry.header = header;
  }
  last_odometry_ = odometry;
  static_cast<void>(odometry_->Publish(odometry));
}

double SimulatedRobot::RangeAt(double angle_rad) const {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  double range_m = kRangeM;
  for (const Disc& disc : discs) {
    const double x = disc.at.x_m - pose_.at.x_m, y = disc.at.y_m - pose_.at.y_m;
    const double along = x * c + y * s;
    const double square = disc.radius_m * disc.radius_m - (x * x + y * y - along * along);
    if (along > 0 && square >= 0) range_m = std::min(range_m, along - std::sqrt(square));
  }
  const CellMap& map = walls_.map();
  for (double at_m = 0; map.flat() && at_m < range_m; at_m += map.resolution_m / 4) {
    const Cell cell = map.CellOf({pose_.at.x_m + at_m * c, pose_.at.y_m + at_m * s, 0});
    if (!map.Has(cell) || map.blocked[map.IndexOf(cell)]) return at_m;
  }
  return range_m;
}

void SimulatedRobot::SendScan() {
  if (scan_silent) return;
  msg::LaserScan scan;
  scan.header = HeaderNow();
  scan.angle_min = static_cast<float>(-M_PI);
  scan.angle_increment = static_cast<float>(2 * M_PI / kScanRays);
  scan.angle_max = scan.angle_min + 2 * static_cast<float>(M_PI);
  scan.range_min = 0.05F;
  scan.range_max = static_cast<float>(kRangeM) - 0.01F;
  for (int i = 0; i < kScanRays; ++i) {
    const double angle_rad = pose_.yaw_rad + scan.angle_min + i * (2 * M_PI / kScanRays);
    scan.ranges.push_back(static_cast<float>(RangeAt(angle_rad)));
  }
  const Time now = node_.loop().Now();
  taken_.emplace_back(now, std::move(scan));
  while (!taken_.empty() && taken_.front().first <= now - scan_late) {
    static_cast<void>(scan_->Publish(taken_.front().second));
    taken_.pop_front();
  }
}

}  // namespace musher::navigation::testing
