#include "musher/modules/motion/user_gait.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr int kWalkMode = 11;
constexpr std::int8_t kUserGaitNumber = 110;  // of modes 11 and 62
constexpr std::int64_t kLongestGaitMs = 600'000;
constexpr double kFastest = 1.6;                                 // m/s
constexpr double kFastestTurn = 2.5;                             // rad/s
constexpr SpeedLimit kLimitOfSequences = {0.65F, 0.30F, 1.25F};  // of a motion without its own
constexpr double kHighestStep = 0.08;                            // m
constexpr double kMostLandingGain = 12;                          // ten times it is an int8
constexpr double kFarthest = 1;                                  // m, of the body and a foot
constexpr double kMostWeight = 1000;
constexpr const char* kFootNames = "front right, front left, rear right, rear left";

Error GaitError(const std::string& why) {
  return {MotionCode(MotionKey::kSequenceDefinition), why};
}

struct Section {
  std::array<bool, 4> stands{};  // front right, front left, rear right, rear left
  std::int64_t duration = 0;     // in periods of the board's control

  friend bool operator==(const Section&, const Section&) = default;
};

struct Step {
  std::array<double, 3> speed{};        // x, y, yaw
  std::array<double, 6> body{};         // roll, pitch, yaw; x, y, z
  std::array<double, 12> landing{};     // x, y, z of the feet, in the order of Section
  std::array<double, 4> step_height{};  // in the same order
  std::array<double, 6> weight{};
  bool use_mpc_traj = false;
  double friction = 0;
  double landing_gain = 0;
  std::int64_t duration_ms = 0;

  friend bool operator==(const Step&, const Step&) = default;
};

// --- texts for the board ---

std::string Text(double value) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 6);
  std::string result(text.data(), end.ptr);
  result.erase(result.find_last_not_of('0') + 1);
  return result.ends_with('.') ? result + "0" : result;
}

template <typename Values>
std::string ListText(const Values& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + Text(value);
  return "[" + text + "]";
}

std::string TextOf(const std::vector<Section>& sections) {
  std::string text = "# Gait Def\n";
  for (const Section& section : sections) {
    std::string contact;
    for (const bool stands : section.stands) {
      contact += std::string(contact.empty() ? "" : ", ") + (stands ? "1" : "0");
    }
    text += "[[section]]\ncontact = [" + contact +
            "]\nduration = " + std::to_string(section.duration) + "\n";
  }
  return text;
}

// Two heights in millimetres as one number.
double Packed(double first_m, double second_m) {
  constexpr double kThousand = 1000;
  constexpr double kRounding = 1e-3;  // 0.05F is a little more than 0.05
  const auto millimetres = [&](double m) { return std::ceil(m * kThousand - kRounding); };
  return 0.0 + millimetres(first_m) + millimetres(second_m) * kThousand;  // no -0.0
}

// The inverse, without a remainder.
std::array<double, 2> Unpacked(double packed) {
  constexpr double kThousand = 1000;
  const double millimetres = std::round(packed);
  const double second = std::floor(millimetres / kThousand);
  return {(millimetres - second * kThousand) / kThousand, second / kThousand};
}

// The fields of a robot_control_cmd.
std::string TextOf(const std::vector<Step>& steps) {
  std::string text = "# Gait Params\n";
  for (const Step& step : steps) {
    const auto& b = step.body;
    const auto& l = step.landing;
    const auto& h = step.step_height;
    constexpr double kTen = 10;
    text += "[[step]]\nmode = " + std::to_string(kWalkMode) +
            "\ngait_id = " + std::to_string(kUserGaitNumber) + "\ncontact = " +
            std::to_string(static_cast<int>(std::floor(step.landing_gain * kTen))) +
            "\nlife_count = 0\nvel_des = " + ListText(step.speed) +
            "\nrpy_des = " + ListText(std::array{b[0], b[1], b[2]}) +
            "\npos_des = " + ListText(std::array{b[3], b[4], b[5]}) +
            "\nacc_des = " + ListText(step.weight) +
            "\nctrl_point = " + ListText(std::array{l[9], l[10], step.friction}) +
            "\nfoot_pose = " + ListText(std::array{l[0], l[1], l[3], l[4], l[6], l[7]}) +
            "\nstep_height = " + ListText(std::array{Packed(h[0], h[1]), Packed(h[2], h[3])}) +
            "\nvalue = " + (step.use_mpc_traj ? "1" : "0") +
            "\nduration = " + std::to_string(step.duration_ms) + "\n";
  }
  return text;
}

