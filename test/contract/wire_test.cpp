// Musher's own messages, and those by which it drives actuators: as the IDL says.

#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields.hpp"
#include "musher/test/contract/wire_fields_tools.hpp"

namespace musher::transport::wire_test {

MESSAGE(std_msgs, String)
MESSAGE(protocol, Heartbeats)
MESSAGE(lifecycle_msgs, State)
MESSAGE(lifecycle_msgs, Transition)
MESSAGE(lifecycle_msgs, TransitionEvent)
MESSAGE(lifecycle_msgs, TransitionDescription)
MUSHER_MESSAGE(bond, Status, BondStatus)
MESSAGE(diagnostic_msgs, KeyValue)
MESSAGE(diagnostic_msgs, DiagnosticStatus)
MESSAGE(diagnostic_msgs, DiagnosticArray)
MESSAGE(rcl_interfaces, Log)
MESSAGE(musher_msgs, ActuatorStatus)
MESSAGE(musher_msgs, ActuatorInfo)
MESSAGE(musher_msgs, ActuatorBeat)
MESSAGE(musher_msgs, ControllerBeat)
MESSAGE(musher_msgs, EmergencyStop)
MESSAGE(musher_msgs, MachineStatus)
MESSAGE(musher_msgs, MachineInfo)
MESSAGE(musher_msgs, ActuatorOutcome)
MESSAGE(musher_msgs, PlanStep)
MESSAGE(musher_msgs, HistoryEntry)
MESSAGE(musher_msgs, Capability)
MESSAGE(musher_msgs, Capabilities)
SERVICE(std_srvs, Trigger)
SERVICE(protocol, FsMachine)
SERVICE(lifecycle_msgs, ChangeState)
SERVICE(lifecycle_msgs, GetState)
SERVICE(lifecycle_msgs, GetAvailableStates)
SERVICE(lifecycle_msgs, GetAvailableTransitions)
SERVICE(musher_msgs, ActuatorCommand)
SERVICE(musher_msgs, SetState)
SERVICE(musher_msgs, RequestPolicy)
SERVICE(musher_msgs, RestartActuator)
SERVICE(musher_msgs, ReleaseEmergencyStop)
SERVICE(musher_msgs, GetStatus)
SERVICE(musher_msgs, GetPlan)
SERVICE(musher_msgs, GetSwitch)
SERVICE(musher_msgs, GetHistory)
SERVICE(musher_msgs, GetCapabilities)

}  // namespace musher::transport::wire_test
