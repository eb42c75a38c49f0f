#include "musher/transport/dds/service_tags.hpp"

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace musher::transport::dds {

namespace {

// Bytes in hexadecimal with dots between them.
std::string Dotted(const std::uint8_t* bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    char part[4];
    std::snprintf(part, sizeof(part), i == 0 ? "%02x" : ".%x", bytes[i]);
    text += part;
  }
  return text;
}

// FNV-1a.
std::uint64_t Hash(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  return hash;
}

}  // namespace

ServiceTags::ServiceTags(dds_entity_t participant, int node) : node_(node) {
  dds_guid_t guid{};
  dds_get_guid(participant, &guid);
  participant_ = Dotted(guid.v, sizeof(guid.v));
}

std::string ServiceTags::Tag(const std::string& topic, Counts& counts) {
  constexpr std::size_t kPrefix = 3;   // "rq/", "rr/"
  constexpr std::size_t kRequest = 7;  // "Request"
  constexpr std::size_t kReply = 5;    // "Reply"
  const bool requests = topic.starts_with("rq/") && topic.ends_with("Request");
  const bool replies = topic.starts_with("rr/") && topic.ends_with("Reply");
  if (!requests && !replies) return {};

  const bool writes = &counts == &writers_;
  const std::size_t suffix = requests ? kRequest : kReply;
  const std::string role = writes == requests ? "clientid" : "serviceid";
  const std::string service = topic.substr(kPrefix, topic.size() - kPrefix - suffix);
  const int number = counts[role + ' ' + service]++;

  const std::uint64_t id =
      Hash(role + ' ' + service + ' ' + std::to_string(node_) + ' ' + std::to_string(number));
  std::uint8_t bytes[sizeof(id)];
  std::memcpy(bytes, &id, sizeof(id));
  return role + '=' + participant_ + '.' + Dotted(bytes, sizeof(bytes)) + ';';
}

}  // namespace musher::transport::dds
