#pragma once
// The requests of people, applications and the robot's own buttons to the policy. Each is answered,
// and a refusal says why and what to do.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/lifecycle/rules/policy_rules.hpp"
#include "musher/lifecycle/switch/requests.hpp"

namespace musher {

class PolicyRequests : StepPart {
 public:
  PolicyRequests(StepContext& step, Saver& saver, PolicyMemory& memory, Power& power,
                 Switches& switches, TearDown& tear_down, Requests& requests,
                 const PolicyRules& rules)
      : StepPart(step),
        saver_(saver),
        memory_(memory),
        power_(power),
        switches_(switches),
        tear_down_(tear_down),
        requests_(requests),
        rules_(rules) {}

  using Requested = event::PolicyRequested;
  void On(const Requested& requested);

 private:
  // Each returns the reason of a refusal; else nothing, and the request is answered later.
  std::optional<Error> Handle(const Requested& requested, RecordId request_record);
  std::optional<Error> HandleKeep(const Requested& requested, RecordId request_record);
  std::optional<Error> HandleOta(const Requested& requested, RecordId request_record);
  std::optional<Error> HandleLowPowerSwitch(const Requested& requested, RecordId request_record);
  std::optional<Error> HandleWakeUp(const Requested& requested, RecordId request_record);
  std::optional<Error> HandlePower(const Requested& requested, RecordId request_record);
  std::optional<Error> BeginRequested(const Requested& requested, const State& target,
                                      RecordId request_record);
  std::optional<Error> BeginUp(const Requested& requested, RecordId request_record);
  std::optional<Error> KeptOrBusy() const;
  bool InLowPower() const;

  Saver& saver_;
  PolicyMemory& memory_;
  Power& power_;
  Switches& switches_;
  TearDown& tear_down_;
  Requests& requests_;
  const PolicyRules& rules_;
};

// "wake-up", "keep in Protected for 60 s".
std::string Describe(const event::PolicyRequested& requested);

}  // namespace musher
