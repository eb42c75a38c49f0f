#pragma once
// The show of the wedding robot: its state machine, its inputs and its outputs. Pure: time comes
// in with each call, outputs go to a ShowOutputs.
//
//   face seen           heart or V                 6 s
//   IDLE -> TRACKING ------------> PHOTO_POSING -------> TRACKING
//     ^        | lost for 1.5 s
//     |        v
//     +---- FAREWELL (2 s)                too close, from everywhere -> SAFE_STOP -> IDLE
//
// Threads: one at a time.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "musher/base/rate_limited_log.hpp"
#include "musher/behavior/fsm/machine.hpp"
#include "musher/behavior/fsm/recorder.hpp"
#include "musher/modules/wedding/data/show_data.hpp"
#include "musher/modules/wedding/extension/actions.hpp"
#include "musher/modules/wedding/perception.hpp"
#include "musher/modules/wedding/show_config.hpp"

namespace musher::wedding {

// The interface to what the show controls. Words are those of words.hpp.
class ShowOutputs {
 public:
  virtual ~ShowOutputs() = default;
  virtual void TakePose(std::string_view pose) = 0;  // when it changes
  virtual void LookAt(Gaze gaze) = 0;                // each tick
  virtual void Play(std::string_view sound) = 0;     // once each, in order
  virtual void TakePhoto() = 0;                      // at the shutter
  virtual void RecordVideo(bool on) = 0;             // at the begin and end of an interview
  virtual void SetMotion(
      std::string_view motion) = 0;                    // when it changes, where actions are enabled
  virtual void ShowState(std::string_view state) = 0;  // when it changes
  virtual void Log(const std::string& line) = 0;
};

class Show : private fsm::Listener, private fsm::InputListener {
 public:
  // `stage` outlives it.
  Show(const ShowConfig& config, ShowOutputs& outputs);
  ~Show() override;

  // Registers its states with `machine`, which has none yet, and builds it; `machine` outlives the
  // show. Call it before everything but inputs. Fails with every reason when the states do not fit
  // together.
  Result<> Build(fsm::Machine& machine);

  // Records the inputs from now on; after Build(). The recorder outlives the show.
  void RecordTo(fsm::Recorder& recorder) { recorder_ = &recorder; }
  // Applies a recorded input, for fsm::Replay().
  Result<> Apply(std::string_view input, std::string_view text);

  // --- inputs: each logs what it refuses, and then changes nothing ---

  void OnTarget(const Target& target, Time now);
  void OnGesture(std::string_view word, Time now);
  // `publisher`: the sender; each has its own word. See Perception.
  void OnTooClose(bool too_close, Time now, PublisherId publisher = 0);
  void OnTooClosePublisherLost(PublisherId publisher, Time now);
  void OnFaces(std::string_view json, Time now);
  // stop, idle, photo, tracking, reset; those of the extensions; in upper or lower case. `timely`:
  // why it may be old; then only stop, idle and reset count.
  void OnCommand(std::string_view word, Time now, const Result<>& timely = Ok());
  // photo, interview, stop; none. `timely`: the same.
  void OnVoiceCommand(std::string_view word, Time now, const Result<>& timely = Ok());
  // Energy of the microphone's signal, 0 to 1.
  void OnVoiceLevel(double level, Time now);
  // In any order, with names; without names all 24 in the standard order. `stamp`: when measured.
  void OnJointStates(std::span<const std::string> names, std::span<const double> positions,
                     Duration stamp, Time now);
  // Looks there as long as the request is valid (PerceptionRules::age), whatever is seen.
  void OnLookAt(Gaze gaze, Time now);
  // The camera on the head: its picture size and focal length, both in pixels.
  void OnCamera(double width, double height, double focal_length, Time now);
  void OnJointCommands(std::span<const std::string> names, std::span<const double> positions,
                       Time now);

  // --- lifecycle, around that of the machine: it begins paused ---

  // After each tick of the machine: sends the states' outputs.
  void AfterTick();
  // To the neutral pose, looking ahead, in IDLE. Until Resume() the machine is not ticked.
  // `frozen`: the robot must not be moved, so no output is sent.
  void Pause(Time now, bool frozen = false);
  void Resume(Time now);
  bool resting() const { return resting_; }
  // Periodically, also while paused.
  void PassTime(Time now) { log_.Tick(now); }

  // To IDLE from every state; waiting commands are dropped.
  Result<> Reset(Time now);
  // At once. Fails for an unknown state. To IDLE: as the command does it.
  Result<> Force(std::string_view state, Time now);

  const ShowData& data() const { return data_; }
  // "INVALID" while the machine does not run.
  std::string_view state() const;
  std::uint64_t faults() const { return log_.total(); }

 private:
  // Before a tick: updates the data.
  void OnInput(const fsm::Machine& machine, const fsm::Input& input) override;
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override;

  // Called with each input: when time goes back, earlier samples are dropped.
  void Note(Time now);
  // Logs the error of `result`; `kind`: of RateLimitedLog.
  void Refuse(std::string_view kind, const Result<>& result);
  Result<> TakeJoints(JointAngles& joints, std::span<const std::string> names,
                      std::span<const double> positions);
  void Record(std::string_view input, std::initializer_list<double> numbers);
  void RecordTooClose();
  void Clear();

  const ShowConfig config_;
  ShowOutputs& outputs_;
  ShowData data_;
  Perception perception_;
  std::optional<ActionPlayer> actions_;  // where the config enables them
  std::optional<Time> ticked_at_;        // time base of the actions
  RateLimitedLog log_;
  fsm::Machine* machine_ = nullptr;
  fsm::Recorder* recorder_ = nullptr;
  std::optional<Time> first_start_;       // of the machine; times of a recording count from there
  bool initial_inputs_recorded_ = false;  // the inputs before the first start are recorded
  bool resting_ = true;
  Time now_{};
};

}  // namespace musher::wedding
