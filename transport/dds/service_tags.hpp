#pragma once
// The USER_DATA by which ROS 2 recognises the two endpoints of a service client or server as one:
// "clientid=<id>;" or "serviceid=<id>;", the same on both. A ROS 2 server delays its reply until
// the reader with the client's id is matched. Endpoints of other topics have none.

#include <dds/dds.h>

#include <map>
#include <string>

namespace musher::transport::dds {

class ServiceTags {
 public:
  // `node`: the number of the node in the participant.
  ServiceTags(dds_entity_t participant, int node);

  // The tag of the next writer or reader of a topic; the n-th writer of a service pairs with its
  // n-th reader.
  std::string ForWriter(const std::string& topic) { return Tag(topic, writers_); }
  std::string ForReader(const std::string& topic) { return Tag(topic, readers_); }

 private:
  using Counts = std::map<std::string, int>;

  std::string Tag(const std::string& topic, Counts& counts);

  std::string participant_;  // its GUID
  int node_;
  Counts writers_;  // made so far, for each role in each service
  Counts readers_;
};

}  // namespace musher::transport::dds
