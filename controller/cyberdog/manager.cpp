#include "musher/controller/cyberdog/manager.hpp"

namespace musher::cyberdog {

Manager::Manager(transport::Node& node, ControllerShell& shell)
    : endpoints_(node, shell.config()),
      announcements_(endpoints_, shell.config(), shell.machine()),
      information_(endpoints_, shell.config(), shell.machine()),
      power_saving_(endpoints_, shell),
      requests_(endpoints_, shell, power_saving_) {}

Result<std::unique_ptr<Manager>> Manager::Make(transport::Node& node, ControllerShell& shell) {
  const auto& policy = shell.config().policy;
  if (!policy || !policy->manager) return std::unique_ptr<Manager>();
  std::unique_ptr<Manager> manager(new Manager(node, shell));
  if (!manager->endpoints_.opened()) return manager->endpoints_.opened().error();
  auto speaker = Speaker::Make(manager->endpoints_, shell);
  if (!speaker) return speaker.error();
  manager->speaker_ = std::move(speaker).value();
  return manager;
}

void Manager::OnRecord(const action::Record& record) {
  announcements_.OnRecord(record);
  power_saving_.OnRecord();
  if (speaker_) speaker_->OnRecord(record);
}

}  // namespace musher::cyberdog
