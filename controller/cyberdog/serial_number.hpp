#pragma once
// The serial number of the computer that the controller runs on.

#include <string>
#include <vector>

namespace musher::cyberdog {

// Where Linux shows it: of a board with a device tree (a CyberDog's), of a PC (for root only).
inline const std::vector<std::string> kSerialNumberFiles = {"/proc/device-tree/serial-number",
                                                            "/sys/class/dmi/id/product_serial"};

// The first of these files that can be read and has printable characters; those, at most 64. Empty
// where there is none.
std::string ReadSerialNumber(const std::vector<std::string>& files = kSerialNumberFiles);

}  // namespace musher::cyberdog
