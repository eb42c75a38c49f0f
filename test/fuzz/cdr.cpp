// Untrusted samples of every message; the first byte selects the message. A sample that decodes is
// a value: encoded and decoded again it is the same.

#include "musher/messages/cdr.hpp"

#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/lifecycle_msgs/transition_event.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::msg {
namespace {

template <class M>
void RoundTrip(std::span<const std::byte> bytes) {
  const auto message = Decode<M>(bytes);
  if (!message) return;
  // Compares bytes, since floating-point fields may be NaN.
  const Bytes once = Encode(*message);
  const auto again = Decode<M>(once);
  fuzz::Require(again.has_value(), "an encoded value decodes");
  fuzz::Require(Encode(*again) == once, "a round trip changes nothing");
}

template <class S>
void RoundTripOfService(std::span<const std::byte> bytes) {
  RoundTrip<typename S::Request>(bytes);
  RoundTrip<typename S::Response>(bytes);
}

using Trip = void (*)(std::span<const std::byte>);
constexpr Trip kTrips[] = {
    RoundTrip<ActuatorStatus>,
    RoundTripOfService<ActuatorCommand>,
    RoundTrip<ActuatorBeat>,
    RoundTrip<ControllerBeat>,
    RoundTrip<EmergencyStop>,
    RoundTrip<MachineStatus>,
    RoundTrip<MachineInfo>,
    RoundTripOfService<SetState>,
    RoundTripOfService<GetPlan>,
    RoundTripOfService<GetHistory>,
    RoundTripOfService<GetSwitch>,
    RoundTripOfService<GetStatus>,
    RoundTripOfService<RestartActuator>,
    RoundTripOfService<ReleaseEmergencyStop>,
    RoundTripOfService<FsMachine>,
    RoundTrip<Heartbeats>,
    RoundTripOfService<ChangeState>,
    RoundTripOfService<GetState>,
    RoundTrip<TransitionEvent>,
    RoundTrip<String>,
    RoundTripOfService<Trigger>,
    RoundTrip<RequestId>,
    RoundTrip<Capabilities>,
};

}  // namespace
}  // namespace musher::msg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  musher::msg::kTrips[data[0] % std::size(musher::msg::kTrips)](
      std::as_bytes(std::span(data + 1, size - 1)));
  return 0;
}
