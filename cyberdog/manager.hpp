#pragma once
// The topics and services of CyberDog's manager, for the dog's app and ROS 2 scripts, if the config
// has
// `[policy] manager = true`. An adapter: the policy in lifecycle/ makes all decisions.
//
// Threads: loop thread only.

#include <memory>
#include <string>

#include "musher/controller/extension.hpp"
#include "musher/cyberdog/announcements.hpp"
#include "musher/cyberdog/information.hpp"
#include "musher/cyberdog/power_saving.hpp"
#include "musher/cyberdog/requests.hpp"
#include "musher/cyberdog/self_check_file.hpp"
#include "musher/cyberdog/speaker.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Manager : public ExtensionServices {
 public:
  // Null unless the config enables it.
  static Result<std::unique_ptr<Manager>> Make(const ExtensionHost& host,
                                               const std::string& serial_number);

  void OnRecord(const action::Record& record) override;
  bool HoldsAnswers() const override { return endpoints_.HoldsReplies(); }

 private:
  Manager(const ExtensionHost& host, const std::string& serial_number);

  transport::Endpoints endpoints_;
  Announcements announcements_;
  Information information_;
  SelfCheckFile self_check_file_;
  PowerSaving power_saving_;
  Requests requests_;
  std::unique_ptr<Speaker> speaker_;  // null without [policy] voice
};

}  // namespace musher::cyberdog
