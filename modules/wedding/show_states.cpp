#include "musher/modules/wedding/show_states.hpp"

#include <memory>
#include <string>

#include "musher/modules/wedding/states/farewell.hpp"
#include "musher/modules/wedding/states/photo_posing.hpp"
#include "musher/modules/wedding/states/safe_stop.hpp"

namespace musher::wedding {
namespace {

void AddCommands(fsm::Machine& machine) {
  machine.AddEvent(std::string(command::kStop), fsm::Urgency::kUrgent);
  machine.AddEvent(std::string(command::kIdle), fsm::Urgency::kUrgent);
  machine.AddEvent(std::string(command::kPhoto));
  machine.AddEvent(std::string(command::kTracking));
}

}  // namespace

void AddStates(fsm::Machine& machine, ShowData& data, const ShowConfig& config,
               ActionPlayer* actions) {
  AddCommands(machine);
  machine.AddData("show", [&data](fsm::Archive& archive) { data.Persist(archive); });
  std::unique_ptr<Idle> idle = std::make_unique<Idle>(data, config.idle);
  TrackingRules tracking_rules = config.tracking;
  if (actions != nullptr) tracking_rules.greets = false;
  std::unique_ptr<Tracking> tracking = std::make_unique<Tracking>(data, tracking_rules);
  if (config.search) {
    machine.AddEvent(std::string(command::kSearch));
    idle = std::make_unique<SearchingIdle>(data, config.idle);
    if (config.actions && actions != nullptr) {
      idle = std::make_unique<ObservingIdle>(data, config.idle, *config.actions, *actions);
    }
  }
  if (config.interview) {
    machine.AddEvent(std::string(command::kInterview));
    tracking = std::make_unique<InterviewingTracking>(data, tracking_rules, *config.interview);
  }
  machine.Add(std::string(state::kIdle), std::move(idle));
  machine.Add(std::string(state::kTracking), std::move(tracking));
  machine.Add(std::string(state::kPhotoPosing), std::make_unique<PhotoPosing>(data, config.photo));
  machine.Add(std::string(state::kFarewell), std::make_unique<Farewell>(data, config.farewell));
  machine.Add(std::string(state::kSafeStop), std::make_unique<SafeStop>(data, config.safe_stop),
              fsm::Role::kSafe);
  if (config.search) {
    machine.Add(std::string(state::kSearch), std::make_unique<Search>(data, *config.search));
  }
  if (config.interview) {
    machine.Add(std::string(state::kInterview),
                std::make_unique<Interview>(data, *config.interview));
  }
  machine.AddSafetyCheck("a guest is too close",
                         [&data](const fsm::Tick&) { return !data.perception.too_close; });
  machine.AddSafetyCheck("no detector publishes",
                         [&data](const fsm::Tick&) { return !data.perception.blind; });
}

}  // namespace musher::wedding
