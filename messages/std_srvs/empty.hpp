#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// std_srvs/srv/Empty
struct EmptyService {
  static constexpr std::string_view kTypeName = "std_srvs::srv::dds_::Empty_";
  using Request = Empty;
  using Response = Empty;
};

}  // namespace musher::msg
