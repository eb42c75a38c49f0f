#include "musher/transport/security/wall_time.hpp"

#include <array>
#include <ctime>

namespace musher::transport::keys {

std::string IsoTime(WallTime time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

}  // namespace musher::transport::keys
