#include "musher/modules/world/scene_file/scene_humanoid.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr double kMostJointSpeed = 20;     // rad/s
constexpr double kMostAcceleration = 200;  // rad/s^2
constexpr double kWidestYawDeg = 90;
constexpr double kWidestPitchDeg = 45;

constexpr std::string_view kGazeJoints = "the gaze moves waist and head, a pose does not";

bool IsOfGaze(std::size_t joint) {
  return joint == kWaistYaw || joint == kHeadYaw;
}

class PoseReader {
 public:
  explicit PoseReader(Findings& findings) : findings_(findings) {}

  std::vector<PoseSpec> Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    keys::Each(root, "pose", findings_, [&](TableReader& reader) { ReadPose(reader); });
    root.RefuseOthers();
    if (!taken_.contains(std::string(kNeutralPose))) {
      findings_.Error({1, 1}, "expected a pose \"neutral\": it is the one to begin with");
    }
    return std::move(poses_);
  }

 private:
  void ReadPose(TableReader& reader) {
    PoseSpec pose;
    const auto read_names = [&](TableReader& table) {
      table.Require("name", "what it is called by");
      if (const auto name = table.String("name")) AddName(table, *name, pose);
      for (const auto& name : table.Strings("also").value_or(std::vector<config_toml::Word>())) {
        AddName(table, name, pose);
      }
    };
    const auto read_swings = [&](TableReader& table) {
      keys::Each(table, "swing", findings_, [&](TableReader& swing) { ReadSwing(swing, pose); });
    };
    keys::ReadSome(reader, {read_names, row::Sub("angles_deg", AngleRows(pose)), read_swings,
                            HandRow("hand_l", pose.hands[0]), HandRow("hand_r", pose.hands[1])});
    poses_.push_back(std::move(pose));
  }

  static Row HandRow(std::string_view key, HandShape& hand) {
    return row::Choice(key, hand,
                       {{"open", HandShape::kOpen},
                        {"curled", HandShape::kCurled},
                        {"fist", HandShape::kFist},
                        {"v", HandShape::kV},
                        {"thumb", HandShape::kThumb}});
  }

  static Rows AngleRows(PoseSpec& pose) {
    Rows rows;
    for (std::size_t i = 0; i < kJoints; ++i) {
      rows.push_back([i, &pose](TableReader& angles) { ReadAngle(angles, i, pose); });
    }
    return rows;
  }

  void AddName(TableReader& reader, const config_toml::Word& name, PoseSpec& pose) {
    if (name.text.empty() || !taken_.insert(name.text).second) {
      reader.Fault(
          name.at, "name",
          "expected a name that no other pose has, found " + config_toml::Quote(name.text));
    }
    pose.names.push_back(name.text);
  }

  static void ReadAngle(TableReader& reader, std::size_t index, PoseSpec& pose) {
    const Joint& joint = JointTable()[index];
    if (IsOfGaze(index)) {
      if (reader.Has(joint.name)) reader.Fault(reader.At(joint.name), joint.name, kGazeJoints);
      return;
    }
    const auto degrees = reader.Number(joint.name, std::floor(joint.least_rad * 180 / M_PI),
                                       std::ceil(joint.most_rad * 180 / M_PI));
    if (degrees) {
      pose.angles[index] = std::clamp(*degrees * M_PI / 180, joint.least_rad, joint.most_rad);
    }
  }

  void ReadSwing(TableReader& reader, PoseSpec& pose) {
    constexpr double kMostAmplitudeDeg = 90;
    Swing swing;
    swing.amplitude_rad = 0;
    reader.Require("joint", "the name of a joint");
    keys::ReadSome(
        reader,
        {row::Required("amplitude_deg", "to either side",
                       row::Degrees("amplitude_deg", swing.amplitude_rad, 0, kMostAmplitudeDeg)),
         row::Required("period_s", "a time", row::Number("period_s", swing.period_s, 0.1, 60))});
    std::vector<std::pair<std::string_view, std::size_t>> joints;
    for (std::size_t i = 0; i < kJoints; ++i) joints.emplace_back(JointTable()[i].name, i);
    const auto joint = reader.Choice("joint", joints);
    if (!joint) return;
    swing.joint = *joint;
    const Joint& limits = JointTable()[*joint];
    const double middle = pose.angles[*joint];
    if (IsOfGaze(*joint)) {
      reader.Fault(reader.At("joint"), "joint", kGazeJoints);
    } else if (middle - swing.amplitude_rad < limits.least_rad ||
               middle + swing.amplitude_rad > limits.most_rad) {
      reader.Fault(reader.At("amplitude_deg"), "amplitude_deg",
                   "expected less: the joint cannot go so far from its angle in this pose");
    }
    pose.swings.push_back(swing);
  }

  Findings& findings_;
  std::vector<PoseSpec> poses_;
  std::set<std::string> taken_;
};

// Of the joints whose keys begin with `group`.
Row LimitsRow(std::string group, MotionLimits& limits) {
  return [group = std::move(group), &limits](TableReader& reader) {
    row::Number(group + "_speed_rad_s", limits.speed_rad_s, 0.01, kMostJointSpeed)(reader);
    row::Number(group + "_acceleration_rad_s2", limits.acceleration_rad_s2, 0.01,
                kMostAcceleration)(reader);
  };
}

Rows HumanoidRows(HumanoidSpec& spec, const std::string& folder) {
  const auto limits = [&](const char* name, JointGroup group) {
    return LimitsRow(name, spec.limits[static_cast<std::size_t>(group)]);
  };
  return {
      limits("leg", JointGroup::kLeg),
      limits("waist", JointGroup::kWaist),
      limits("arm", JointGroup::kArm),
      limits("head", JointGroup::kHead),
      keys::Angle("head_yaw_deg", spec.head_yaw_rad, 0, kWidestYawDeg),
      keys::Angle("waist_yaw_deg", spec.waist_yaw_rad, 0, kWidestYawDeg),
      keys::Angle("pitch_deg", spec.pitch_rad, 0, kWidestPitchDeg),
      row::File("poses", spec.poses_file, folder),
      keys::Topic("pose_topic", spec.pose_topic),
      keys::Topic("look_at_topic", spec.look_at_topic),
      keys::Topic("joint_states_topic", spec.joint_states_topic),
      keys::Topic("joint_commands_topic", spec.joint_commands_topic),
  };
}

}  // namespace

std::optional<HumanoidSpec> ReadHumanoid(TableReader& root, const std::string& folder) {
  auto reader = root.Sub("humanoid");
  if (!reader) return std::nullopt;
  HumanoidSpec humanoid;
  ReadRows(*reader, HumanoidRows(humanoid, folder));
  return humanoid;
}

PosesReading ReadPosesText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<PosesReading>(
      text, path,
      [](const Table& root, Findings& findings) { return PoseReader(findings).Read(root); });
}

PosesReading ReadPosesFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPosesText);
}

}  // namespace musher::world
