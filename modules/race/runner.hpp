#pragma once
// Runs the steps of the course's states, one after the other, and chooses the transition. Pure.
//
//   Enter -> step, step, ... -> a transition    to the next state
//               | a fault                       to on_fault, with the reason
//               | a yellow light                to the light's state; "back" continues the movement
//
// What it is not sure of and goes on from is kept in the memory as a reservation.
//
// Times: `now` is that of the machine, which stands still in a pause; `time` that of the actuator's
// clock, for the age of pictures. One thread.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/race/lane_walker.hpp"
#include "musher/modules/race/light_watch.hpp"
#include "musher/modules/race/locomotion.hpp"
#include "musher/modules/race/memory.hpp"
#include "musher/modules/race/perception.hpp"
#include "musher/modules/race/voice.hpp"

namespace musher::race {

class Runner {
 public:
  // `course` and `outputs` outlive it.
  Runner(const Course& course, RaceOutputs& outputs);

  // `by_decision`: of the state before, by one of its transitions; else by a command.
  void Enter(Index state, bool by_decision, Duration now);
  // Each tick; returns the state to go to. While `held`, nothing moves.
  std::optional<Index> Advance(Duration now, Time time, bool held);
  void Leave();

  // `time` is that of the actuator's clock, as of OnOdometry().
  void Pause(Time time);
  void Resume(Duration now);
  // After it was held for so long, which counts toward no limit. Its place may have changed: it is
  // compared once more.
  void GoOn(Duration now, Duration held);
  // Odometry counts: during a walk, where the robot comes to rest in a pause, and after it.
  bool WantsOdometry(Time time) const {
    return locomotion_.streaming() || lane_walker_.under_way() || PoseOfRestAt(time) ||
           checks_pose_from_.has_value();
  }
  // See Locomotion::OnOdometry().
  void OnOdometry(std::int64_t stamp_ns, const navigation::Pose& pose, Duration age, Time time);
  // Found outside of it: the next tick takes the state's way of a fault.
  void OnFault(const std::string& reason) { outside_fault_ = reason; }
  // The steps that are left are dropped: the next tick takes a transition.
  void SkipSteps();

  Memory& memory() { return memory_; }
  const Memory& memory() const { return memory_; }
  Perception& perception() { return perception_; }
  Locomotion& locomotion() { return locomotion_; }
  const Locomotion& locomotion() const { return locomotion_; }
  LaneWalker& lane_walker() { return lane_walker_; }
  Voice& voice() { return voice_; }
  Index state() const { return state_; }
  // Of the last fault; empty: none since the last start of a run.
  const std::string& reason() const { return reason_; }
  void ForgetReason() { reason_.clear(); }

 private:
  static constexpr Duration kBlind = Milliseconds(1000);  // of a course without a light

  // What the pictures of a look say, one after the other.
  struct Agreement {
    std::optional<std::uint64_t> picture;  // the newest, see Perception::Pictures()
    std::optional<Index> word;             // the last one
    int in_row = 0;                        // pictures with this word
    int pictures = 0;
    int clear = 0;  // of them without a doubt
  };
  // Where the present state is.
  struct Activity {
    Index step = 0;
    int phase = 0;     // of the step
    Duration since{};  // of the phase
    Time after{};      // pictures taken before do not count
    int tries = 0;     // corrections or retries
    // Of a check: it has stepped back, and is still behind its place; why it is given up there.
    bool stepped_back = false;
    bool is_behind = false;
    std::string given_up{};
    std::string contradiction{};        // of two cameras
    double corrected_m = 0;             // of a check: along its first correction
    std::optional<Twist> correction{};  // the way of the first one
    Agreement agreed{};
    std::optional<Duration> sampled_since{};  // of a look: the first picture that counts
    // Of a walk until a sight: there is no new picture, or the thing is hidden, since then.
    std::optional<Duration> stale_since{};
    std::optional<Duration> hidden_since{};
    bool hidden_over = false;  // it is not waited for until it was seen
    bool other_phase = false;  // a picture of the walk had another phase than the wanted one
  };
  struct Interrupted {
    Index state = 0;
    Index previous = 0;
    Activity activity;
    WalkProgress walk;                 // of a movement,
    std::optional<LaneProgress> lane;  // or that of the line walker
    bool unsure = false;               // as of the state that was left
    bool unsure_before = false;
    bool by_command = false;
  };
  enum class Outcome : std::uint8_t {
    kRunning,
    kDone,
    kSkipped,  // took no time
    kTarget    // a state to go to, in target_
  };

