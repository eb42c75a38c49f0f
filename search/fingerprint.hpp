#pragma once
// Which nodes of the search are the same. A node has 128 bits: with 10^8 nodes the probability of a
// collision is below 10^-21.
//
// Without what no decision depends on: texts, ids of records, durations, the codes of failures; of
// a machine that is torn down, all that its controller knew of the actuators.
//
// Of a process that has exited, as the controller knows, a record is left until another process of
// the actuator publishes. Without what is written again before it is read:
//   - the number of the last command, and of the last outcome, with its code: a command is sent to
//     a present actuator, a message of the exited process is ignored, and the first status of
//     another one replaces the report (Commands::Accept);
//   - in a TearDown whether it was detached: that is read where it may be started again;
//   - whether its writer is lost: asked of a process that may run on (Arrivals::MayRunBeside);
//   - its epoch, and whether this controller had taken control of it: but for whether another one
//     may have led it, which a takeover reads (Control::IsOfPredecessor).
// Whether the self-check of an actuator was commanded counts while it is present: Control::Attach
// resets that. Of whether control was taken of its process counts whether it is that of the report.
//
// Once nothing is under way from an exited process, of what it knew itself only what the rules of
// the search read counts: in which state it has ended, whether a stop held it, and whether it had
// done its part by then. The harness replaces the rest when it starts another one. On another host
// an exit may be a false report, after which the same process goes on: there all counts.
//
// Whether an actuator was lost in use, and in which state (KnownActuator::lost_in), is read by the
// result of a TearDown, and on disk by the next controller: it counts where one of them may follow
// (MayReportLoss). What is stored of the actuators counts while a fault is left.
//
// A search without reductions (Model::reduces) leaves out none of that.
//
// Times count from now, stamps by their order. Actuators with the same config and no order among
// them are interchangeable: the fingerprint does not distinguish them.

#include <cstdint>
#include <functional>

#include "musher/search/world.hpp"

namespace musher::search {

struct Fingerprint {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  auto operator<=>(const Fingerprint&) const = default;
};

// A node's fingerprint. `twins` has a bit for each actuator in the same state as an interchangeable
// earlier one, so that its choices are searched for that one only.
struct Identity {
  Fingerprint fingerprint;
  unsigned twins = 0;
};

Identity IdentityOf(const Model& model, const World& world);

}  // namespace musher::search
