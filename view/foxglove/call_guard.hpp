#pragma once
// What a call of a service does, by its type and bytes, and for which machine it is. Pure; threads:
// any.

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::view::foxglove {

// A type is "musher_msgs::srv::dds_::SetState_".

// Whether it changes nothing: a client without a login may call it.
bool IsReading(std::string_view type);
// Whether it is a service of a controller whose requests name the machine that is meant.
bool NamesMachine(std::string_view type);
// Whether it pauses or cancels something. `request`: with its id.
bool IsStopping(std::string_view type, std::span<const std::byte> request);
// Whether it is never too late, however old it is: it only reads, stops, pauses, cancels, ends or
// lowers. `only_lowers`: whether a switch to that state does, of that actuator or of the machine
// ("").
using SwitchLowers = std::function<bool(const std::string& state, const std::string& actuator)>;
bool IsNeverLate(std::string_view type, std::span<const std::byte> request,
                 const SwitchLowers& only_lowers);
// The same of a message that is published: "std_msgs::msg::dds_::String_".
bool IsMessageNeverLate(std::string_view type, std::span<const std::byte> message);
// The request, `body` being its fields in CDR, with `id`. Where its type has a machine and it names
// none, it is for `machine`; one that names another machine, and does not only read, is refused.
// An empty `machine` changes nothing.
Result<msg::Bytes> RequestFor(const MachineIdentity& machine, std::string_view type,
                              const msg::RequestId& id, std::span<const std::byte> body);

}  // namespace musher::view::foxglove