  bool PoseOfRestAt(Time time) const;
  void ComparePose(Duration now);
  // After a pause the steps wait until a pose shows that it was not moved in it. False: go on.
  bool ChecksPose(Duration now);
  std::optional<Index> RunSteps(Duration now, Time time);
  std::optional<Index> Fail(const std::string& reason);
  std::optional<Index> ChooseTransition();
  bool Holds(const TransitionRule& transition) const;
  // Its conditions but that on a result.
  bool HoldsBesideResult(const TransitionRule& transition) const;

  Outcome Run(const MoveStep& step, Duration now, Time time);
  Outcome Run(const CheckStep& step, Duration now, Time time);
  Outcome Run(const WaitStep& step, Duration now, Time time);
  Outcome Run(const UntilStep& step, Duration now, Time time);
  // Whether the sighting of a walk until a sight is its end.
  bool Ends(const Until& until, const Sighting& sighting);
  // Whether a walk until a sight stands until there is a new picture, or what hides the thing is
  // gone.
  bool WaitsForSight(const Until& until, const Sighting* sighting, Duration now);
  Outcome Run(const WalkStep& step, Duration now, Time time);
  Outcome Run(const SayStep& step, Duration now, Time time);
  Outcome Run(const CountStep& step, Duration now, Time time);

  // Advances the walk or motion under way. kDone, kRunning, or kTarget: a light has stopped it.
  Outcome Advance(Duration now, Time time);
  // The same of the line walker's walk.
  Outcome AdvanceLane(const LaneWalk& walk, Duration now, Time time);
  // The good end of a walk: whether the lane is as long, by odometry.
  Outcome EndLane(const LaneWalk& walk, Time time);
  // In a state with light = true each walk needs its pictures; a walk ahead or along a lane stops
  // by them.
  bool NeedsLight() const;
  bool StopsByLight() const;
  bool InLane() const;
  // Its detector needs a moment to start: before a walk.
  void WantLight();
  bool Walks(const Step& step) const;
  // No picture of the last LightRule::blind could show the light: the walk waits for one, at most
  // CheckRules::silent, which is then a fault.
  bool Blind(Duration now, Time time);
  void SeesAgain() {
    blind_since_.reset();
    blind_said_ = false;
  }
  bool StoppedByLight(Duration now, Time time);
  // Leaves the state for that of the light.
  void Interrupt();
  Duration blind() const { return course_.light ? course_.light->blind : kBlind; }
  void Steer(const std::optional<Index>& keep, Duration now, Time time);
  // The lane has not been seen for kUnseenTimes times Keep::fresh: the walk waits for it, at most
  // kLongestUnseen, which is then a fault.
  bool Unseen(Duration now);
  bool WalkEndsSoon() const;
  void WantNext();
  void WantForCheck(const Check& check);
  // Once for each text, at most some of a state.
  void ReportUnknown(const Wait& wait, const std::string& text);
  std::optional<LineWord> Word(const Check& check, bool after_turn);
  // What the check of another camera says against this word; empty: nothing.
  std::string Contradiction(const Check& check, LineWord word, bool after_turn) const;
  // By the box of a thing whose text is a value that its detector is to find.
  std::optional<LineWord> BoxWord(const Check& check, const Sighting& sighting) const;
  // The word, where the last pictures with one have the same, and no more of the pictures were
  // in doubt than not: one picture decides nothing.
  std::optional<Index> Agreed(Index detector, std::optional<Index> word, bool clear);
  Outcome Look(const Check& check, bool after_turn, Duration now);
  // A sample that is new enough for the present check.
  bool HasSample(const Check& check) const;
  // Where it stands now no word was found: it looks from farther away, or ends.
  Outcome LookFromBehind(const Check& check, bool after_turn, const std::string& why, Duration now);
  // The check is over, without a reason or given up: first it goes back to its place.
  Outcome EndCheck(const Check& check, bool after_turn, const std::string& why, Duration now);
  // Whether its corrections lead ahead or back: then it needs no way back to its place.
  bool CorrectsTheWay(const Check& check, bool after_turn) const;
  Outcome GiveUpCheck(const Check& check, const std::string& why);
  // Adds a walk to the way since the place was right.
  void CountWay(const WalkProgress& walk);
  // Along the way of the twist.
  void PlaceIsRight(const Twist& twist);
  // Of the correction along the first one of this check, or against it.
  double MetresAlong(const Stretch& correction) const;
  // Why odometry is against the correction: with it the place would differ by more than odometry
  // can be off; empty: it is not.
  std::string AgainstOdometry(const Stretch& correction) const;
  // Back to where the check began, and then it is given up.
  Outcome TakeBack(const Check& check, bool after_turn, const std::string& why, Duration now);
  Outcome FindResult(const Wait& wait, Duration now, Time time);
  Outcome GiveUp(const Otherwise& otherwise, const std::string& what);
  // Whether the step is left out, as the sight was not found.
  bool LeftOut(const std::optional<Index>& only, const std::string& what);
  void Reserve(const std::string& reason) { memory_.Reserve({rule().name, reason}); }
  // What odometry says against the last walk, or that it says nothing: that once a run.
  void ReserveDistances();
  // That its place after a pause is not known.
  void ReservePose();
  // At the end of a run.
  void ReportReservations();
  void Phase(int phase, Duration now) {
    at_.phase = phase;
    at_.since = now;
    at_.agreed = {};
    at_.sampled_since.reset();
  }
  int StepsOf(Duration time) const {
    return static_cast<int>((time + course_.step / 2) / course_.step);
  }
  void Log(const std::string& line) { outputs_.Log(rule().name + ": " + line); }
  const StateRule& rule() const { return course_.states[state_]; }
  bool idle() const { return state_ == course_.start || state_ == course_.end; }