// --- checks ---

template <typename Values>
bool AreWithin(const Values& values, double most) {
  for (const double value : values) {
    if (!std::isfinite(value) || std::abs(value) > most) return false;
  }
  return true;
}

std::optional<std::string> FaultOf(const Step& step) {
  const auto out = [](const char* what, double most) {
    return std::string(what) + " must be finite and at most " + Text(most);
  };
  if (!AreWithin(std::array{step.speed[0], step.speed[1]}, kFastest)) {
    return out("its speed in x and y", kFastest);
  }
  if (!AreWithin(std::array{step.speed[2]}, kFastestTurn)) return out("its yaw rate", kFastestTurn);
  if (!AreWithin(step.body, kFarthest)) return out("the pose of the body", kFarthest);
  if (!AreWithin(step.landing, kFarthest)) return out("the landing of the feet", kFarthest);
  if (!AreWithin(step.weight, kMostWeight)) return out("a weight", kMostWeight);
  for (const double height : step.step_height) {
    if (!(height >= 0 && height <= kHighestStep)) {
      return "the height of a step must be 0 to " + Text(kHighestStep) + " m";
    }
  }
  if (!(step.friction >= 0 && step.friction <= 1)) return "the friction must be 0 to 1";
  if (!(step.landing_gain >= 0 && step.landing_gain <= kMostLandingGain)) {
    return "the landing gain must be 0 to " + Text(kMostLandingGain);
  }
  if (step.duration_ms <= 0 || step.duration_ms > kLongestGaitMs) {
    return "its duration must be 1 to " + std::to_string(kLongestGaitMs) + " ms, it is " +
           std::to_string(step.duration_ms);
  }
  return std::nullopt;
}

Result<> Check(const std::vector<Section>& sections, const std::vector<Step>& steps) {
  if (sections.empty()) {
    return GaitError(
        "the gait has steps, but no sections that say which feet stand (gait_list, "
        "gait_toml)");
  }
  if (steps.empty()) {
    return GaitError("the gait has feet, but no steps of the body (pace_list, pace_toml)");
  }
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const std::int64_t duration = sections[i].duration;
    if (duration > 0 && duration <= kLongestGaitMs) continue;
    return GaitError("section " + std::to_string(i + 1) +
                     " of the feet: its duration must be more than 0, it is " +
                     std::to_string(duration));
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto fault = FaultOf(steps[i]);
    if (fault) return GaitError("step " + std::to_string(i + 1) + ": " + *fault);
  }
  return Ok();
}

Result<> CheckLength(const std::string& text, const char* what) {
  if (text.size() <= kLongestGaitText) return Ok();
  return Error{MotionCode(KeyCode::kParametersInvalid),
               std::string("the ") + what + " of the gait have " + std::to_string(text.size()) +
                   " bytes; a motion board takes at most " + std::to_string(kLongestGaitText)};
}

// Before the text is written: that of a million sections takes the loop longer than the board waits
// for a frame.
template <typename T>
Result<> CheckCount(const std::vector<T>& items, const char* what) {
  static const std::size_t shortest =
      TextOf(std::vector<T>(2)).size() - TextOf(std::vector<T>(1)).size();
  const std::size_t most = kLongestGaitText / shortest;
  if (items.size() <= most) return Ok();
  return Error{MotionCode(KeyCode::kParametersInvalid),
               "the gait has " + std::to_string(items.size()) + " " + what + ", and at most " +
                   std::to_string(most) + " fit into the text that a motion board takes"};
}

Result<UserGait> Finished(const std::vector<Section>& sections, const std::vector<Step>& steps) {
  if (auto fits = CheckCount(sections, "sections"); !fits) return fits.error();
  if (auto fits = CheckCount(steps, "steps"); !fits) return fits.error();
  if (auto good = Check(sections, steps); !good) return good.error();
  UserGait gait{TextOf(sections), TextOf(steps), 0, {}};
  if (auto fits = CheckLength(gait.sections, "sections"); !fits) return fits.error();
  if (auto fits = CheckLength(gait.steps, "steps"); !fits) return fits.error();
  for (const Step& step : steps) {
    gait.duration_ms += step.duration_ms;
    for (std::size_t i = 0; i < gait.fastest.size(); ++i) {
      gait.fastest[i] = std::max(gait.fastest[i], static_cast<float>(std::abs(step.speed[i])));
    }
  }
  return gait;
}

