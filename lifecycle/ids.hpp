#pragma once
// The numbers that name things, each of its own type: two of them cannot be swapped. Values, from
// any thread; only a literal becomes one by itself, a number of a message or of a file by name.

#include "musher/base/strong_number.hpp"

namespace musher {

// Number of a leading controller: the next one has a higher epoch.
using Epoch = StrongNumber<struct EpochKind>;
// Number of a switch or of a command to an actuator: both grow together in an epoch. 0: none.
using CommandNumber = StrongNumber<struct CommandKind>;
// Number of an actuator's process: grows with every start on a host. 0: not known.
using Incarnation = StrongNumber<struct IncarnationKind>;
// Number of a record, from 1 in a controller; as a cause, the record that another follows from. 0:
// none.
using RecordId = StrongNumber<struct RecordKind>;
// Id of a request to the controller, which gets exactly one reply; its shell has the client.
using RequestId = StrongNumber<struct RequestKind>;
// Id of a request to an actuator, which gets exactly one reply; its shell has the client.
using RequestToken = StrongNumber<struct TokenKind>;
// The participant that sent a sample, as the transport reports it. 0: unknown.
using Sender = StrongNumber<struct SenderKind>;
// Id of an emergency stop: random, from the participant that engaged it. 0: none.
using StopId = StrongNumber<struct StopKind>;
inline constexpr StopId kUnknownStop = 1;  // of a stop without an id, whose sender is not known
// Number of a save on disk, grows from 1 in a controller.
using SaveNumber = StrongNumber<struct SaveKind>;
// Which actuator, in the order of the config; indexes a PerActuator.
using ActuatorIndex = StrongNumber<struct ActuatorKind>;

}  // namespace musher
