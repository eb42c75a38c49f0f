#pragma once
// The topics and services that an extension of the controller adds to Musher's own, by who may use
// them. The controller, which offers them, may subscribe to all topics; the permissions deny every
// use of them that is not named here. A topic that is not listed at all is data between actuators,
// open to all of them. `musher keys` knows the interfaces of CyberDog's manager.

#include <string>
#include <vector>

namespace musher::transport::keys {

// ROS 2 names without a namespace; they stand for these names in every namespace.
struct ExtensionInterfaces {
  std::vector<std::string> published;   // topics of the controller, which all roles subscribe to
  std::vector<std::string> queries;     // services that change nothing, which all roles call
  std::vector<std::string> subscribed;  // topics that actuators and operators publish
  std::vector<std::string> services;    // services that actuators and operators call
  std::vector<std::string> operator_topics;    // topics that only operators publish
  std::vector<std::string> operator_services;  // services that only operators call
};

}  // namespace musher::transport::keys
