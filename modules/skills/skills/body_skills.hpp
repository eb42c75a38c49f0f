#pragma once
// The skills of a robot's body, hand and camera: take_off, hover, land, take_photo,
// object_detection, detect, pick_up, put_down, grasp, place. Each header explains its states,
// limits and messages; every parameter has its unit in the table of its skill.
//
//   skill::Registry registry;
//   Result<> added = skills::RegisterBodySkills(registry, robot);   // robot outlives the registry
//
// A robot that cannot execute one of them, without a hand or on the ground, refuses it in its first
// step, with the reason. Which robot offers which skills is up to the config.
//
// Pure: no thread, clock or DDS. Threads: the loop on which skills are stepped.

#include "musher/behavior/skill/registry.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// Fails for names that are registered already; then some are added.
Result<> RegisterBodySkills(skill::Registry& registry, Robot& robot);

}  // namespace musher::skills
