#include "musher/cyberdog/extension.hpp"

#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
#include "musher/cyberdog/fs_machine_link.hpp"
#include "musher/cyberdog/manager.hpp"

namespace musher::cyberdog {

ControllerExtension Extension(std::string serial_number) {
  ControllerExtension extension;
  extension.links[Protocol::kCyberdog] = FsMachineLink::Make;
  extension.open_services =
      [serial = std::move(serial_number)](
          const ExtensionHost& host) -> Result<std::unique_ptr<ExtensionServices>> {
    auto manager = Manager::Make(host, serial);
    if (!manager) return manager.error();
    return std::unique_ptr<ExtensionServices>(std::move(manager).value());
  };
  extension.serves_manager = true;
  return extension;
}

}  // namespace musher::cyberdog
