#include "musher/cyberdog/serial_number.hpp"

#include <cctype>
#include <fstream>

namespace musher::cyberdog {
namespace {

constexpr std::size_t kLongest = 64;

}  // namespace

std::string ReadSerialNumber(const std::vector<std::string>& files) {
  for (const std::string& path : files) {
    std::ifstream file(path);
    std::string number;
    for (char c = 0; number.size() < kLongest && file.get(c);) {
      if (std::isgraph(static_cast<unsigned char>(c)) != 0) number += c;
    }
    if (!number.empty()) return number;
  }
  return "";
}

}  // namespace musher::cyberdog
