#pragma once
// The topics and services of CyberDog's manager, for the dog's app and ROS 2 scripts, if the config
// has
// `[policy] manager = true`. An adapter: the policy in lifecycle/ makes all decisions.
//
// Threads: loop thread only.

#include <memory>

#include "musher/controller/cyberdog/announcements.hpp"
#include "musher/controller/cyberdog/information.hpp"
#include "musher/controller/cyberdog/power_saving.hpp"
#include "musher/controller/cyberdog/requests.hpp"
#include "musher/controller/cyberdog/self_check_file.hpp"
#include "musher/controller/cyberdog/speaker.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

// The computer that the manager runs on.
struct Host {
  SaveText save_text;  // may be empty
  std::string serial_number;
};

class Manager {
 public:
  // Null unless the config enables it. The shell must outlive it.
  static Result<std::unique_ptr<Manager>> Make(transport::Node& node, ControllerShell& shell,
                                               const Host& host);

  // To be called for every record of the shell.
  void OnRecord(const action::Record& record);

 private:
  Manager(transport::Node& node, ControllerShell& shell, const Host& host);

  transport::Endpoints endpoints_;
  Announcements announcements_;
  Information information_;
  SelfCheckFile self_check_file_;
  PowerSaving power_saving_;
  Requests requests_;
  std::unique_ptr<Speaker> speaker_;  // null without [policy] voice
};

}  // namespace musher::cyberdog
