#pragma once
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher::msg {

// rcl_interfaces/msg/Log: topic `/rosout`.
struct Log {
  static constexpr std::string_view kTypeName = "rcl_interfaces::msg::dds_::Log_";
  static constexpr std::uint8_t kWarn = 30;
  static constexpr std::uint8_t kError = 40;

  Stamp stamp;
  std::uint8_t level = 0;
  std::string name;
  std::string msg;
  std::string file;
  std::string function;
  std::uint32_t line = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.stamp, m.level, m.name, m.msg, m.file, m.function, m.line);
  }
  friend bool operator==(const Log&, const Log&) = default;
};

}  // namespace musher::msg
