#pragma once
// Which choices need not be searched, because the others lead to the same.
//
// A controller that takes over goes on once each actuator that it has found running has answered.
// Before that, what arrives from an actuator changes only what is known of that one. Of an idle
// actuator, in which no callback runs or waits, the status and the answer say the same whenever
// they arrive. So while the answers of two idle ones are awaited, those of the first one are
// searched at once, before all else. Then the other one answers at any time, also as the last of
// all, and by the last answer the controller goes on.
//
// Why that loses nothing: take any order of choices in which it goes on. Move what arrives from the
// first idle one to its begin; and where the first one has answered last, move the answer of the
// other idle one to its place. Neither changes what any other choice does, since the controller
// waits all the time, and it goes on with the same knowledge. So each state that follows is
// reached, and each stable one; time stands still while these messages are under way. What is
// checked before concerns one actuator, or what none of these choices changes.
//
// An actuator that is not idle is not moved: whether its callback ends before or after the last
// answer counts. Nor is any without the following, each of which is a reason for which an order
// counts: no fault is left, which could happen at any point; no emergency stop and no battery that
// has fallen, which change more than one actuator; no other host; no actuator that is being torn
// down, the first of which, once found, decides at once.

#include <optional>

#include "musher/search/world.hpp"

namespace musher::search {

// The actuator whose choices alone need to be searched; none: all do.
std::optional<ActuatorIndex> SearchedAlone(const Model& model, const World& world);

}  // namespace musher::search
