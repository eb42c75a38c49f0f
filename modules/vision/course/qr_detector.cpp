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
      : parameters_(std::move(parameters)), repeats_(parameters_.min_repeats) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& /*lens*/) override {
    CourseSight sight;
    sight.sighting = NoSighting();
    box_ = {};
    shown_.clear();
    auto code = FindCode(bgr);
    const bool is_thorough =
        !code && without_code_++ % std::max(1, parameters_.thorough_every) == 0;
    if (!code && !is_thorough) return sight;
    if (!code) code = FindCodeThoroughly(bgr);
    std::optional<std::string> word;
    if (code) {
      word = WordOfCode(code->content, parameters_.words);
      Show(word ? *word : Excerpt(code->content), code->box, bgr, sight);
    } else if (parameters_.letters) {
      if (const auto letters = Reader().Read(bgr)) {
        word = letters->word;
        Show(*word, letters->box, bgr, sight);
      }
    }
    sight.text = repeats_.OnPicture(word);
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    for (const Region& region : parameters_.regions) DrawRegion(bgr, region);
    if (!shown_.empty()) DrawBox(bgr, box_, shown_);
  }

 private:
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
  WordRepeats repeats_;
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
