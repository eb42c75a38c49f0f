#pragma once
// Requests for a switch. One switch at a time: the same request joins the one under way, a more
// urgent one takes over, any other is refused. While a late actuator is being driven to the state
// of the machine on its own, a request waits until that actuator is free, at most as long as its
// command may take; then it is planned as if it came only now. So does a request to a controller
// that is about to lead on what an earlier one has left, until it does.

#include <cstdint>
#include <optional>

#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher {

// Why a manager may not switch the machine to `target`: another requester has switched it to a less
// active state. None: it may.
std::optional<Error> RefusalOfManager(const MachineConfig& config, const Machine& machine,
                                      const State& target);

class Requests : StepPart {
 public:
  Requests(StepContext& step, Commands& commands, Switches& switches, TearDown& tear_down)
      : StepPart(step), commands_(commands), switches_(switches), tear_down_(tear_down) {}

  void On(const event::SetStateRequested& requested);
  // Begins the waiting switch, when it need not wait any more. Returns whether a change may let
  // other actuators proceed.
  bool BeginWaiting();

 private:
  std::optional<Error> Overridden(const Requester& by, std::optional<ActuatorIndex> only,
                                  const State& target) const;
  bool JoinOrRefuse(const event::SetStateRequested& requested, std::optional<ActuatorIndex> only,
                    RecordId request_record);
  bool JoinWaiting(const event::SetStateRequested& requested, std::optional<ActuatorIndex> only,
                   RecordId request_record);
  bool IsAboutToLead() const;
  void Await(const Plan& plan, Time until, const event::SetStateRequested& requested,
             RecordId request_record);
  bool CheckDegraded(const Plan& plan);

  Commands& commands_;
  Switches& switches_;
  TearDown& tear_down_;
};

}  // namespace musher