// --- TOML ---

template <typename T>
struct Reading {
  std::optional<std::vector<T>> value;
  std::vector<Diagnostic> diagnostics;
};

template <std::size_t N>
config_toml::Row NumbersRow(std::string_view key, std::array<double, N>& values,
                            std::string_view expected) {
  std::vector<double*> places;
  for (double& value : values) places.push_back(&value);
  constexpr double kMost = 1e6;
  return row::Required(key, expected, row::Numbers(key, places, -kMost, kMost, expected));
}

void ReadSection(TableReader& reader, std::vector<Section>& sections) {
  Section section;
  const std::string expected = std::string("four numbers 0 or 1: ") + kFootNames;
  reader.Require("contact", expected);
  reader.Require("duration", "periods of the board's control");
  const auto contact = reader.Integers("contact", 0, 1);
  if (contact && contact->size() != section.stands.size()) {
    reader.Fault(reader.At("contact"), "contact", "expected " + expected);
  } else if (contact) {
    for (std::size_t i = 0; i < contact->size(); ++i) section.stands[i] = (*contact)[i] != 0;
  }
  section.duration = reader.Integer("duration", 1, kLongestGaitMs).value_or(0);
  reader.RefuseOthers();
  sections.push_back(section);
}

config_toml::Row Needed(const char* key, config_toml::Row read) {
  return row::Required(key, "a value", std::move(read));
}

// A step as it is written by people.
Step ReadWrittenStep(TableReader& reader) {
  Step step;
  constexpr double kMost = 1e6;
  std::string type;
  std::int64_t gait = kUserGaitNumber;
  config_toml::ReadRows(
      reader,
      {Needed("type", row::Text("type", type)),
       row::Check(
           "type", [&] { return type == "usergait"; }, "expected \"usergait\""),
       NumbersRow("body_vel_des", step.speed, "three numbers: x and y in m/s, yaw in rad/s"),
       NumbersRow("body_pos_des", step.body, "six numbers: roll, pitch, yaw, x, y, z"),
       NumbersRow("landing_pos_des", step.landing, "twelve numbers: x, y, z of each foot"),
       NumbersRow("step_height", step.step_height, "four numbers in m, one for each foot"),
       NumbersRow("weight", step.weight, "six numbers: roll, pitch, yaw, x, y, z"),
       [&](TableReader& r) {
         r.Require("use_mpc_traj", "0 or 1");
         step.use_mpc_traj = r.Integer("use_mpc_traj", 0, 1).value_or(0) != 0;
       },
       Needed("mu", row::Number("mu", step.friction, 0, kMost)),
       Needed("landing_gain", row::Number("landing_gain", step.landing_gain, 0, kMost)),
       row::Integer("gait_id", gait, kUserGaitNumber, kUserGaitNumber),
       Needed("duration", row::Integer("duration", step.duration_ms, 1, kLongestGaitMs, "ms"))});
  return step;
}

