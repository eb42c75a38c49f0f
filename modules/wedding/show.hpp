#pragma once
// The show of the wedding robot: its state machine, what it knows, and what it wants done. Pure:
// time comes in with each call, what it wants goes to a Stage.
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

#include "musher/behavior/fsm/machine.hpp"
#include "musher/behavior/fsm/recorder.hpp"
#include "musher/modules/wedding/complaints.hpp"
#include "musher/modules/wedding/extension/actions.hpp"
#include "musher/modules/wedding/perception.hpp"
#include "musher/modules/wedding/show_config.hpp"
#include "musher/modules/wedding/show_data.hpp"

namespace musher::wedding {

// What the show has done. Words are those of words.hpp.
class Stage {
 public:
  virtual ~Stage() = default;
  virtual void TakePose(std::string_view pose) = 0;  // when it changes
  virtual void LookAt(Gaze gaze) = 0;                // each tick
  virtual void Play(std::string_view sound) = 0;     // once, in their order
  virtual void TakePhoto() = 0;                      // at the shutter
  virtual void RecordVideo(bool on) = 0;             // at an interview's begin and end
  virtual void SetMotion(
      std::string_view motion) = 0;                    // when it changes, where actions are enabled
  virtual void ShowState(std::string_view state) = 0;  // when it changes
  virtual void Log(const std::string& line) = 0;
};

class Show : private fsm::Listener {
 public:
  // `stage` outlives it.
  Show(const ShowConfig& config, Stage& stage);
  ~Show() override;

  // Registers its states with `machine`, which has none yet, and builds it; it outlives the show.
  // Before all else, but for what comes in. Fails where the states do not fit together, with every
  // reason.
  Result<> Build(fsm::Machine& machine);

  // What comes in is written down there from now on; after Build(). It outlives the show.
  void RecordTo(fsm::Recorder& recorder) { recorder_ = &recorder; }
  // The same again, for fsm::Replay().
  Result<> Apply(std::string_view input, std::string_view text);

  // --- what comes in: each says on the stage what it refuses, and then changes nothing ---

  void OnTarget(const Target& target, Time now);
  void OnGesture(std::string_view word, Time now);
  // `publisher`: of whom; each has its own word. See Perception.
  void OnTooClose(bool too_close, Time now, PublisherId publisher = 0);
  void OnTooClosePublisherLost(PublisherId publisher, Time now);
  void OnFaces(std::string_view json, Time now);
  // stop, idle, photo, tracking, reset; those of the extensions; in any case.
  void OnCommand(std::string_view word, Time now);
  // photo, interview, stop; none.
  void OnVoiceCommand(std::string_view word, Time now);
  // Energy of what is heard, 0 to 1.
  void OnVoiceLevel(double level, Time now);
  // In any order, with names; without names all 24 in theirs. `stamp`: when they were measured.
  void OnJointStates(std::span<const std::string> names, std::span<const double> positions,
                     Duration stamp, Time now);
  // Looks there as long as it counts (PerceptionRules::age), whatever is seen.
  void OnLookAt(Gaze gaze, Time now);
  // The camera on the head: its picture in pixels, and its focal length in pixels.
  void OnCamera(double width, double height, double focal_length, Time now);
  void OnJointCommands(std::span<const std::string> names, std::span<const double> positions,
                       Time now);

  // --- its life, around that of the machine: it begins at rest ---

  // After each tick of the machine: asks the stage for what the states want.
  void AfterTick();
  // To the neutral pose, looking ahead, in IDLE. Until Resume() the machine is not ticked.
  // `frozen`: the robot must not be moved, so nothing is asked of it.
  void Rest(Time now, bool frozen = false);
  void Resume(Time now);
  bool resting() const { return resting_; }
  // Now and then, also while it rests.
  void PassTime(Time now) { complaints_.Tick(now); }

  // To IDLE, whatever there was; commands that wait are swept away.
  Result<> Reset(Time now);
  // At once. Fails for a state that there is not. To IDLE: as the command does it.
  Result<> Force(std::string_view state, Time now);

  const ShowData& data() const { return data_; }
  // "INVALID" while the machine does not run.
  std::string_view state() const;
  std::uint64_t complaints() const { return complaints_.total(); }

 private:
  // Before a tick: brings the data up to date.
  void OnInput(const fsm::Machine& machine, const fsm::Input& input) override;
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override;

  // Of each call: time that went back makes what was seen before meaningless.
  void Note(Time now);
  void Refuse(Complaint kind, const Result<>& result);
  Result<> TakeJoints(JointAngles& joints, std::span<const std::string> names,
                      std::span<const double> positions);
  void Record(std::string_view input, std::initializer_list<double> numbers);
  void RecordTooClose();
  void Settle();

  const ShowConfig config_;
  Stage& stage_;
  ShowData data_;
  Perception perception_;
  std::optional<ActionPlayer> actions_;  // where the config enables them
  std::optional<Time> ticked_at_;        // by which the actions go
  Complaints complaints_;
  fsm::Machine* machine_ = nullptr;
  fsm::Recorder* recorder_ = nullptr;
  std::optional<Time> first_start_;  // of the machine; times of a recording count from there
  bool first_told_ = false;          // what was known before the first start is in the recording
  bool resting_ = true;
  Time now_{};
};

}  // namespace musher::wedding
