#include "musher/controller/cyberdog/manager.hpp"

namespace musher::cyberdog {

Manager::Manager(transport::Node& node, ControllerShell& shell, const Host& host)
    : endpoints_(node, shell.config().name_space, shell.config().clock),
      announcements_(endpoints_, shell.config(), shell.machine()),
      information_(endpoints_, shell.config(), shell.machine(), host.serial_number),
      self_check_file_(node.loop(), shell.config(), shell.machine(), host.save_text),
      power_saving_(endpoints_, shell),
      requests_(endpoints_, shell, power_saving_) {}

Result<std::unique_ptr<Manager>> Manager::Make(transport::Node& node, ControllerShell& shell,
                                               const Host& host) {
  const auto& policy = shell.config().policy;
  if (!policy || !policy->manager) return std::unique_ptr<Manager>();
  std::unique_ptr<Manager> manager(new Manager(node, shell, host));
  if (!manager->endpoints_.opened()) return manager->endpoints_.opened().error();
  auto speaker = Speaker::Make(manager->endpoints_, shell);
  if (!speaker) return speaker.error();
  manager->speaker_ = std::move(speaker).value();
  return manager;
}

void Manager::OnRecord(const action::Record& record) {
  announcements_.OnRecord(record);
  self_check_file_.OnRecord();
  power_saving_.OnRecord();
  if (speaker_) speaker_->OnRecord(record);
}

}  // namespace musher::cyberdog
