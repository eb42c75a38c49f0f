#pragma once
// The planner on the network; runs on any transport.
//
//   in   mf_r2_data (std_msgs/String)      a map of boxes as JSON; latched
//   out  planning/paths_for_web (String)   the plans of the last map as JSON; latched
//   in   planning/command (String)         "SEND": the best plan; "SEND 2": the best with 2 KFS2;
//                                          "SEND 2 3": the third of these
//   out  mf_action_seq                     the plan that was sent (std_msgs/Float32MultiArray);
//                                          latched
//   out  planning/last_error (String)      why a map or a command was refused; "" after one that
//                                          was not; latched
//   service get_action_seq                 the last plan of mf_action_seq, of any sender. It is
//                                          handed out once
//   out  mf_buffer_status (String)         "has_data" or "empty", at each change; latched
//
// A map is planned in any state. Plans are sent and handed out only where that is permitted.
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/base/log.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/plan/planner_config.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::meilin {

struct PlannerDependencies {
  transport::Node& node;
  transport::Clock& clock;
  std::string name_space;
  std::function<void(LogLevel level, const std::string& line)> log;
};

class PlannerEndpoint {
 public:
  static Result<std::unique_ptr<PlannerEndpoint>> Make(const PlannerDependencies& dependencies,
                                                       const PlannerConfig& config);

  // Whether plans are sent and handed out; `why` not. Without it a plan that was to be sent by
  // itself is not sent.
  void Permit(bool permitted, const std::string& why);

  bool permitted() const { return permitted_; }
  bool has_plan() const { return buffer_.has_value(); }

 private:
  PlannerEndpoint(const PlannerDependencies& dependencies, PlannerConfig config);
  Result<> Open();
  void OnMap(const std::string& text);
  void OnCommand(const std::string& command);
  Result<const Route*> Chosen(const std::string& command) const;
  void Send(const Route& route);
  void SetBuffer(std::optional<msg::Float32MultiArray> plan);
  void Report(const std::string& error);

  const PlannerDependencies dependencies_;
  const PlannerConfig config_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::optional<RouteReport> report_;  // of the last map
  std::optional<msg::Float32MultiArray> buffer_;
  transport::LoopHandlePtr send_timer_;
  std::function<void(const msg::String&)> publish_paths_;
  std::function<void(const msg::String&)> publish_error_;
  std::function<void(const msg::String&)> publish_status_;
  std::function<void(const msg::Float32MultiArray&)> publish_plan_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::meilin