  const Course& course_;
  RaceOutputs& outputs_;
  Memory memory_;
  Perception perception_;
  Locomotion locomotion_;
  LaneWalker lane_walker_;
  Voice voice_;
  std::optional<LightWatch> light_;
  Index state_ = 0;
  Index previous_ = 0;
  Activity at_;
  std::optional<Interrupted> interrupted_;
  bool light_stops_ = false;  // the state is left for the light's
  bool returns_ = false;      // and now back again
  bool skips_ = false;        // see SkipSteps()
  bool blind_ = false;        // in this tick
  std::optional<Duration> blind_since_;
  bool blind_said_ = false;               // in the log
  std::optional<Index> keep_;             // of the walk under way
  std::optional<Duration> unseen_since_;  // its lane
  bool unseen_said_ = false;              // in the log
  std::string unseen_why_;
  bool by_time_ = false;  // a walk of this run went by its time, without odometry
  // A check of this state was given up, a walk not confirmed, or the place after a pause is not
  // known.
  bool unsure_ = false;
  bool unsure_before_ = false;  // one of the state before
  bool by_command_ = false;     // this state was entered by a command, wherever the robot was
  // How far it has walked since its place was known, ahead of it and aside; nothing: it was not.
  struct WaySince {
    double m = 0;
    bool known = false;
  };
  WaySince ahead_since_, aside_since_;
  Index target_ = 0;
  std::optional<Time> paused_at_;
  bool place_checked_ = true;                  // since the pause before
  bool keeps_rest_pose_ = false;               // in this pause: that of the one before counts
  std::optional<navigation::Pose> rest_pose_;  // where it has come to rest in the pause
  std::optional<Duration> checks_pose_from_;   // after the pause
  std::string moved_;                          // in the pause
  std::vector<std::string> unknown_;           // texts without a meaning, in this state
  std::string fault_;                          // found by a step in this tick
  std::string outside_fault_;
  std::string reason_;
};

}  // namespace musher::race
