#include "musher/modules/motion/gait_definition.hpp"

#include <utility>

#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion {

GaitDefinition::Output GaitDefinition::End(Result<> result) {
  definition_.reset();
  Output output;
  output.ended = std::move(result);
  return output;
}

GaitDefinition::Output GaitDefinition::Begin(const UserGait& gait, Time now) {
  Output output;
  const auto busy = [&](const std::string& why) {
    output.ended = Error{MotionCode(KeyCode::kTargetBusy), why};
    return output;
  };
  if (definition_) return busy("another gait is being defined");
  if (unanswered_ > 0 && now < late_until_) {
    return busy("the motion board may still answer to an earlier gait; try again in " +
                std::to_string(ToMilliseconds(late_until_ - now)) + " ms");
  }
  unanswered_ = 0;
  definition_ = Definition{gait.steps, false, now + kGaitAnswer};
  output.text = gait.sections;
  return output;
}

GaitDefinition::Output GaitDefinition::OnAnswer(bool accepted, Time now) {
  if (!definition_) {
    if (unanswered_ > 0) --unanswered_;
    return {};
  }
  if (!accepted) {
    return End(Error{MotionCode(MotionKey::kSequenceDefinition),
                     "the motion board refuses the " + NameOfText() + " of the gait"});
  }
  if (definition_->sent_steps) return End(Ok());
  definition_->sent_steps = true;
  definition_->answered_by = now + kGaitAnswer;
  Output output;
  output.text = definition_->steps;
  return output;
}

GaitDefinition::Output GaitDefinition::OnOtherText(const std::string& sender, Time now) {
  ++unanswered_;
  late_until_ = now + kLateGaitAnswer;
  if (!definition_) return {};
  ++unanswered_;
  return End(Error{MotionCode(KeyCode::kTargetBusy),
                   "another program defines a gait at the motion board: " + sender});
}

GaitDefinition::Output GaitDefinition::OnSendFailed(const Error& error) {
  return definition_ ? End(Error{MotionCode(KeyCode::kNetError), error.message}) : Output();
}

GaitDefinition::Output GaitDefinition::OnTime(Time now) {
  if (!definition_ || now < definition_->answered_by) return {};
  unanswered_ = 1;
  late_until_ = now + kLateGaitAnswer;
  return End(Error{MotionCode(MotionKey::kBoardSilent),
                   "the motion board has not answered to the " + NameOfText() +
                       " of the gait within " + std::to_string(ToMilliseconds(kGaitAnswer)) +
                       " ms"});
}

std::optional<Time> GaitDefinition::NextDeadline() const {
  if (!definition_) return std::nullopt;
  return definition_->answered_by;
}

}  // namespace musher::motion
