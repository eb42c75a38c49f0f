#pragma once
// A course as data: movements, checks, waits, states and the transitions between them.
// course_reader.hpp reads it from a TOML file, whose head explains every key;
// config/race/course.toml is the course of the race. Names are those of the file; inside, things
// are referred to by their index.
//
// Frame of a twist: that of the body, x ahead, y to the left, yaw to the left. Units are last in a
// name; a Duration of the machine's clock otherwise.
//
// Threads: immutable once it is read.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/race/hall.hpp"

namespace musher::race {

using Index = std::size_t;

inline constexpr int kMostSteps = 10'000;          // of one movement
inline constexpr Index kInterrupted = Index(-1);   // as a target: the state that the light has left
inline constexpr std::string_view kBack = "back";  // its word in the file

// A motion that fails, or a line walker that ends, counts so long after it: an emergency stop
// reaches other programs, too, and what they report of it may arrive before the robot's pause.
inline constexpr Duration kStopGrace = Milliseconds(300);

// A topic of a detector: of modules/vision a musher_msgs/Sighting or musher_msgs/YellowLines for
// each picture; of any other node a std_msgs/String with a word when it sees one ("A-1", "left").
struct Detector {
  enum class Kind : std::uint8_t { kSighting, kLines, kText };

  std::string name;
  std::string topic;
  Kind kind = Kind::kSighting;
};

struct Twist {
  double forward_m_s = 0;
  double left_m_s = 0;
  double yaw_rad_s = 0;

  bool turns() const { return forward_m_s == 0 && left_m_s == 0 && yaw_rad_s != 0; }

