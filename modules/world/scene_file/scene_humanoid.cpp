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

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using keys::Set;

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
    reader.Require("name", "what it is called by");
    if (const auto name = reader.String("name")) AddName(reader, *name, pose);
    for (const auto& name : reader.Strings("also").value_or(std::vector<config_toml::Word>())) {
      AddName(reader, name, pose);
    }
    keys::Section(reader, "angles_deg", findings_, [&](TableReader& angles) {
      for (std::size_t i = 0; i < kJoints; ++i) ReadAngle(angles, i, pose);
    });
    keys::Each(reader, "swing", findings_, [&](TableReader& swing) { ReadSwing(swing, pose); });
    for (const auto& [key, side] : {std::pair("hand_l", 0U), std::pair("hand_r", 1U)}) {
      Set(pose.hands[side], reader.Choice<HandShape>(key, {{"open", HandShape::kOpen},
                                                           {"curled", HandShape::kCurled},
                                                           {"fist", HandShape::kFist},
                                                           {"v", HandShape::kV},
                                                           {"thumb", HandShape::kThumb}}));
    }
    poses_.push_back(std::move(pose));
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
    reader.Require("joint", "the name of a joint");
    reader.Require("amplitude_deg", "to either side");
    reader.Require("period_s", "a time");
    const double amplitude_deg = reader.Number("amplitude_deg", 0, kMostAmplitudeDeg).value_or(0);
    swing.amplitude_rad = amplitude_deg * M_PI / 180;
    Set(swing.period_s, reader.Number("period_s", 0.1, 60));
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

void ReadLimits(TableReader& reader, HumanoidSpec& spec) {
  const std::pair<std::string, JointGroup> groups[] = {{"leg", JointGroup::kLeg},
                                                       {"waist", JointGroup::kWaist},
                                                       {"arm", JointGroup::kArm},
                                                       {"head", JointGroup::kHead}};
  for (const auto& [name, group] : groups) {
    MotionLimits& limits = spec.limits[static_cast<std::size_t>(group)];
    Set(limits.speed_rad_s, reader.Number(name + "_speed_rad_s", 0.01, kMostJointSpeed));
    Set(limits.acceleration_rad_s2,
        reader.Number(name + "_acceleration_rad_s2", 0.01, kMostAcceleration));
  }
}

}  // namespace

std::optional<HumanoidSpec> ReadHumanoid(TableReader& root, const std::string& folder,
                                         Findings& findings) {
  std::optional<HumanoidSpec> humanoid;
  keys::Section(root, "humanoid", findings, [&](TableReader& reader) {
    HumanoidSpec& spec = humanoid.emplace();
    ReadLimits(reader, spec);
    Set(spec.head_yaw_rad, keys::Angle(reader, "head_yaw_deg", 0, kWidestYawDeg));
    Set(spec.waist_yaw_rad, keys::Angle(reader, "waist_yaw_deg", 0, kWidestYawDeg));
    Set(spec.pitch_rad, keys::Angle(reader, "pitch_deg", 0, kWidestPitchDeg));
    if (const auto file = reader.String("poses")) {
      spec.poses_file = config_toml::Absolute(folder, file->text);
    }
    const std::pair<std::string_view, std::string*> topics[] = {
        {"pose_topic", &spec.pose_topic},
        {"look_at_topic", &spec.look_at_topic},
        {"joint_states_topic", &spec.joint_states_topic},
        {"joint_commands_topic", &spec.joint_commands_topic}};
    for (const auto& [key, topic] : topics) Set(*topic, keys::Topic(reader, key));
  });
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
