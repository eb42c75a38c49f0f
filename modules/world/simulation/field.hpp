#pragma once
// A competition field in motion: the robot R2 with its arm and its spear, the boxes, and the
// partner R1. Steps are 10 ms of world time, two in a step of the world. Plain values.
//
// A tool (the arm, the spear) takes a command, is busy for the command's time, and is then done. It
// is not done when the command achieved nothing: it found no box, or it had none to place. The same
// command while the tool is busy, or just after it, is a repetition and changes nothing.

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/modules/world/body/lift_body.hpp"
#include "musher/modules/world/scene/field_specs.hpp"

namespace musher::world {

inline constexpr Duration kFieldStep = Milliseconds(10);

// Commands of the arm and of the spear, as on the wire.
enum class ArmCommand { kIdle, kGrasp, kStoreToBody, kStoreOnArm, kGetBody, kPlaceMid, kPlaceHigh };
enum class SpearCommand { kIdle, kPrepare, kGrasp, kDockExtend, kDockRelease };

struct KfsBox {
  enum class Where { kField, kGripper, kBody, kMid, kHigh };
  Where where = Where::kField;
  std::optional<Duration> taken_at;
};
const char* NameOf(KfsBox::Where where);  // "field", "gripper", "body", "mid", "high"

struct Tool {
  int command = 0;
  Duration until{};  // busy until then
  bool busy = false;
  bool done = false;   // of the last command
  std::string result;  // why it is not done
};

// For the picture, and for the report.
struct FieldEvent {
  enum class Kind { kUp, kDown, kTaken, kPlaced, kDocked, kReady, kBump, kFall };
  Kind kind = Kind::kUp;
  Duration at{};
  Eigen::Vector2d where_m{0, 0};
  std::string text;  // of a box its name, of a climb its height in mm
};
struct FieldSample {
  Duration at{};
  Eigen::Vector2d position_m{0, 0};
  double height_mm = 0;  // of the underside
  WheelHeights wheels_mm{};
};

// What its sensors measured at the end of a step of 10 ms.
struct FieldReading {
  std::array<bool, kLiftWheels> switches{};
  WheelHeights wheels_mm{};
  std::array<double, kLiftRangers> distances_mm{};
};

class Field {
 public:
  explicit Field(FieldSpec spec);

  // They return the reason when the command is refused.
  std::optional<std::string> Drive(const Eigen::Vector3d& velocity, Duration now) {
    return robot_.Drive(velocity, now);
  }
  std::optional<std::string> Lift(const WheelHeights& heights_mm) {
    return robot_.Lift(heights_mm);
  }
  std::optional<std::string> CommandArm(double command, Duration now);
  std::optional<std::string> CommandSpear(double command, Duration now);
  std::optional<std::string> PutDown(const Eigen::Vector2d& at_m, double yaw_rad, Duration now);

  // One step of the world that ends at `now`; `faults` as in kFieldFaults. Returns lines for the
  // log.
  std::vector<std::string> Step(const std::set<std::string>& faults, Duration now, Duration dt);

  const FieldSpec& spec() const { return spec_; }
  const LiftBody& robot() const { return robot_; }
  const std::vector<KfsBox>& boxes() const { return boxes_; }
  const Tool& arm() const { return arm_; }
  const Tool& spear() const { return spear_; }
  bool partner_ready() const { return partner_ready_; }
  const std::vector<FieldReading>& readings() const { return readings_; }  // of the last step
  const std::vector<FieldEvent>& events() const { return events_; }
  const std::vector<FieldSample>& way() const { return way_; }

 private:
  std::optional<std::string> Command(Tool& tool, const char* name, double command, double most,
                                     Duration now) const;
  std::optional<std::string> EndArm(Duration now);
  std::optional<std::string> Grasp(Duration now);
  std::optional<std::string> Place(KfsBox::Where where, Duration now);
  std::optional<std::string> EndSpear(Duration now);
  std::optional<std::size_t> BoxIn(KfsBox::Where where) const;
  int CountIn(KfsBox::Where where) const;
  void Note(FieldEvent::Kind kind, Duration now, const std::string& text);
  void NoteClimb(Duration now);
  void Record(Duration now);

  FieldSpec spec_;
  LiftBody robot_;
  std::vector<KfsBox> boxes_;  // as in the spec
  Tool arm_;
  Tool spear_;
  std::optional<Duration> docked_at_;
  bool partner_ready_ = false;
  double stands_mm_ = 0;  // the platform on which it stands, or stood last with all wheels
  std::vector<FieldReading> readings_;
  std::vector<FieldEvent> events_;
  std::vector<FieldSample> way_;
  Duration way_period_ = Milliseconds(100);
};

}  // namespace musher::world
