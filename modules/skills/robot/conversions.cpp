#include "musher/modules/skills/robot/conversions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"

namespace musher::skills {
namespace {

double FiniteOr0(double number) {
  return std::isfinite(number) ? number : 0;
}

struct Layout {
  std::size_t channels = 0;
  bool red_first = false;
};

std::optional<Layout> LayoutOf(const std::string& encoding) {
  if (encoding == "bgr8") return Layout{3, false};
  if (encoding == "rgb8") return Layout{3, true};
  if (encoding == "bgra8") return Layout{4, false};
  if (encoding == "rgba8") return Layout{4, true};
  if (encoding == "mono8") return Layout{1, false};
  return std::nullopt;
}

// " (code 100): the server's own words".
std::string CodeAndWords(std::uint16_t error_code, const std::string& words) {
  constexpr std::size_t kLongest = 200;
  return " (code " + std::to_string(error_code) + ")" +
         (words.empty() ? "" : ": " + words.substr(0, kLongest));
}

}  // namespace

std::optional<navigation::Pose> ToPose(const msg::Pose& pose) {
  const msg::Quaternion& q = pose.orientation;
  const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
  if (!std::isfinite(length) || length < 1e-6) return std::nullopt;
  const navigation::Pose converted{{pose.position.x, pose.position.y, pose.position.z},
                                   msg::YawOf(q)};
  if (!navigation::IsFinite(converted)) return std::nullopt;
  return converted;
}

msg::PoseStamped ToMessage(const navigation::Pose& pose, const msg::Stamp& stamp) {
  msg::PoseStamped message;
  message.header = {stamp, kMapFrame};
  message.pose.position = {pose.at.x_m, pose.at.y_m, pose.at.z_m};
  message.pose.orientation = msg::FromYaw(pose.yaw_rad);
  return message;
}

Result<navigation::Path> ToPath(const msg::Path& path, const PlaceOfFrame& in_map) {
  const auto frame = in_map(path.header.frame_id);
  if (!frame) return frame.error();
  const Error no_path{kCodeFailed, "it is empty or not finite"};
  navigation::Path converted;
  for (const msg::PoseStamped& stamped : path.poses) {
    const auto pose = ToPose(stamped.pose);
    if (!pose) return no_path;
    converted.push_back(navigation::PlacedAt(frame.value(), *pose));
  }
  if (converted.empty()) return no_path;
  return converted;
}

msg::Path ToMessage(const navigation::Path& path, const msg::Stamp& stamp) {
  msg::Path message;
  message.header = {stamp, kMapFrame};
  for (const navigation::Pose& pose : path) message.poses.push_back(ToMessage(pose, stamp));
  return message;
}

std::optional<navigation::RobotIntent> ToIntent(const msg::RobotPath& path) {
  const auto pose = ToPose(path.pose);
  const std::string& frame = path.header.frame_id;
  if (!pose || (!frame.empty() && frame != kMapFrame)) return std::nullopt;
  navigation::RobotIntent intent;
  intent.robot = path.robot;
  intent.priority = path.priority;
  intent.radius_m = path.radius_m;
  intent.flies = path.flies;
  intent.cornered = path.cornered;
  intent.at = pose->at;
  for (const msg::Point& at : path.path) intent.path.push_back({at.x, at.y, at.z});
  return intent;
}

msg::RobotPath ToMessage(const navigation::RobotIntent& intent, const msg::Stamp& stamp) {
  msg::RobotPath message;
  message.header = {stamp, kMapFrame};
  message.robot = intent.robot;
  message.priority = intent.priority;
  message.flies = intent.flies;
  message.cornered = intent.cornered;
  message.radius_m = static_cast<float>(intent.radius_m);
  message.pose = ToMessage(navigation::Pose{intent.at, 0}, stamp).pose;
  for (const navigation::Point& at : intent.path) {
    message.path.push_back({at.x_m, at.y_m, at.z_m});
  }
  return message;
}

navigation::Velocity ToMapFrame(const msg::Twist& twist, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const double x = FiniteOr0(twist.linear.x), y = FiniteOr0(twist.linear.y);
  return {c * x - s * y, s * x + c * y, FiniteOr0(twist.linear.z), FiniteOr0(twist.angular.z)};
}

msg::Twist ToMessage(const navigation::Velocity& command) {
  msg::Twist twist;
  twist.linear = {FiniteOr0(command.x_m_s), FiniteOr0(command.y_m_s), FiniteOr0(command.z_m_s)};
  twist.angular.z = FiniteOr0(command.yaw_rad_s);
  return twist;
}

navigation::Scan ToScan(const msg::LaserScan& scan) {
  return {scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.ranges};
}

navigation::DownReading ToReading(const msg::Range& range) {
  return {range.range, range.min_range, range.max_range, range.field_of_view};
}

Result<Picture> ToPicture(const msg::Image& image) {
  const auto layout = LayoutOf(image.encoding);
  if (!layout) {
    return Error{kCodeParametersInvalid, "a picture's encoding is '" +
                                             image.encoding.substr(0, 20) +
                                             "'; expected bgr8, rgb8, bgra8, rgba8 or mono8"};
  }
  const std::uint64_t row = std::uint64_t{image.width} * layout->channels;
  if (image.width == 0 || image.height == 0 || image.step < row ||
      image.data.size() < std::uint64_t{image.step} * image.height) {
    return Error{kCodeParametersInvalid, "a picture has fewer bytes than its size needs"};
  }
  Picture picture{image.width, image.height, {}};
  picture.bgr.reserve(std::size_t{image.width} * image.height * 3);
  for (std::size_t y = 0; y < image.height; ++y) {
    const std::uint8_t* pixel = image.data.data() + y * image.step;
    for (std::size_t x = 0; x < image.width; ++x, pixel += layout->channels) {
      if (layout->channels == 1) {
        picture.bgr.insert(picture.bgr.end(), 3, pixel[0]);
      } else if (layout->red_first) {
        picture.bgr.insert(picture.bgr.end(), {pixel[2], pixel[1], pixel[0]});
      } else {
        picture.bgr.insert(picture.bgr.end(), pixel, pixel + 3);
      }
    }
  }
  return picture;
}

std::vector<SeenObject> ToObjects(const msg::ObjectStates& states, const navigation::Pose& frame) {
  std::vector<SeenObject> objects;
  for (const msg::ObjectState& state : states.objects) {
    const auto pose = ToPose(state.pose);
    if (!pose) continue;
    objects.push_back(
        {state.name, state.category, navigation::PlacedAt(frame, *pose), state.held_by});
  }
  return objects;
}

std::optional<SeenObject> ToObject(const msg::Sighting& sighting, const DetectorView& view,
                                   const navigation::Pose& body) {
  const double x = sighting.x;
  const double width = sighting.width;
  const bool in_picture = width > 0 && x + width > 0 && x < 1;  // false for NaN, too
  if (!sighting.seen || !in_picture) return std::nullopt;
  // The picture as a plane at distance 1, whose half is as wide as this.
  const double half = std::tan(view.fov_rad / 2);
  const double left = (1 - 2 * (x + width / 2)) * half;
  const double known_m = sighting.distance_m;
  const double ahead_m = view.width_m / (2 * half * width);
  const double distance_m = known_m > 0 ? known_m : ahead_m * std::hypot(1, left);
  if (!std::isfinite(distance_m)) return std::nullopt;
  const double bearing_rad = body.yaw_rad + view.camera.yaw_rad + std::atan(left);
  const double cos = std::cos(body.yaw_rad);
  const double sin = std::sin(body.yaw_rad);
  const navigation::Point& camera = view.camera.at;
  const navigation::Point at{
      body.at.x_m + cos * camera.x_m - sin * camera.y_m + distance_m * std::cos(bearing_rad),
      body.at.y_m + sin * camera.x_m + cos * camera.y_m + distance_m * std::sin(bearing_rad),
      body.at.z_m + camera.z_m};
  return SeenObject{sighting.text.empty() ? view.name : sighting.text, view.name, {at, 0}, ""};
}

std::optional<Robot::Line> ToLine(const msg::YellowLines& lines, const LineView& view) {
  const bool seen = lines.contours > 0 && lines.doubt.empty();
  if (!seen || !std::isfinite(lines.middle_offset)) return std::nullopt;
  Robot::Line line{-double{lines.middle_offset} * view.width_m, 0};
  // The edge from its lowest to its highest point; shares of the picture, y downwards.
  const std::size_t count = std::min(lines.edge_x.size(), lines.edge_y.size());
  std::optional<std::size_t> low, high;
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(lines.edge_x[i]) || !std::isfinite(lines.edge_y[i])) continue;
    if (!low || lines.edge_y[i] > lines.edge_y[*low]) low = i;
    if (!high || lines.edge_y[i] < lines.edge_y[*high]) high = i;
  }
  if (!low || *low == *high) return line;
  const double ahead_m = double{lines.edge_y[*low] - lines.edge_y[*high]} * view.depth_m;
  const double right_m = double{lines.edge_x[*high] - lines.edge_x[*low]} * view.width_m;
  if (ahead_m > 0) line.heading_rad = std::atan2(-right_m, ahead_m);
  return line;
}

