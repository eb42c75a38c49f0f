#pragma once
// Checks which controller may act: the newest word of a person counts, nothing rises without one,
// and nothing that is meant for one of two machines in a network changes the other.
//
// Invariants: kEpochRaisedOnce, kTakeoverLasts, kRisesAreRecorded (of the machine),
// kReachesMeantMachine (requests and controllers), kOtherMachineNeverFences.

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class AuthorityChecker : public SubjectChecker {
 public:
  explicit AuthorityChecker(CheckerContext& context) : SubjectChecker(context) {}

  // Another machine in the same network.
  void SetOther(const SimRobot& other) { other_ = &other; }
  // A controller begins to lead.
  void NoteWord(const SimulatedController& controller, bool by_supervisor);
  // Call after each step of a controller; the epoch before the step, 0: it had none.
  Epoch CheckEpoch(const SimulatedController& controller);
  void CheckFollows(const std::string& name, std::size_t host, const ActuatorReport& report);
  void NoteReasons(const SimulatedController& controller, const action::Record& record);
  // A callback of an actuator of a host has ended. One that led down and failed has left it where
  // it was found.
  void NoteEnded(const std::string& name, std::size_t host, const ActuatorReport& report);
  // An actuator of a host begins, by a command of the controller with this serial, a callback that
  // leads up.
  void CheckRise(std::uint64_t controller, const std::string& name, std::size_t host,
                 const ActuatorReport& report);
  void CheckReason(const SimulatedController& controller, const State& before);
  bool HasReason(std::uint64_t controller, const State& from, const State& to) const;
  void CheckMeant(const action::Record& record);
  void CheckFence(const SimulatedController& controller, const action::Record& record);
  void CheckControllerOf(const std::string& name, Sender controller);

 private:
  struct Seen {  // of a controller
    Epoch epoch = 0;
    Epoch began_with = 0;
    bool starts = true;
    int raised = 0;  // how often its epoch has risen
  };
  // A person's word is a start or a takeover. A supervisor restarts a controller by the same word
  // by which the controller before it on this host was started.
  struct Word {
    std::uint64_t number = 0;               // grows with each
    std::uint64_t controller = 0;           // its serial
    std::map<std::uint64_t, Epoch> others;  // of the controllers that led then, by serial
    std::set<std::uint64_t> together;       // those that were starting as well
  };
  struct Followed {
    Incarnation incarnation = 0;
    Word word;  // the newest
  };

  struct Found {  // running, by a controller that takes over and begins nothing
    Incarnation incarnation = 0;
    State most;  // where it was, or was being led down to
  };

  void CheckRaised(const SimulatedController& controller, Seen& seen, Epoch before);
  void NoteFound(const SimulatedController& controller);

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  std::uint64_t words_ = 0;
  std::map<std::uint64_t, Word> word_of_;              // by the serial of the controller
  std::map<std::size_t, std::uint64_t> last_word_on_;  // of a host
  std::map<std::pair<std::string, std::size_t>, Followed> followed_;  // by actuator, host
  // By the serial of the controller: the targets of requests and of the policy that it has
  // recorded, since nothing was under way.
  std::map<std::uint64_t, std::set<State>> reasons_;
  // By the serial of the controller, until it has recorded a reason: by actuator, host.
  std::map<std::uint64_t, std::map<std::pair<std::string, std::size_t>, Found>> found_;
  const SimRobot* other_ = nullptr;  // another machine in the network
};

}  // namespace musher::simulation
