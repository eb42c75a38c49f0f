#pragma once
// The messages of a robot as the values of its port (robot.hpp), and back. Plain functions, any
// thread. Messages come from outside: what is not finite, too short or too long is refused.
//
// Frames: poses in the map; twists of messages in the body's frame, x forward, y to the left.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/musher_msgs/robot_path.hpp"
#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/path.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"
#include "musher/navigation/gate/descent_watch.hpp"

namespace musher::skills {

inline constexpr const char* kMapFrame = "map";

// Nullopt: a number is not finite, or the quaternion has no length.
std::optional<navigation::Pose> ToPose(const msg::Pose& pose);
msg::PoseStamped ToMessage(const navigation::Pose& pose, const msg::Stamp& stamp);

// Where the frame of a message is in the map. Fails with the reason where that is not known.
using PlaceOfFrame = std::function<Result<navigation::Pose>(const std::string& frame)>;

// In the map. Fails for a path without poses, with one that is not finite, or in a frame without a
// place in the map.
Result<navigation::Path> ToPath(const msg::Path& path, const PlaceOfFrame& in_map);
msg::Path ToMessage(const navigation::Path& path, const msg::Stamp& stamp);

// Nullopt: another frame than the map's, or a pose that is not finite.
std::optional<navigation::RobotIntent> ToIntent(const msg::RobotPath& path);
msg::RobotPath ToMessage(const navigation::RobotIntent& intent, const msg::Stamp& stamp);

navigation::Velocity ToMapFrame(const msg::Twist& twist, double yaw_rad);
// Numbers that are not finite become 0.
msg::Twist ToMessage(const navigation::Velocity& command);

navigation::Scan ToScan(const msg::LaserScan& scan);
navigation::DownReading ToReading(const msg::Range& range);

// bgr8, rgb8, bgra8, rgba8 and mono8.
Result<Picture> ToPicture(const msg::Image& image);

// Objects whose pose is not finite are left out. `frame`: of the message, in the map.
std::vector<SeenObject> ToObjects(const msg::ObjectStates& states, const navigation::Pose& frame);

// What a detector has seen, with its name where it has no text. Its place in the map: from the
// middle of its box, and from the distance that the detector knows, else from the share of the
// picture that it fills; its height is that of the camera. `body`: where the picture was taken.
// Nullopt: it has seen nothing, or its numbers are none of a picture.
std::optional<SeenObject> ToObject(const msg::Sighting& sighting, const DetectorView& view,
                                   const navigation::Pose& body);

// Nullopt: no line is seen.
std::optional<Robot::Line> ToLine(const msg::YellowLines& lines, const LineView& view);

msg::ManipulationControl::Request ToMessage(const HandRequest& request);

// Why a planner has found no path, from the code of its result, else with its own `words`. With the
// code of the planner's fault, where it is one. Without a start: where the robot is.
Error PlannerError(std::uint16_t error_code, const navigation::Pose& goal,
                   const std::optional<navigation::Pose>& start, const std::string& words = "");
// With the code of navigation::Fault::kObstacle where an obstacle is in the way: another path may
// help.
Error ControllerError(std::uint16_t error_code, const std::string& words = "");

}  // namespace musher::skills
