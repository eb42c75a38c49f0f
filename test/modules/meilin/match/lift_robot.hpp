#pragma once
// A robot for tests of a match that can fall: the body of the simulated world on its platforms,
// climbed by the servers' own suspension and drive, in virtual time. The arm and the spear take
// half a second. A test may end goals, stop the robot, or lose the process that has sent them.

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/modules/meilin/field/grid.hpp"
#include "musher/modules/meilin/robot.hpp"
#include "musher/modules/meilin/servers/move_to_pose.hpp"
#include "musher/modules/meilin/servers/suspension.hpp"
#include "musher/modules/world/body/lift_body.hpp"

namespace musher::meilin::testing {

class LiftRobot final : public Robot {
 public:
  enum class Server { kMove, kSuspension, kArm, kSpear };
  struct Live {
    Server server = Server::kMove;
    GoalState state = GoalState::kAccepted;
    std::string message;
    std::string feedback;
    Time begun{};
    bool cancel = false;
    std::uint8_t command = 0;  // of the arm and the spear
  };
  // Asked in each step for each goal that runs: fails with this text, or goes on with "".
  std::function<std::string(const Live&)> breaks = [](const Live&) { return std::string(); };
  std::vector<std::string> warnings;
  std::optional<Cell> box;  // one that is not taken stands there

  explicit LiftRobot(Side side)
      : grid_(GridOf(side)),
        field_(FieldOf(grid_)),
        body_(field_),
        suspension_({}),
        drive_(DriveSettings()) {}

  Time Now() const { return now_; }
  const world::LiftBody& body() const { return body_; }
  bool fallen() const { return body_.falls() > 0; }
  // A person puts it there.
  void Put(Point2 at, double yaw_rad) {
    StopAll("Aborted: put down");
    const auto refused = body_.PutDown(field_, {at.x_m, at.y_m}, yaw_rad);
    if (refused) placed_wrong_ = *refused;
    Report();
  }
  const std::string& placed_wrong() const { return placed_wrong_; }
  // As an emergency stop, or the end of Active, does it: the wheels hold their heights.
  void StopAll(const std::string& why) {
    for (const auto& live : live_) End(*live, GoalState::kCancelled, why);
  }

  void Step() {
    now_ += Milliseconds(10);
    UpdateDrive();
    UpdateSuspension();
    UpdateTools();
    const world::LiftPlace place{field_, [this](const auto& at, double mm) {
                                   return BoxAt({at.x(), at.y()}, mm);
                                 }};
    body_.Step(place, {}, now_.time_since_epoch(), Milliseconds(10));
    Report();
    std::erase_if(live_, [](const auto& live) { return HasEnded(live->state); });
  }

  GoalPtr MoveToPose(const std::string&, const MoveGoal& goal) override {
    for (const auto& live : live_) {
      if (live->server == Server::kMove)
        End(*live, GoalState::kFailed, "Preempted by a newer goal");
    }
    drive_.Begin({goal.x_m, goal.y_m, goal.yaw_rad}, now_);
    drive_at_ = now_;
    return Add(Server::kMove, 0, "");
  }
  GoalPtr ControlSuspension(const std::string&, const meilin::SuspensionGoal& goal) override {
    if (suspension_.running()) return Add(Server::kSuspension, 0, "busy");
    const std::string why = suspension_.Begin(
        {static_cast<servers::SuspensionMode>(goal.mode),
         static_cast<servers::ClimbDirection>(goal.direction), goal.height_mm, goal.timeout_s},
        now_);
    return Add(Server::kSuspension, 0, why);
  }
  GoalPtr MoveArm(const std::string&, const ArmGoal& goal) override {
    return Add(Server::kArm, goal.command, "");
  }
  GoalPtr MoveSpear(const std::string&, const SpearGoal& goal) override {
    return Add(Server::kSpear, goal.command, "");
  }
  std::optional<PoseFix> pose() const override { return fix_; }
  std::optional<Wheels> wheels() const override { return legs_; }
  int suspension_state() const override {
    return suspension_.running() ? static_cast<int>(suspension_.state()) : 0;
  }
  const Signal& partner_ready() const override { return partner_; }
  const Signal& arm_idle() const override { return arm_; }
  void Warn(const std::string& text) override { warnings.push_back(text); }

 private:
  class Handle final : public Goal {
   public:
    explicit Handle(std::shared_ptr<Live> live) : live_(std::move(live)) {}
    GoalState state() const override { return live_->state; }
    const std::string& message() const override { return live_->message; }
    int final_state() const override { return 0; }
    const std::string& feedback() const override { return live_->feedback; }
    void Cancel() override { live_->cancel = true; }

   private:
    const std::shared_ptr<Live> live_;
  };

