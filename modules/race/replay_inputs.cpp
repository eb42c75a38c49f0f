// Applies the recorded inputs of a race.

#include "musher/modules/race/race.hpp"
#include "musher/modules/race/recording.hpp"

namespace musher::race {
namespace {

struct Kind {
  std::string_view name;
  std::size_t words;
};
constexpr std::array<Kind, 15> kKinds = {{{input::kSighting, 8},
                                          {input::kLines, 7},
                                          {input::kDoubt, 2},
                                          {input::kWalker, 2},
                                          {input::kMotionDone, 3},
                                          {input::kSpoken, 3},
                                          {input::kOdometry, 5},
                                          {input::kBody, 2},
                                          {input::kServo, 2},
                                          {input::kCharger, 1},
                                          {input::kTwoPublishers, 1},
                                          {input::kCommand, 1},
                                          {input::kRest, 0},
                                          {input::kResume, 0},
                                          {input::kBreak, 1}}};

constexpr std::int64_t kMostNs = 1'000'000'000'000'000'000;  // 31 years

Error NoTime() {
  return {kCodeFailed, "expected a time of at most 10^18 ns since the start"};
}

// The words of an input as numbers; the first that is none is the error.
class Numbers {
 public:
  explicit Numbers(const InputWords& input) : input_(input) {}

  template <class Number>
  Number Integer(std::size_t word) {
    const Result<std::int64_t> read = ReadInteger(input_.words[word]);
    if (!read && result_) result_ = read.error();
    return read ? static_cast<Number>(read.value()) : Number{};
  }
  double Real(std::size_t word) {
    const Result<double> read = ReadNumber(input_.words[word]);
    if (!read && result_) result_ = read.error();
    return read ? read.value() : 0;
  }
  // A time in ns, of which the sum with another one has a place.
  Duration Nanoseconds(std::size_t word) {
    const auto ns = Integer<std::int64_t>(word);
    const bool has_place = ns >= -kMostNs && ns <= kMostNs;
    if (!has_place && result_) result_ = NoTime();
    return Duration(has_place ? ns : 0);
  }
  // Of an error's code and message.
  Result<> Outcome(std::size_t word) {
    const auto code = Integer<std::int32_t>(word);
    return code == 0 ? Ok() : Error{code, input_.words[word + 1]};
  }
  const Result<>& result() const { return result_; }

 private:
  const InputWords& input_;
  Result<> result_;
};

}  // namespace

Result<> Race::Apply(std::string_view input, std::string_view text) {
  const auto* const kind =
      std::ranges::find_if(kKinds, [&](const Kind& known) { return known.name == input; });
  if (kind == kKinds.end()) {
    return Error{kCodeFailed, "the race has no input '" + std::string(input) + "'"};
  }
  Result<InputWords> read = ReadInput(text, kind->words);
  const bool has_grown = input == input::kLines || input == input::kSighting;
  if (!read && has_grown) {  // of an earlier version, without a doubt or a confidence
    read = ReadInput(text, kind->words - 1);
    if (read) read.value().words.emplace_back(input == input::kLines ? "" : "0");
  }
  if (!read) return read.error();
  if (!first_start_) return Error{kCodeFailed, "an input before the first start"};
  replays_ = true;
  const std::vector<std::string>& words = read.value().words;
  Numbers numbers(read.value());
  const auto taken = [&] { return *first_start_ + numbers.Nanoseconds(1); };
  if (read.value().at > Duration(kMostNs) || read.value().at < -Duration(kMostNs)) return NoTime();
  const Time now = *first_start_ + read.value().at;
  if (input == input::kSighting) {
    OnSighting(numbers.Integer<Index>(0),
               {numbers.Integer<int>(2) != 0, numbers.Real(3), words[4], words[5], numbers.Real(6),
                numbers.Real(7)},
               taken(), now);
  } else if (input == input::kLines) {
    OnLines(numbers.Integer<Index>(0), numbers.Integer<std::uint32_t>(2), words[3], words[4],
            numbers.Real(5), taken(), now, words[6]);
  } else if (input == input::kDoubt) {
    OnDoubt(numbers.Integer<Index>(0), words[1], now);
  } else if (input == input::kWalker) {
    OnWalkerStatus(numbers.Integer<Index>(0), words[1], now);
  } else if (input == input::kMotionDone) {
    OnMotionDone(numbers.Integer<std::uint64_t>(0), numbers.Outcome(1), now);
  } else if (input == input::kSpoken) {
    OnSpoken(numbers.Integer<std::uint64_t>(0), numbers.Outcome(1), now);
  } else if (input == input::kOdometry) {
    OnOdometry(numbers.Integer<std::int64_t>(0),
               {{numbers.Real(2), numbers.Real(3)}, numbers.Real(4)}, taken(), now);
  } else if (input == input::kBody) {
    OnBody(numbers.Integer<int>(0), numbers.Integer<int>(1), now);
  } else if (input == input::kServo) {
    OnServoReply(numbers.Integer<int>(0) != 0, numbers.Integer<std::int32_t>(1), now);
  } else if (input == input::kCharger) {
    OnCharger(numbers.Integer<int>(0) != 0, now);
  } else if (input == input::kTwoPublishers) {
    const auto detector = ReadInteger(words[0]);
    const auto index = detector ? static_cast<Index>(detector.value()) : course_.detectors.size();
    const bool is_detector = index < course_.detectors.size();
    OnTwoPublishers(is_detector ? course_.detectors[index].topic : words[0], now);
  } else if (input == input::kCommand) {
    OnCommand(words[0], now);
  } else if (input == input::kRest) {
    Pause(now);
  } else if (input == input::kBreak) {
    OnBreak(numbers.Nanoseconds(0), now);
  } else {
    Resume(now);
  }
  return numbers.result();
}

}  // namespace musher::race