msg::ManipulationControl::Request ToMessage(const HandRequest& request) {
  return {static_cast<std::uint8_t>(request.action),
          request.object,
          request.distance_threshold_m,
          {request.target.x_m, request.target.y_m, request.target.z_m}};
}

Error PlannerError(std::uint16_t error_code, const navigation::Pose& goal,
                   const std::optional<navigation::Pose>& start, const std::string& words) {
  using Code = msg::ComputePathToPose;
  using navigation::Fault;
  using navigation::MakeError;
  const auto place = [](const navigation::Point& at) {
    return navigation::PlaceText(at, at.z_m == 0);
  };
  constexpr std::size_t kLongest = 200;
  const std::string said = words.substr(0, kLongest);
  const std::string to = "the goal " + place(goal.at);
  const std::string from =
      start ? "the start " + place(start->at) : "the start, the robot's place,";
  switch (error_code) {
    case Code::kInvalidPlanner:
      return MakeError(Fault::kIdentifier, "the planner has no such planner_id");
    case Code::kTfError:
      return MakeError(Fault::kOdometry,
                       said.empty() ? "the planner does not know where the robot is" : said);
    case Code::kUnknown:  // no map yet; not Active any more; a newer goal: it may take the next one
      return {kCodeStateInvalid, said.empty() ? "the planner has failed" : said};
    case Code::kStartOutsideMap:
      return MakeError(Fault::kOutside, from + " is outside the map");
    case Code::kGoalOutsideMap:
      return MakeError(Fault::kGoalOutside,
                       to + (goal.at.z_m == 0 ? " is outside the map"
                                              : " is outside the map, or above the ceiling"));
    case Code::kStartOccupied:
      return MakeError(Fault::kStartBlocked,
                       from + " has no room for the robot: an obstacle is too near");
    case Code::kGoalOccupied:
      return MakeError(Fault::kGoalBlocked,
                       to + " has no room for the robot: an obstacle is too near");
    case Code::kTimeout:
      return MakeError(Fault::kTimeLimit, "the planner found no path to " + to + " in its time");
    case Code::kNoValidPath:
      return MakeError(Fault::kWalledIn, "no path is wide enough for the robot: " + to +
                                             " or the start is walled in");
    default:
      return {kCodeFailed, "the planner has failed" + CodeAndWords(error_code, words)};
  }
}

