#include <algorithm>
#include <stdexcept>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/words.hpp"

namespace musher::vision {
namespace {

class QrDetector : public CourseDetector {
 public:
  explicit QrDetector(QrParameters parameters)
      : parameters_(std::move(parameters)),
        codes_(parameters_.min_repeats),
        letters_(parameters_.letter_repeats) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& /*lens*/) override {
    CourseSight sight;
    sight.sighting = NoSighting();
    box_ = {};
    shown_.clear();
    auto code = FindCode(bgr);
    // Letters that were read once are looked for again at once.
    const bool is_thorough =
        !code &&
        (letters_.is_pending() || without_code_++ % std::max(1, parameters_.thorough_every) == 0);
    if (!code && !is_thorough) return sight;
    bool shows_patterns = false;
    if (!code) {
      const ThoroughLook look = LookThoroughly(bgr);
      code = look.code;
      shows_patterns = look.shows_patterns;
    }
    if (code) {
      OnCode(*code, bgr, sight);
    } else {
      LookForLetters(bgr, shows_patterns, sight);
    }
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    DrawRegion(bgr, {0, 1, 0, 1});  // all of it is searched
    for (const Region& region : parameters_.regions) DrawRegion(bgr, region);
    if (!shown_.empty()) DrawBox(bgr, box_, shown_);
  }

 private:
  // The word of the largest code that has one: a label beside a board is no board.
  void OnCode(const CodeFound& code, const cv::Mat& bgr, CourseSight& sight) {
    letters_.OnPicture(std::nullopt);
    const CodeFound* board = &code;
    auto word = WordOfCode(code.content, parameters_.words);
    for (const CodeFound& smaller : code.smaller) {
      const auto other = WordOfCode(smaller.content, parameters_.words);
      if (!other || other == word) continue;
      if (!word) {
        board = &smaller;
        word = other;
      } else if (IsNearlyAsLarge(smaller, *board)) {
        const auto& [first, second] = std::minmax(*word, *other);
        return OnTwoBoards(first + ", " + second, board->box, bgr, sight);
      }
    }
    sight.text = codes_.OnPicture(word);
    Show(word ? *word : Excerpt(code.content), board->box, bgr, sight);
    if (word && !sight.text) sight.sighting->text.clear();
    // It is right by its own check sum.
    if (sight.text) sight.sighting->confidence = 1;
  }

  static bool IsNearlyAsLarge(const CodeFound& code, const CodeFound& other) {
    constexpr double kNearly = 0.5;  // of its area
    return code.box.area() >= kNearly * other.box.area();
  }

  // Which of them is meant is not known.
  void OnTwoBoards(const std::string& words, const cv::Rect& box, const cv::Mat& bgr,
                   CourseSight& sight) {
    codes_.OnPicture(std::nullopt);
    Show(words, box, bgr, sight);
  }

  void LookForLetters(const cv::Mat& bgr, bool shows_patterns, CourseSight& sight) {
    codes_.OnPicture(std::nullopt);
    if (!parameters_.letters) return;
    std::optional<LettersFound> letters;
    if (!shows_patterns) letters = Reader().Read(bgr);
    sight.text = letters_.OnPicture(letters ? std::optional(letters->word) : std::nullopt);
    if (!letters) return;
    Show(letters->word, letters->box, bgr, sight);
    if (!sight.text) return sight.sighting->text.clear();
    const double least = parameters_.least_confidence;
    sight.sighting->confidence =
        ConfidenceBy({(letters->confidence - least) / std::max(1.0, 100 - least)});
  }

  void Show(const std::string& text, const cv::Rect& box, const cv::Mat& bgr, CourseSight& sight) {
    box_ = box;
    shown_ = text;
    sight.sighting = SightingAt(box, bgr.size());
    sight.sighting->text = text;
  }

  LetterReader& Reader() {
    if (!reader_) {
      auto made = LetterReader::Make(parameters_);
      if (!made) throw std::runtime_error(made.error().message);
      reader_ = std::move(made).value();
    }
    return *reader_;
  }

  const QrParameters parameters_;
  std::unique_ptr<LetterReader> reader_;
  WordRepeats codes_;
  WordRepeats letters_;
  unsigned without_code_ = 0;  // pictures
  cv::Rect box_;
  std::string shown_;
};

}  // namespace

std::unique_ptr<CourseDetector> MakeQrDetector(const QrParameters& parameters) {
  return std::make_unique<QrDetector>(parameters);
}

Result<> CheckLetters(const QrParameters& parameters) {
  if (!parameters.letters) return Ok();
  const auto reader = LetterReader::Make(parameters);
  if (!reader) return reader.error();
  return Ok();
}

}  // namespace musher::vision
