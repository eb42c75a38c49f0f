#pragma once
// The commands of ROS 2's `ros2` (Jazzy) on a robot: each sends the requests that ros2cli sends, on
// plain Cyclone without any of our code, and gives the text that ros2cli prints.
//
// Threads: the test's. In the domain of ROS_DOMAIN_ID.

#include <string>
#include <vector>

#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/protocols/ros_graph.hpp"

namespace musher::testing {

class RosCommands {
 public:
  RosCommands();

  // Of the graph that is known; until it has this node with this endpoint.
  bool AwaitNode(const std::string& node, const std::string& endpoint);
  std::string NodeList() const;
  std::string NodeInfo(const std::string& node) const;
  std::string TopicList() const;                          // -t
  std::string TopicInfo(const std::string& topic) const;  // -v, without the gids
  std::string ServiceType(const std::string& service) const;
  std::string ActionList() const;  // -t

  std::string LifecycleNodes() const;
  std::string LifecycleGet(const std::string& node);
  std::string LifecycleList(const std::string& node);
  std::string LifecycleSet(const std::string& node, const std::string& transition);

  std::string ParamList();
  std::string ParamGet(const std::string& node, const std::string& name);
  std::string ParamDescribe(const std::string& node, const std::string& name);
  std::string ParamDump(const std::string& node);
  // `value`: a text, or a number if it is one.
  std::string ParamSet(const std::string& node, const std::string& name, const std::string& value);

  const RosGraph& graph() const { return graph_.graph(); }
  PlainParticipant& participant() { return participant_; }

 private:
  template <class Response, class Request>
  bool Call(const std::string& service, const dds_topic_descriptor_t& request_type,
            const dds_topic_descriptor_t& response_type, Request request,
            const std::function<void(const Response&)>& on_reply);
  std::vector<std::string> ParamNames(const std::string& node);
  std::vector<std::string> ParamValues(const std::string& node,
                                       const std::vector<std::string>& names);

  RosGraphPeer graph_;
  PlainParticipant participant_;
};

}  // namespace musher::testing
