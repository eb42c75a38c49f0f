#pragma once
// The serial number of the computer that the controller runs on.

#include <string>
#include <vector>

namespace musher::cyberdog {

// Linux's files: of a board with a device tree (CyberDog), of a PC (for root only).
inline const std::vector<std::string> kSerialNumberFiles = {"/proc/device-tree/serial-number",
                                                            "/sys/class/dmi/id/product_serial"};

// The printable characters, at most 64, of the first of these files that is readable and has any;
// else empty.
std::string ReadSerialNumber(const std::vector<std::string>& files = kSerialNumberFiles);

}  // namespace musher::cyberdog
