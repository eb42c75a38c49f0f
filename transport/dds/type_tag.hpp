#pragma once
// The USER_DATA by which ROS 2 identifies the definition of an endpoint's type: "typehash=<hash>;".
// A ROS 2 process logs a warning about every endpoint that has no USER_DATA at all.

#include <string>

namespace musher::transport::dds {

// `type`: its name on DDS. A type of the robot itself, of which Musher has no hash, gets a tag that
// ROS 2 accepts without a warning and shows as an unknown hash.
std::string TypeTag(const std::string& type);

// The hash in the USER_DATA of an endpoint, if it differs from the hash in `tag`, a TypeTag().
// Empty: both are equal, or one side has no hash, as an endpoint of a ROS 2 before Iron.
std::string OtherHash(const std::string& user_data, const std::string& tag);

}  // namespace musher::transport::dds
