#pragma once
// The skills that the running actuators of a namespace offer, from the latched topic `skills`.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"

namespace musher::cli {

class SkillOffers {
 public:
  // `on_lost` gets the name of an actuator whose offer is lost. The link must outlive this.
  static Result<std::unique_ptr<SkillOffers>> Begin(
      Link& link, const GlobalOptions& global,
      std::function<void(const std::string& actuator)> on_lost = {});

  // Runs the loop until the offer of that actuator is received; of all actuators if it is empty:
  // until no further one has come for a while. Returns why there is none: no robot, no such
  // actuator, one without skills, or Ctrl-C.
  std::optional<Failure> Await(const std::string& actuator);
  // The same without an explanation, for at most that time.
  void AwaitAny(Duration timeout);

  // Offers sorted by the names of the actuators.
  std::vector<msg::SkillOffers> all() const;

 private:
  SkillOffers(Link& link, const GlobalOptions& global,
              std::function<void(const std::string& actuator)> on_lost)
      : link_(link), global_(global), on_lost_(std::move(on_lost)) {}

  bool Has(const std::string& actuator) const { return offers_.contains(actuator); }
  void AwaitUntilQuiet(const std::string& actuator, Duration timeout);
  Failure NoOffer(const std::string& actuator) const;

  Link& link_;
  const GlobalOptions& global_;
  const std::function<void(const std::string& actuator)> on_lost_;
  struct Offer {
    msg::SkillOffers skills;
    transport::EndpointId writer = 0;
  };
  std::map<std::string, Offer> offers_;  // by actuator, of its latest process
  bool changed_ = false;
  std::unique_ptr<RunningActuators> running_;
  std::unique_ptr<transport::Subscription> subscription_;  // last: uses all of the above
};

}  // namespace musher::cli