  friend bool operator==(const Twist&, const Twist&) = default;
};

// A walk in steps (a servo stream), or a motion with an end (a result command).
struct Movement {
  std::string name;
  bool walks = false;
  std::int32_t motion_id = 0;
  // Of a walk.
  Twist twist;
  std::array<double, 2> step_height_m{0.05, 0.05};  // front and rear
  int count = 10;                                   // steps where a state gives none
  double odometry_share = 1;                        // of the twist, as odometry usually shows it
  // Of a result command.
  Duration before{};  // the pause before it
  Duration after{};   // and after its reply
  Duration limit = Milliseconds(30'000);
};

// So many steps of a walk.
struct Stretch {
  Index movement = 0;
  int count = 1;
};

// Words from outside are the same in upper and lower case.
bool SameWord(std::string_view a, std::string_view b);

// The word of a picture of lines.
enum class LineWord : std::uint8_t { kLeft, kRight, kFront, kBack, kCenter };
// "left"; nothing for another word.
std::optional<LineWord> LineWordOf(std::string_view word);
std::string_view Name(LineWord word);

// By LineWord, but of kCenter: right as that is, without a correction.
using Accepted = std::array<bool, 4>;

using Corrections = std::array<std::optional<Stretch>, 4>;  // by LineWord, but of kCenter

// So long a walk until a sight waits for a thing that is hidden.
inline constexpr Duration kLongestHidden = Milliseconds(10'000);

struct Check {
  std::string name;
  Index detector = 0;
  enum class By : std::uint8_t { kYcy, kDy, kBox };  // words of the lines, or the thing's box

  By by = By::kYcy;
  double threshold = 0.04;  // of a box: a smaller offset, as a share of the width, is "center"
  Corrections usual;        // after a movement ahead, back or aside
  Corrections after_turn;   // after a turn
  Accepted accepted{};
  std::optional<int> max_corrections;  // else that of CheckRules
  bool required = false;               // given up, it is a fault
  // A check of another camera that sees the same: a picture whose correction is the opposite of
  // that one's is in doubt.
  std::optional<Index> agrees_with;
};

// Once, where a check has no word, before it is given up: it looks from farther away.
struct StepBack {
  Stretch away;
  Stretch back;  // to its place again, where the check does not correct the way itself
};

// Keeps a walk in the middle between two lines: it turns towards their middle.
struct Keep {
  std::string name;
  Index detector = 0;
  double yaw_rad_s = 2;     // for an offset of the middle by the whole width of the region
  double most_rad_s = 0.3;  // either way
  Duration fresh = Milliseconds(500);  // an older picture does not count
  bool one_line = false;               // of one line the middle is known: the camera has a mount
};

struct CheckRules {
  int max_corrections = 3;
  Duration settle = Milliseconds(500);     // how much newer than a movement a picture has to be
  Duration picture = Milliseconds(3000);   // how long such a picture is waited for
  Duration open = Milliseconds(2000);      // a detector is opened so long before the movement's end
  Duration silent = Milliseconds(10'000);  // a wanted detector without a sample has failed
  int most_given_up = 0;                   // of a run; one more is a fault. 0: no limit
  int agreeing = 2;                        // pictures in a row with the same word, until it counts
  // So far odometry may be off where a check corrects the place, beside a share of the way since it
  // was right: a correction that is larger is not believed. 0: not checked.
  double most_off_m = 0;
  double most_off_share = 0.12;
  std::optional<StepBack> step_back;  // nothing: a check is given up where it stands
};

// Walks by the distance that odometry shows, and not by their time alone.
struct OdometryRules {
  std::string topic;                   // empty: by their time
  double least_share = 0.8;            // a walk takes at least this share of its time
  double most_share = 1.25;            // and at most this one
  Duration fresh = Milliseconds(300);  // without a new sample for so long it is not believed
  Duration begin = Milliseconds(800);  // so long the body accelerates: the time counts
  double most_turned_rad = 0.3;        // of a straight walk: more is a fault. 0: not checked
  double blocked_share = 0.5;  // a walk that shows less of its way is a fault. 0: not checked
  double most_moved_m = 0.15;  // in a pause: more is a fault. 0: not checked
  double most_moved_rad = 0.2;

  bool used() const { return !topic.empty(); }
};

// When the body counts as lost.
struct BodyRules {
  Duration silent = Milliseconds(2000);   // during a walk without motion_status; 0: not checked
  Duration refused = Milliseconds(1000);  // so long its servo frames are refused
};

// A text that is found on the course or set by a command: "A-1", "left".
struct ResultRule {
  std::string name;
  std::vector<std::string> values;
  std::optional<Index> by_default;  // of values
  std::string command;              // "SET_QR_A"; empty: none
  bool once = false;                // a command does not replace a known value
  bool shown = false;               // as QRResult in state_info
};

// Where a step leads that has not found what it waits for.
struct Otherwise {
  enum class Kind : std::uint8_t { kContinue, kDefault, kState };

  Kind kind = Kind::kContinue;
  Index state = 0;
};

// For the text of a detector, or, without a detector, for a time.
struct Wait {
  std::string name;
  Duration limit{};  // each time
  std::optional<Index> detector;
  Index result = 0;
  int retries = 0;  // after each limit: `retry`, and again
  Stretch retry;
  std::optional<Index> adds;  // the counter of the steps of those retries
  Otherwise otherwise;
};

// A walk that ends when a detector reports a phase.
struct Until {
  std::string name;
  Index detector = 0;
  std::string phase;
  Stretch most;
  Otherwise otherwise;
};

// The walk along a lane by the line walker.
struct LaneWalk {
  std::string name;
  std::string command;  // topics
  std::string status;
  std::string end = "course_end";  // the good end
  Duration limit = Milliseconds(60'000);
  Duration silent = Milliseconds(3000);  // without a status the walker has failed
  int retries = 0;                       // after another end: it is started again
  Duration retry_after = Milliseconds(2000);
  // From its begin straight to its end, by odometry: the end nearer than the first is another line
  // that was taken for it, and beyond the second it was passed. 0: not checked.
  double least_m = 0;
  double most_m = 0;
  Otherwise otherwise;  // after a limit, or another end and all retries
};

struct Phrase {
  std::string chinese;
  std::string english;
};
struct Speech {
  struct OfValue {
    Index value = 0;
    Phrase phrase;
  };

  std::string name;
  std::vector<Phrase> phrases;  // one after the other
  Duration every{};             // from the begin of one to that of the next
  std::optional<Index> result;  // then one of `of_values` is spoken
  std::vector<OfValue> of_values;
  Duration limit = Milliseconds(10'000);
};

// A step of a state.
struct MoveStep {
  Index movement = 0;
  int count = 0;              // of a walk
  std::optional<Index> less;  // the counter that is subtracted from it
  int beyond = 0;             // of the counter only what is more than this
  std::optional<Index> keep;
  std::optional<Index> only;  // left out where this walk until a sight has not found it
};
struct CheckStep {
  Index check = 0;
  bool after_turn = false;
};
struct WaitStep {
  Index wait = 0;
};
struct UntilStep {
  Index until = 0;
  std::optional<int> most;      // instead of that of the until
  std::optional<Index> stores;  // the counter that gets the steps made
  std::optional<Index> keep;
};
struct WalkStep {
  Index walk = 0;
};
struct SayStep {
  Index speech = 0;
  // Said instead where the result of the speech is its default, or, of a speech without one, where
  // a check of this state or of the one before was given up.
  std::optional<Index> unsure;
  std::optional<Index> only;  // as of MoveStep
};
struct CountStep {
  Index counter = 0;
  int number = 0;
  bool adds = false;          // else it sets
  std::optional<Index> only;  // as of MoveStep
};
using Step = std::variant<MoveStep, CheckStep, WaitStep, UntilStep, WalkStep, SayStep, CountStep>;

// A transition from a state, taken when all of its conditions hold; the first such transition is
// taken.
struct TransitionRule {
  std::optional<Index> result;  // has the value `is`
  Index is = 0;
  std::vector<Index> from;  // the state before is one of these; empty: any
  std::optional<Index> counter;
  std::optional<int> below;     // the counter is below it
  std::optional<int> at_least;  // or at least this
  Index to = 0;

  bool always() const { return !result && from.empty() && !counter; }
};

struct StateRule {
  std::string name;
  int number = 0;
  std::vector<Step> steps;
  std::vector<TransitionRule> transitions;
  bool light = false;  // a yellow light stops its movements ahead
  Index on_fault = 0;
};

struct LightRule {
  Index detector = 0;
  double within_m = 0.7;
  Index state = 0;                        // that is entered
  Duration clear = Milliseconds(2000);    // out of sight for so long, the next one is another light
  Duration again = Milliseconds(10'000);  // after so long the same one stops the movement again
  Duration blind = Milliseconds(1000);    // without a picture for so long the movement stands still
};

// A command that sets a counter and leaves states.
struct CourseCommand {
  std::string name;
  std::vector<Index> accepted;  // in these states
  std::vector<Index> leaves;    // these of them at once, by their transitions
  std::optional<Index> counter;
  int value = 0;
};

// How a self-check treats another program.
enum class Need : std::uint8_t { kRequired, kOptional, kNone };

// The actuator around the course.
struct RobotRules {
  bool from_start = false;                        // after a pause; else where it was
  Duration resume_within = Milliseconds(60'000);  // after a longer pause only by START; 0: always
  std::string record;                             // a file; empty: nothing is recorded
  Duration self_check = Milliseconds(5000);  // of the steady clock, until all programs are there
  Need motion = Need::kRequired;
  Need cameras = Need::kRequired;  // the publishers of all detectors
  Need walker = Need::kRequired;
  Need audio = Need::kOptional;
};

enum class Language : std::uint8_t { kChinese, kEnglish };

struct Course {
  Duration step = Milliseconds(200);
  Language language = Language::kChinese;
  Index start = 0;
  Index end = 0;
  Index error = 0;
  Index stand = 0;  // the result command before an interrupted movement continues
  CheckRules check;
  BodyRules body;
  OdometryRules odometry;
  RobotRules robot;
  Hall hall;  // for which the counts are
  std::optional<LightRule> light;
  std::vector<Detector> detectors;
  std::vector<Movement> movements;
  std::vector<std::string> counters;
  std::vector<ResultRule> results;
  std::vector<Check> checks;
  std::vector<Keep> keeps;
  std::vector<Wait> waits;
  std::vector<Until> untils;
  std::vector<LaneWalk> walks;
  std::vector<Speech> speeches;
  std::vector<CourseCommand> commands;
  std::vector<StateRule> states;
};

// The index of the thing with this name.
template <class Things>
std::optional<Index> FindByName(const Things& things, std::string_view name) {
  for (Index i = 0; i < things.size(); ++i) {
    if (things[i].name == name) return i;
  }
  return std::nullopt;
}

// The longest stay in a state of a robot that is neither paused nor stopped by a light.
Duration LongestStay(const Course& course, Index state);

// The states that a state may lead to, without repetition: by its transitions, its limits, the
// light and faults. `back`: with those that a light may have interrupted, of a state that leads
// back.
std::vector<Index> Successors(const Course& course, Index state, bool back = true);

}  // namespace musher::race
