#include "musher/messages/definitions.hpp"

#include <algorithm>

namespace musher::msg {

const MessageDefinition* FindDefinition(std::string_view dds_type) {
  const std::span<const MessageDefinition> all = Definitions();
  const auto found = std::ranges::lower_bound(all, dds_type, {}, &MessageDefinition::dds_type);
  return found != all.end() && found->dds_type == dds_type ? &*found : nullptr;
}

}  // namespace musher::msg