// A step as a board takes it, in the fields of a robot_control_cmd: CyberDog's own programs send
// sequences with these.
Step ReadCommandStep(TableReader& reader) {
  Step step;
  constexpr std::int64_t kMostContact = 127;
  std::int64_t mode = 0;
  std::int64_t gait = 0;
  std::int64_t contact = 0;
  std::int64_t life_count = 0;
  std::int64_t value = 0;
  std::array<double, 3> turn{};
  std::array<double, 3> place{};
  std::array<double, 3> point{};
  std::array<double, 6> feet{};
  std::array<double, 2> heights{};
  config_toml::ReadRows(
      reader,
      {Needed("mode", row::Integer("mode", mode, kWalkMode, kWalkMode)),
       Needed("gait_id", row::Integer("gait_id", gait, kUserGaitNumber, kUserGaitNumber)),
       Needed("contact", row::Integer("contact", contact, 0, kMostContact)),
       row::Integer("life_count", life_count, 0, 255),
       NumbersRow("vel_des", step.speed, "three numbers: x and y in m/s, yaw in rad/s"),
       NumbersRow("rpy_des", turn, "three numbers: roll, pitch, yaw"),
       NumbersRow("pos_des", place, "three numbers: x, y, z"),
       NumbersRow("acc_des", step.weight, "six numbers: the weights"),
       NumbersRow("ctrl_point", point, "three numbers: x and y of the rear left foot, friction"),
       NumbersRow("foot_pose", feet, "six numbers: x and y of the other feet"),
       NumbersRow("step_height", heights, "two numbers: the heights of two feet each, in mm"),
       Needed("value", row::Integer("value", value, 0, 1)),
       Needed("duration", row::Integer("duration", step.duration_ms, 1, kLongestGaitMs, "ms"))});
  constexpr double kTen = 10;
  for (std::size_t i = 0; i < turn.size(); ++i) {
    step.body[i] = turn[i];
    step.body[i + turn.size()] = place[i];
    step.landing[3 * i] = feet[2 * i];
    step.landing[3 * i + 1] = feet[2 * i + 1];
  }
  step.landing[9] = point[0];
  step.landing[10] = point[1];
  step.friction = point[2];
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const std::array<double, 2> two = Unpacked(heights[i]);
    step.step_height[2 * i] = two[0];
    step.step_height[2 * i + 1] = two[1];
  }
  step.landing_gain = static_cast<double>(contact) / kTen;
  step.use_mpc_traj = value != 0;
  return step;
}

void ReadStep(TableReader& reader, std::vector<Step>& steps) {
  const bool is_command = reader.Has("mode") && !reader.Has("type");
  steps.push_back(is_command ? ReadCommandStep(reader) : ReadWrittenStep(reader));
}

template <typename T>
Result<std::vector<T>> ReadTables(const std::string& text, const char* key,
                                  void (*read)(TableReader&, std::vector<T>&)) {
  const auto reading =
      config_toml::ReadTextWith<Reading<T>>(text, key, [&](const Table& root, Findings& findings) {
        std::vector<T> found;
        TableReader reader(root, {1, 1}, "", findings);
        for (TableReader& table : reader.Subs(key)) read(table, found);
        reader.RefuseOthers();
        return found;
      });
  if (reading.value) return *reading.value;
  return GaitError(FormatDiagnostic(reading.diagnostics.front()));
}

Result<std::vector<Section>> ReadSections(const std::string& text) {
  if (auto fits = CheckLength(text, "sections"); !fits) return fits.error();
  return ReadTables<Section>(text, "section", ReadSection);
}
Result<std::vector<Step>> ReadSteps(const std::string& text) {
  if (auto fits = CheckLength(text, "steps"); !fits) return fits.error();
  return ReadTables<Step>(text, "step", ReadStep);
}

// --- messages ---

Section SectionOf(const msg::MotionSequenceGait& gait) {
  return {{gait.right_forefoot, gait.left_forefoot, gait.right_hindfoot, gait.left_hindfoot},
          gait.duration};
}

// Roll, pitch and yaw. CyberDog's own programs have them in x, y and z of the orientation, whose w
// they leave at 1 or 0; a rotation has such a w only without an angle, or with half a turn.
std::array<double, 3> TurnOf(const msg::Quaternion& q) {
  constexpr double kUnit = 1e-3;
  const bool half_turn = q.w == 0 && std::abs(std::hypot(q.x, q.y, q.z) - 1) < kUnit;
  if ((q.w == 1 || q.w == 0) && !half_turn) return {q.x, q.y, q.z};
  const Eigen::Matrix3d R = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
          std::atan2(R(1, 0), R(0, 0))};
}

