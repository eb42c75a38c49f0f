#pragma once
// The race: the course's states as a machine, its inputs and its outputs. Pure: time comes in with
// each call, outputs go to a RaceOutputs.
//
//   START --START--> the states of the course --> END        RESET, then START: once more
//                        |  a fault: a failed motion, a fallen body, a silent camera, a lost walker
//                        +--> ERROR, which lies down         RESET, STOP or START:<name> leave it
//
// Threads: one at a time.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/rate_limited_log.hpp"
#include "musher/behavior/fsm/machine.hpp"
#include "musher/behavior/fsm/recorder.hpp"
#include "musher/modules/race/runner.hpp"

namespace musher::race {

namespace command {
inline constexpr std::string_view kStart = "START";
inline constexpr std::string_view kStop = "STOP";
inline constexpr std::string_view kReset = "RESET";
}  // namespace command

class Race : private fsm::Listener, private fsm::InputListener {
 public:
  Race(Course course, RaceOutputs& outputs);
  ~Race() override;

  // Registers the course's states with `machine`, which has none yet, and builds it; `machine`
  // outlives the race. Call it before everything else.
  Result<> Build(fsm::Machine& machine);

  // Records the inputs from now on; after Build(). The recorder outlives the race.
  void RecordTo(fsm::Recorder& recorder) { recorder_ = &recorder; }
  // Applies a recorded input, for fsm::Replay(). From then on forces come from the recording.
  Result<> Apply(std::string_view input, std::string_view text);

  // --- inputs: each logs what it refuses, and then changes nothing; of a sighting that is in part
  //     without sense the rest counts ---

  // START, START:<name or number>, STOP, RESET, SET_<result>:<value>, SET_<result>_DEFAULT, those
  // of the course, and what command_words.hpp takes for one of them. `timely`: fails where the
  // command may have waited for long; then only STOP and RESET count.
  void OnCommand(std::string_view text, Time now, const Result<>& timely = Ok());
  // `taken`: when the picture was taken, of the same clock as `now`.
  void OnSighting(Index detector, Sighting sighting, Time taken, Time now);
  // A word of another node: "A-1", "left".
  void OnText(Index detector, std::string_view text, Time now);
  // `doubt`: why the words mean nothing; empty: they do.
  void OnLines(Index detector, std::uint32_t contours, std::string_view ycy, std::string_view dy,
               double middle_offset, Time taken, Time now, std::string_view doubt = {});
  // Why a picture of a detector of sightings says nothing.
  void OnDoubt(Index detector, std::string_view why, Time now);
  void OnWalkerStatus(Index walk, std::string_view status, Time now);
  void OnMotionDone(std::uint64_t number, const Result<>& done, Time now);
  void OnSpoken(std::uint64_t number, const Result<>& spoken, Time now);
  // The body's pose, with the stamp of its message in ns and when it was there.
  void OnOdometry(std::int64_t stamp_ns, const navigation::Pose& pose, Time taken, Time now);
  // switch_status and motion_id of motion_status.
  void OnBody(int switch_status, int motion_id, Time now);
  // It is put on a charger, also where another publisher of the battery has reported one before; or
  // it is on none any more (charger_reports.hpp).
  void OnCharger(bool on, Time now);
  // Samples of two publishers of a topic are received alternately.
  void OnTwoPublishers(std::string_view topic, Time now);
  // motion_servo_response.
  void OnServoReply(bool accepted, std::int32_t code, Time now);

  // --- lifecycle, around that of the machine: it begins paused ---

  // After each tick of the machine.
  void AfterTick() { ExecuteJump(); }
  // Everything stands still until Resume(); until then the machine is not ticked.
  void Pause(Time now);
  void Resume(Time now);
  // This process could not run for so long (base/break_watch.hpp): under way it goes on by START,
  // a command that waits is dropped, and a pause was longer by that. Once for each break, and not
  // within a tick.
  void OnBreak(Duration length, Time now);
  bool resting() const { return resting_; }
  // Periodically, also while paused.
  void PassTime(Time now) { log_.Tick(now); }

  const Course& course() const { return course_; }
  const Memory& memory() const { return runner_.memory(); }
  // "" while the machine does not run.
  std::string_view state() const;
  int state_number() const;
  // "CurrentState:2,QRResult:A-1,TaskCompleted:False"; with ",Default:<result>;<result>" where they
  // are defaults, as they were not found; after the end and after a fault with
  // ",Reservations:<n>,FirstReservation:<text>,LastReservation:<text>", of which the texts are left
  // out where there is none; after a fault with ",Reason:<text>" as the last.
  std::string InfoText() const;

 private:
  class CourseState;
  struct Jump {
    Index state = 0;
    bool reset = false;
  };

  // Before a tick.
  void OnInput(const fsm::Machine& machine, const fsm::Input& input) override;
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override;

  bool under_way() const {
    const Index state = runner_.state();
    return running() && state != course_.start && state != course_.end && state != course_.error;
  }
  // It stands where it is, and waits for START.
  void Hold(const std::string& why);
  void GoOn();  // by START
  bool waits_for_start() const { return held_from_.has_value(); }
  void Execute(std::string_view command);
  void Stop();
  bool ExecuteSet(std::string_view command);
  bool ExecuteOwn(std::string_view command);
  void SetResult(Index result, Index value);
  void GoTo(std::string_view target);
  void JumpTo(const Jump& jump);
  void ExecuteJump();
  void DropJump(const std::string& why);
  std::string DefaultsText() const;
  std::string ReservationsText() const;
  void Clean(Index detector, Sighting& sighting);
  void Refuse(std::string_view kind, const std::string& why);
  void Record(std::string_view input, std::initializer_list<std::string> words);
  bool running() const { return machine_ != nullptr && machine_->running(); }

  const Course course_;
  RaceOutputs& outputs_;
  Runner runner_;
  RateLimitedLog log_;
  fsm::Machine* machine_ = nullptr;
  fsm::Recorder* recorder_ = nullptr;
  std::optional<Time> first_start_;  // of the machine; times of a recording count from there
  std::vector<std::string> early_commands_;  // before it: recorded with the first tick
  std::optional<Jump> jump_;                 // waits for the reply of a motion
  bool start_counts_ = false;                // no later command has overruled the queued START
  bool decided_ = false;                     // the present change is by a transition of the state
  bool replays_ = false;
  bool resting_ = true;
  bool has_run_ = false;  // since the process began
  std::optional<Time> rested_at_;
  // Breaks in this pause: the clock does not count a suspension. A stop of the process, which it
  // counts, makes the pause longer than it was: START is wanted sooner.
  Duration rest_breaks_{};
  bool on_charger_ = false;
  bool charged_ = false;               // it was put on a charger in this pause
  std::optional<Duration> held_from_;  // of the machine: until START, see Hold()
  Time now_{};
};

}  // namespace musher::race
