#include "musher/transport/dds/type_tag.hpp"

#include "musher/messages/type_hash.hpp"

namespace musher::transport::dds {

std::string TypeTag(const std::string& type) {
  const std::string hash(msg::TypeHashOf(type));
  return hash.empty() ? "hash=unknown;" : "typehash=" + hash + ";";
}

}  // namespace musher::transport::dds
