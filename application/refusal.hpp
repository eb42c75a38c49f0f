#pragma once
// Why an application refuses a command, a goal or a state: every refusal of the base classes of
// applications, with its code and its sentence, as lifecycle/refusal.hpp has those of the
// controller and of an actuator. "An application" below "Refusals" in docs/troubleshooting.md says
// of each one what to do, and a test provokes it; test/house holds both.
//
//   return Refused<ApplicationRefusal::kPaused>(owner_.name(), Whereabouts());
//
// Threads: values, from any thread.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "musher/lifecycle/refusal.hpp"

namespace musher {

enum class ApplicationRefusal : std::uint8_t {
  kStoppedMeanwhile,
  kRunsNoSkills,
  kPaused,
  kWaitsForStart,
  kBeginsInActive,
  kUnknownCommand,
  kInsideOwnTree,
  kNotOneSkill,
  kOtherRobot,
  kMayBeLate,
  kUnderWay,
};

struct ApplicationRefusalForm {
  ApplicationRefusal why;
  std::int32_t code;
  std::string_view sentence;  // each {place} stands for a value
};

// In the order of ApplicationRefusal. {state} ends with ", held by the emergency stop" where that
// is so.
inline constexpr auto kApplicationRefusals = std::to_array<ApplicationRefusalForm>({
    {ApplicationRefusal::kStoppedMeanwhile, kCodeStateInvalid,
     "an emergency stop was engaged meanwhile"},
    {ApplicationRefusal::kRunsNoSkills, kCodeStateInvalid, "{actuator} runs no skills in {state}"},
    {ApplicationRefusal::kPaused, kCodeStateInvalid, "{actuator} is paused in {state}"},
    {ApplicationRefusal::kWaitsForStart, kCodeStateInvalid,
     "{actuator} stands and waits for START: musher behavior {actuator} --send START"},
    {ApplicationRefusal::kBeginsInActive, kCodeStateInvalid,
     "{actuator} begins in Active only; it is in {state}"},
    {ApplicationRefusal::kUnknownCommand, kCodeParametersInvalid,
     "there is no command '{command}'; expected {expected}"},
    {ApplicationRefusal::kInsideOwnTree, kCodeStateInvalid,
     "a node can not replace the tree that it belongs to"},
    {ApplicationRefusal::kNotOneSkill, kCodeParametersInvalid,
     "expected one skill in skill_list, found {count}"},
    {ApplicationRefusal::kOtherRobot, kCodeParametersInvalid,
     "the skill is for the robot '{robot}', and this is {own robot}"},
    {ApplicationRefusal::kMayBeLate, kCodeStateInvalid,
     "{actuator} could not run for {seconds} s, and the request may be as old: look at the robot, "
     "then repeat it"},
    {ApplicationRefusal::kUnderWay, kCodeStateInvalid,
     "{actuator} is under way already; START begins what rests"},
});

constexpr const ApplicationRefusalForm& FormOf(ApplicationRefusal why) {
  return kApplicationRefusals[static_cast<std::size_t>(why)];
}

// With the code of a module in place of the one of the form.
template <ApplicationRefusal kWhy, typename... Values>
Error RefusedWith(std::int32_t code, const Values&... values) {
  static_assert(FormOf(kWhy).why == kWhy, "kApplicationRefusals has the order of the ids");
  static_assert(PlacesIn(FormOf(kWhy).sentence) == sizeof...(Values),
                "one value for each place of the sentence");
  return MakeRefusal(code, FormOf(kWhy).sentence, {RefusalValue(values)...});
}

// The code of the form, and its sentence with the values in its places.
template <ApplicationRefusal kWhy, typename... Values>
Error Refused(const Values&... values) {
  return RefusedWith<kWhy>(FormOf(kWhy).code, values...);
}

}  // namespace musher
