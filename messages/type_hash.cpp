#include "musher/messages/type_hash.hpp"

#include <algorithm>

namespace musher::msg {

std::string_view TypeHashOf(std::string_view type) {
  const std::span<const TypeHash> all = TypeHashes();
  const auto found = std::ranges::lower_bound(all, type, {}, &TypeHash::type);
  return found != all.end() && found->type == type ? found->hash : std::string_view();
}

}  // namespace musher::msg
