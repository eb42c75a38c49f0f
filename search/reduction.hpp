#pragma once
// Which choices need not be searched, because the others lead to the same. None is left out while a
// fault is left, which could happen at any point; nor with a battery that has fallen, or another
// host, which change more than one actuator.
//
// A controller that takes over waits for the actuators that it has found running: a
// start goes on once each of them has answered, and so does a TearDown that awaits those that have
// not announced themselves. Until then what happens at an actuator changes only this one, and what
// is known of it. An idle actuator, in which no callback runs or waits, only answers: its status
// and its answer say the same whenever they arrive. So while the answer of an idle one is awaited,
// what happens at another awaited actuator is searched at once, before all else, if something
// happens there for certain before time passes. Then the idle one answers at any time, also as the
// last of all, and by the last answer the controller goes on.
//
// Why that loses nothing: take any order of choices. The controller does not go on, and no time
// passes, before the actuator that is moved has made its next choice. Move that choice to the
// begin: what others do before it neither changes it nor is changed by it, since the controller
// waits all the time. Where it is the answer, and comes after that of the idle one, the two
// exchange their places: nothing else happens at the idle one meanwhile, and at the later place the
// controller knows the same as before. So each state that follows is reached, and each stable one.
// What is checked before concerns one actuator, or what none of these choices changes. The same
// holds for the next choice, and so on.
//
// Each of these is a reason for which an order counts, and nothing is moved:
//   - an emergency stop;
//   - an actuator that is given up, held, or about to be ended: it is not awaited;
//   - the process of another actuator, which is to be started after this one: its answer starts it,
//     unless the same ones wait for the idle one, too;
//   - a start that finds an actuator in its TearDown. It goes on at once, to the TearDown of all: an
//     exit, or the end of a callback, leads elsewhere before that than after it. There only idle
//     ones are moved, which both await alike. A start that finishes a TearDown awaits all.

#include <optional>

#include "musher/search/world.hpp"

namespace musher::search {

// Whether the result of a TearDown may still be reported. Nothing else reads whether an actuator
// was lost in use without its TearDown (KnownActuator::lost_in) but a next controller, which a
// fault starts.
bool MayReportLoss(const Model& model, const World& world);

// The actuator whose choices alone need to be searched; none: all do.
std::optional<ActuatorIndex> SearchedAlone(const Model& model, const World& world);

}  // namespace musher::search
