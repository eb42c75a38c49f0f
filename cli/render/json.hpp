#pragma once
// The JSON documents of `--json`, each on one line. docs/cli.schema.json describes them, and is a
// contract: keys may be added, none is renamed or removed.
//
// An actuator has the same keys wherever it stands, actuators are an object by name, and the key of
// an actuator's name is `actuator`. What is not known, or is none, is null (Known()).

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/machine/direct_tear_down.hpp"
#include "musher/cli/machine/host_clocks.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/machine/why.hpp"
#include "musher/cli/start/progress.hpp"
#include "musher/controller/client/standby_call.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/journal/replay.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/ota/manifest.hpp"
#include "musher/ota/slots.hpp"
#include "musher/wire/security/authority.hpp"

namespace musher::cli {

OrderedJson ActuatorJson(const msg::ActuatorInfo& actuator);
// The same keys without a controller: what only a controller knows is null.
OrderedJson ActuatorJson(const msg::ActuatorStatus& status);
// The stop that an actuator has latched.
OrderedJson StopJson(const msg::ActuatorStatus& status);
// What this host knows beside the status. `state_since_ns` by the wall clock, `up_s` of its
// controller; nullopt: not known.
struct StatusSince {
  std::optional<std::int64_t> state_since_ns;
  std::optional<double> up_s;
  std::map<std::string, std::string> units = {};  // of actuators whose process is one of this host
  std::optional<StandbyReport> standby = {};      // of this host
};
// `unlisted`: running actuators of the namespace that are not in the machine's config. `hosts`: its
// other hosts; nullopt: they were not looked at.
std::string StatusJson(const msg::MachineStatus& status,
                       const std::map<std::string, RunningActuators::Actuator>& unlisted = {},
                       const StatusSince& since = {},
                       const std::optional<std::vector<HostClock>>& hosts = {});
// A failure, the actuators that run without a controller, and the standby of this host.
std::string RunningJson(const Failure& failure,
                        const std::map<std::string, RunningActuators::Actuator>& running,
                        const std::optional<StandbyReport>& standby = {});
std::string EndingJson(const std::vector<DirectTearDown::Outcome>& outcomes);
std::string SwitchJson(const msg::SetState::Response& result);
std::string EstopJson(const EstopReport& report);
// `released`: the ids of the stops that the release has covered.
std::string ReleaseJson(const msg::MachineStatus& machine,
                        const std::vector<std::string>& released = {});
std::string PolicyJson(const msg::RequestPolicy::Request& request,
                       const msg::RequestPolicy::Response& response);
std::string RestartJson(const msg::ActuatorInfo& actuator);
std::string CapabilitiesJson(const msg::Capabilities& all);
std::string CapabilityJson(const msg::Capability& one);
std::string PlanJson(const msg::GetPlan::Response& plan);
std::string HistoryJson(const msg::GetHistory::Response& history);
std::string WhyJson(const Why& why);
std::string ReplayJson(const recording::ReplayReport& report, const std::string& damage);
std::string KeysJson(const std::string& folder,
                     const std::vector<transport::keys::Identity>& identities);
// The upgrade state of a robot for `musher ota status`.
struct OtaRobot {
  struct SlotInfo {
    std::string slot;
    std::string role;
    std::string version;  // empty: none that can be started
    std::string fault;    // why not
  };
  std::string robot;
  std::string root;
  int pid = 0;  // of its controller; 0: not running
  std::optional<ota::TrialBootEnd> last;
  std::vector<SlotInfo> slots;
};
std::string OtaStatusJson(const OtaRobot& robot);
std::string OtaStepJson(const std::string& step, std::uint64_t bytes);
// `outcome`: "kept", "rolled_back", or "waiting" for the next start.
std::string OtaResultJson(const std::string& version, const std::string& outcome,
                          const std::string& reason);
std::string OtaKeysJson(const std::string& secret, const std::string& open);
std::string OtaBundleJson(const ota::Manifest& manifest, const std::string& where);
std::string BehaviorJson(const std::string& name, const msg::GetBehavior::Response& report);
std::string BehaviorSentJson(const std::string& name, const std::string& command);
std::string GraphJson(const std::string& format, const std::string& drawing);
std::string GraphFileJson(const std::string& format, const std::string& file);
std::string ProgressJson(const Progress& progress);  // a line of `up --json`

}  // namespace musher::cli
