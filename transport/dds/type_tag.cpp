#include "musher/transport/dds/type_tag.hpp"

#include <cctype>
#include <cstddef>
#include <string_view>

#include "musher/messages/type_hash.hpp"

namespace musher::transport::dds {

std::string TypeTag(const std::string& type) {
  const std::string hash(msg::TypeHashOf(type));
  return hash.empty() ? "hash=unknown;" : "typehash=" + hash + ";";
}

std::string OtherHash(const std::string& user_data, const std::string& tag) {
  constexpr std::string_view kHash = "typehash=";
  std::size_t begin = user_data.find(kHash);
  const bool differs = tag.starts_with(kHash) && begin != std::string::npos &&
                       user_data.find(tag) == std::string::npos;
  if (!differs) return {};
  begin += kHash.size();
  std::string hash = user_data.substr(begin, user_data.find(';', begin) - begin);
  std::erase_if(hash, [](unsigned char c) { return std::isalnum(c) == 0 && c != '_'; });
  return hash.empty() ? "unreadable" : hash;
}

}  // namespace musher::transport::dds