// The four numbers of a foot: where it lands, and how high it steps.
Step StepOf(const msg::MotionSequencePace& pace) {
  Step step;
  step.speed = {pace.twist.linear.x, pace.twist.linear.y, YawRateOf(pace.twist)};
  const std::array<double, 3> turn = TurnOf(pace.centroid.orientation);
  std::copy(turn.begin(), turn.end(), step.body.begin());
  const auto& at = pace.centroid.position;
  step.body[3] = at.x;
  step.body[4] = at.y;
  step.body[5] = at.z;
  const std::array feet = {&pace.right_forefoot, &pace.left_forefoot, &pace.right_hindfoot,
                           &pace.left_hindfoot};
  for (std::size_t i = 0; i < feet.size(); ++i) {
    step.landing[3 * i] = feet[i]->x;
    step.landing[3 * i + 1] = feet[i]->y;
    step.landing[3 * i + 2] = feet[i]->z;
    step.step_height[i] = *feet[i] == msg::Quaternion{} ? 0 : feet[i]->w;
  }
  const auto& w = pace.weight;
  step.weight = {w.linear.x, w.linear.y, w.linear.z, w.angular.x, w.angular.y, w.angular.z};
  step.use_mpc_traj = pace.use_mpc_track;
  step.friction = pace.friction_coefficient;
  step.landing_gain = pace.landing_gain;
  step.duration_ms = pace.duration;
  return step;
}

// `more` after `first`, unless it is the same once more.
template <typename T>
std::vector<T> Joined(std::vector<T> first, const std::vector<T>& more) {
  if (first != more) first.insert(first.end(), more.begin(), more.end());
  return first;
}

std::string Joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
}

}  // namespace

bool PlaysUserGait(const Motion& motion) {
  return motion.gait == kUserGaitNumber;
}

Result<> CheckGait(const Motion& motion, const UserGait& gait) {
  const SpeedLimit limit = motion.limit.value_or(kLimitOfSequences);
  for (std::size_t i = 0; i < limit.size(); ++i) {
    if (gait.fastest[i] <= limit[i]) continue;
    return GaitError("its speed in " + std::string(std::array{"x", "y", "yaw"}[i]) + " is up to " +
                     Text(gait.fastest[i]) + "; motion " + std::to_string(motion.id) +
                     " may have " + Text(limit[i]));
  }
  if (motion.min_exec_time_ms > 0 && gait.duration_ms > motion.min_exec_time_ms) {
    return GaitError("its steps take " + std::to_string(gait.duration_ms) + " ms; motion " +
                     std::to_string(motion.id) + " may take " +
                     std::to_string(motion.min_exec_time_ms) + " ms");
  }
  return Ok();
}

double YawRateOf(const msg::Twist& twist) {
  return twist.angular.z != 0 ? twist.angular.z : twist.linear.z;
}

bool IsWalk(const msg::MotionSequencePace& pace) {
  msg::MotionSequencePace walk;
  walk.twist.linear = pace.twist.linear;
  walk.twist.angular.z = pace.twist.angular.z;
  walk.duration = pace.duration;
  return walk == pace;
}

bool HasUserGait(const msg::MotionSequenceShow::Request& sequence) {
  if (!sequence.gait_list.empty() || !sequence.gait_toml_list.empty() ||
      !sequence.pace_toml_list.empty() || !sequence.gait_toml.empty() ||
      !sequence.pace_toml.empty()) {
    return true;
  }
  for (const msg::MotionSequencePace& pace : sequence.pace_list) {
    if (!IsWalk(pace)) return true;
  }
  return false;
}

Result<UserGait> ReadUserGait(const std::string& sections, const std::string& steps) {
  const auto feet = ReadSections(sections);
  if (!feet) return feet.error();
  const auto body = ReadSteps(steps);
  if (!body) return body.error();
  return Finished(feet.value(), body.value());
}

Result<UserGait> UserGaitOf(const msg::MotionSequenceShow::Request& sequence) {
  const auto first_sections = ReadSections(sequence.gait_toml);
  if (!first_sections) return first_sections.error();
  const auto more_sections = ReadSections(Joined(sequence.gait_toml_list));
  if (!more_sections) return more_sections.error();
  const auto first_steps = ReadSteps(sequence.pace_toml);
  if (!first_steps) return first_steps.error();
  const auto more_steps = ReadSteps(Joined(sequence.pace_toml_list));
  if (!more_steps) return more_steps.error();
  auto sections = Joined(first_sections.value(), more_sections.value());
  auto steps = Joined(first_steps.value(), more_steps.value());
  // CyberDog's manager gives its board the texts, and so those count where there are lists as well.
  if (sections.empty()) {
    for (const auto& gait : sequence.gait_list) sections.push_back(SectionOf(gait));
  }
  if (steps.empty()) {
    for (const auto& pace : sequence.pace_list) steps.push_back(StepOf(pace));
  }
  return Finished(sections, steps);
}

}  // namespace musher::motion
