#include "musher/cyberdog/manager.hpp"

#include "musher/controller/shell/controller_shell.hpp"

namespace musher::cyberdog {

Manager::Manager(const ExtensionHost& host, const std::string& serial_number)
    : endpoints_(host.node, host.shell.config().name_space, host.shell.config().clock),
      announcements_(endpoints_, host.shell.config(), host.shell.machine()),
      information_(endpoints_, host.shell.config(), host.shell.machine(), serial_number),
      self_check_file_(host.node.loop(), host.shell.config(), host.shell.machine(), host.save_text),
      power_saving_(endpoints_, host.shell),
      requests_(endpoints_, host.shell, power_saving_) {}

Result<std::unique_ptr<Manager>> Manager::Make(const ExtensionHost& host,
                                               const std::string& serial_number) {
  const auto& policy = host.shell.config().policy;
  if (!policy || !policy->manager) return std::unique_ptr<Manager>();
  std::unique_ptr<Manager> manager(new Manager(host, serial_number));
  if (!manager->endpoints_.opened()) return manager->endpoints_.opened().error();
  auto speaker = Speaker::Make(manager->endpoints_, host.shell);
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
