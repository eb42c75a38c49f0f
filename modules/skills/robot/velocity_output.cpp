#include "musher/modules/skills/robot/velocity_output.hpp"

#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {

bool VelocityOutput::OnScan(std::size_t scanner, const msg::LaserScan& scan) {
  const Duration stamp = msg::FromStamp(scan.header.stamp);
  if (!gate_.OnScan(scanner, ToScan(scan), stamp, clock_.Now())) return false;
  if (sending_) Publish();
  return true;
}

void VelocityOutput::OnRange(const msg::Range& range) {
  const bool taken =
      gate_.OnRange(ToReading(range), msg::FromStamp(range.header.stamp), clock_.Now());
  if (taken && sending_ && command_.z_m_s < 0) Publish();
}

void VelocityOutput::OnMotion(const navigation::Pose& pose, const navigation::Velocity& velocity,
                              Duration stamp) {
  gate_.OnVelocity(velocity, clock_.Now());
  gate_.OnHeight(pose.at.z_m, clock_.Now());
  const auto fault = guard_.OnPose(pose, stamp, clock_.Now());
  if (fault && sending_ && !flies_) Hold(*fault);
}

void VelocityOutput::Hold(const Error& fault) {
  if (fault_.empty()) fault_ = fault.message;
  verdict_ = gate_.Check({}, clock_.Now());
}

void VelocityOutput::Set(const navigation::Velocity& command) {
  teleop_until_.reset();
  Send(command);
}

void VelocityOutput::Teleoperate(const navigation::Velocity& command) {
  if (sending_ && !teleop_until_) return;
  const bool at_rest = command == navigation::Velocity{};
  if (at_rest && !fault_.empty()) return Stop();  // the stick is released once
  teleop_until_ = clock_.Now() + kTeleopTime;
  Send(command);
}

void VelocityOutput::Send(const navigation::Velocity& command) {
  const bool changed = !sending_ || !(command == command_);
  command_ = command;
  if (changed) Publish();
  if (!sending_) sending_ = clock_.Every(kPeriod, [this] { Publish(); });
}

void VelocityOutput::Stop() {
  sending_.reset();
  teleop_until_.reset();
  guard_.Forget();
  fault_.clear();
  gate_.ExpectGround(std::nullopt);
  command_ = {};
  Publish();
}

std::string VelocityOutput::HeldBy() const {
  if (!fault_.empty()) return fault_;
  return verdict_.holds() ? Describe(verdict_) : "";
}

// A command that is lost is followed by the next; after a lost 0 the robot stops by itself.
void VelocityOutput::Publish() {
  if (teleop_until_ && clock_.Now() >= *teleop_until_) return Stop();
  verdict_ = gate_.Check(fault_.empty() ? command_ : navigation::Velocity{}, clock_.Now());
  const auto fault = guard_.OnCommand(verdict_.command, clock_.Now());
  if (fault && !flies_) Hold(*fault);
  if (publisher_ != nullptr) static_cast<void>(publisher_->Publish(ToMessage(verdict_.command)));
}

}  // namespace musher::skills
