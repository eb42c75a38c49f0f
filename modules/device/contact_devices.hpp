#pragma once
// Contacts on GPIO lines, such as bumpers and the one of a charging dock: each is published as
// std_msgs/Bool, latched, on contact/NAME while its line can be read. A contact that cannot be read
// has no publisher, so that its last value is not taken for a present one.
//
// Threads: the loop's.

#include <memory>
#include <string>
#include <vector>

#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/gpio_input.hpp"
#include "musher/transport/node.hpp"

namespace musher::device {

struct ContactConfig {
  std::string name;
  GpioSpec line;

  friend bool operator==(const ContactConfig&, const ContactConfig&) = default;
};

class ContactDevices {
 public:
  ContactDevices(const Dependencies& dependencies, const std::vector<ContactConfig>& contacts);
  ~ContactDevices();

  // Fails with 1009 while one cannot be read or published.
  Result<> Check() const;

 private:
  class Contact;

  std::vector<std::unique_ptr<Contact>> contacts_;
};

}  // namespace musher::device