  static Grid GridOf(Side side) {
    Grid grid;
    grid.side = side;
    return grid;
  }
  static world::FieldSpec FieldOf(const Grid& grid) {
    world::FieldSpec field;
    field.side = SideText(grid.side);
    for (int row = 0; row < kRows; ++row) {
      for (int col = 0; col < kCols; ++col) field.heights_mm.push_back(grid.HeightMm({row, col}));
    }
    return field;
  }
  std::optional<std::string> BoxAt(Point2 at, double underside_mm) const {
    if (!box) return std::nullopt;
    const Point2 centre = grid_.Centre(*box);
    const double half_m = world::kKfsSizeM / 2;
    const bool inside =
        std::abs(at.x_m - centre.x_m) < half_m && std::abs(at.y_m - centre.y_m) < half_m;
    if (!inside || underside_mm > grid_.HeightMm(*box) + 1000 * world::kKfsSizeM) {
      return std::nullopt;
    }
    return "a box";
  }
  // As config/meilin/move_to_pose.toml has them.
  static servers::MoveSettings DriveSettings() {
    servers::MoveSettings settings;
    settings.xy_limit = Milliseconds(40'000);
    settings.climb_m_s = 0.3;
    settings.brake_m_s2 = 1.5;
    return settings;
  }

  GoalPtr Add(Server server, std::uint8_t command, const std::string& refused) {
    auto live = std::make_shared<Live>();
    live->server = server;
    live->command = command;
    live->begun = now_;
    live_.push_back(live);
    if (!refused.empty()) {
      live->state = GoalState::kFailed;
      live->message = refused;
    }
    if (server == Server::kSpear && command == kSpearDock) SetPartner(false);
    return std::make_unique<Handle>(live);
  }

  void End(Live& live, GoalState state, const std::string& message) {
    if (HasEnded(live.state)) return;
    live.state = state;
    live.message = message;
    if (live.server == Server::kMove && state != GoalState::kSucceeded) drive_.Stop(now_);
    if (live.server == Server::kSuspension && state != GoalState::kSucceeded) {
      suspension_.Stop();
      SendTargets();
    }
  }
  // The goal of a server that runs; a cancelled or broken one ends here.
  Live* Running(Server server) {
    for (const auto& live : live_) {
      if (live->server != server || HasEnded(live->state)) continue;
      const std::string broken = breaks(*live);
      if (!broken.empty()) End(*live, GoalState::kFailed, broken);
      if (live->cancel) End(*live, GoalState::kCancelled, "Cancelled");
      if (!HasEnded(live->state)) return live.get();
    }
    return nullptr;
  }

  void UpdateDrive() {
    Live* live = Running(Server::kMove);
    if (now_ < drive_at_) return;
    drive_at_ = now_ + drive_.UpdatePeriod();
    drive_.OnClimbing(suspension_.running() &&
                      suspension_.state() != servers::SuspensionState::kIdle);
    const servers::MoveToPose::Step step = drive_.Update(now_);
    if (step.command) {
      body_.Drive({step.command->x_m_s, step.command->y_m_s, step.command->yaw_rad_s},
                  now_.time_since_epoch());
    }
    if (step.end && live != nullptr) {
      live->state = step.end->success ? GoalState::kSucceeded : GoalState::kFailed;
      live->message = step.end->message;
    }
  }
  void UpdateSuspension() {
    suspension_.OnChassis(body_.Switches(field_), body_.wheels_mm(), now_);
    Live* live = Running(Server::kSuspension);
    suspension_.OnDistances(body_.DistancesMm(field_), now_);
    const auto end = suspension_.Update(now_);
    if (end || suspension_.running()) SendTargets();
    if (!end || live == nullptr) return;
    live->state = end->success ? GoalState::kSucceeded : GoalState::kFailed;
    live->message = end->message;
  }
  void UpdateTools() {
    for (const Server server : {Server::kArm, Server::kSpear}) {
      Live* live = Running(server);
      if (server == Server::kArm) {
        arm_.value = live == nullptr;
        arm_.at = now_;
      }
      if (live == nullptr || now_ - live->begun < Milliseconds(500)) continue;
      live->state = GoalState::kSucceeded;
      if (server == Server::kSpear && live->command == kSpearDock) SetPartner(true);
    }
  }
  void SendTargets() {
    if (suspension_.targets()) body_.Lift(*suspension_.targets());
  }
  void SetPartner(bool ready) {
    if (ready) ++partner_.trues;
    if (ready && partner_.value != true) ++partner_.rises;
    partner_.value = ready;
  }
  void Report() {
    fix_ = PoseFix{body_.position_m().x(), body_.position_m().y(), body_.yaw_rad(), now_,
                   body_.height_mm() / 1000};
    legs_ = Wheels{body_.wheels_mm(), now_};
    drive_.OnPose({fix_->x_m, fix_->y_m, fix_->yaw_rad}, now_);
  }

  const Grid grid_;
  const world::FieldSpec field_;
  world::LiftBody body_;
  servers::Suspension suspension_;
  servers::MoveToPose drive_;
  Time now_{Milliseconds(1000)};
  Time drive_at_{};
  std::vector<std::shared_ptr<Live>> live_;
  std::optional<PoseFix> fix_;
  std::optional<Wheels> legs_;
  Signal partner_;
  Signal arm_;
  std::string placed_wrong_;
};

}  // namespace musher::meilin::testing