Error ControllerError(std::uint16_t error_code, const std::string& words) {
  using Code = msg::FollowPath;
  using navigation::Fault;
  // The controller knows more than its code says.
  const auto fault_of = [&words](Fault fault, const char* text) {
    constexpr std::size_t kLongest = 200;
    return navigation::MakeError(fault, words.empty() ? text : words.substr(0, kLongest));
  };
  switch (error_code) {
    case Code::kInvalidController:
      return navigation::MakeError(Fault::kIdentifier, "the controller has no such controller_id");
    case Code::kTfError:
      return fault_of(Fault::kOdometry,
                      "its odometry is lost, has jumped, or is in another frame than the path");
    case Code::kInvalidPath:
      return navigation::MakeError(Fault::kInput, "the controller refuses the path");
    case Code::kPatienceExceeded:
      return fault_of(Fault::kObstacle, "an obstacle stays in the way");
    case Code::kFailedToMakeProgress:
      return fault_of(Fault::kLate,
                      "the robot did not arrive in time, or did not move as it was commanded");
    case Code::kNoValidControl:
      return fault_of(Fault::kScan, "its scan is lost");
    case Code::kControllerTimedOut:
      return navigation::MakeError(Fault::kTimeLimit,
                                   "the controller has not answered its server in time");
    default:
      return Error{kCodeFailed, "the controller has failed" + CodeAndWords(error_code, words)};
  }
}

}  // namespace musher::skills
