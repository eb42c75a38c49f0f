#include <tesseract/baseapi.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "musher/modules/vision/course/glyphs.hpp"
#include "musher/modules/vision/course/qr_finder.hpp"
#include "musher/modules/vision/course/words.hpp"
#include "musher/modules/vision/picture/vision_code.hpp"

// Of the OpenMP library that Tesseract uses.
extern "C" void omp_set_max_active_levels(int levels);

namespace musher::vision {
namespace {

// Dark letters of that height, on white, with a rim.
cv::Mat LinePicture(const cv::Mat& grey, const cv::Rect& line, double letter_px) {
  constexpr int kRimPx = 20;
  const cv::Rect crop = cv::Rect(line.x - 1, line.y - 1, line.width + 2, line.height + 2) &
                        cv::Rect({0, 0}, grey.size());
  const double scale = letter_px / line.height;
  cv::Mat letters;
  cv::resize(grey(crop), letters, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  cv::threshold(letters, letters, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::copyMakeBorder(letters, letters, kRimPx, kRimPx, kRimPx, kRimPx, cv::BORDER_CONSTANT,
                     cv::Scalar(255));
  return letters;
}

cv::Mat RegionPicture(const cv::Mat& grey, const cv::Rect& region, double scale) {
  cv::Mat letters;
  cv::resize(grey(region), letters, {}, scale, scale, cv::INTER_CUBIC);
  cv::threshold(letters, letters, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  return letters;
}

std::string PackageOf(const std::string& language) {
  std::string name = language;
  for (char& c : name) c = c == '_' ? '-' : c;
  return "tesseract-ocr-" + name;
}

std::string PackagesOf(const std::string& languages) {
  std::string packages;
  std::size_t from = 0;
  while (from <= languages.size()) {
    const std::size_t to = std::min(languages.find('+', from), languages.size());
    packages += (packages.empty() ? "" : " ") + PackageOf(languages.substr(from, to - from));
    from = to + 1;
  }
  return packages;
}

}  // namespace

struct LetterReader::Engine {
  tesseract::TessBaseAPI api;
  int least_confidence_read = 100;  // since a line or region was begun

  ~Engine() { api.End(); }

  std::string Text(const cv::Mat& letters, int page_mode, double least_confidence) {
    // It scales each line to one height: a strip of a picture would take minutes, and has no word.
    constexpr int kMostAspect = 40;
    const auto [shorter, longer] = std::minmax(letters.cols, letters.rows);
    if (longer > kMostAspect * shorter) return "";
    api.SetPageSegMode(static_cast<tesseract::PageSegMode>(page_mode));
    api.SetImage(letters.data, letters.cols, letters.rows, 1, static_cast<int>(letters.step));
    constexpr int kDotsPerInch = 300;  // else it estimates, and prints so
    api.SetSourceResolution(kDotsPerInch);
    const std::unique_ptr<char[]> text(api.GetUTF8Text());
    const bool is_sure = text && api.MeanTextConf() >= least_confidence;
    if (is_sure) least_confidence_read = std::min(least_confidence_read, api.MeanTextConf());
    return is_sure ? text.get() : "";
  }
};

Result<std::unique_ptr<LetterReader>> LetterReader::Make(const QrParameters& parameters) {
  omp_set_max_active_levels(0);  // one thread: leave CPU to the robot's other programs
  auto engine = std::make_unique<Engine>();
  engine->api.SetVariable("debug_file", "/dev/null");
  const bool has_failed =
      engine->api.Init(nullptr, parameters.language.c_str(), tesseract::OEM_LSTM_ONLY) != 0;
  if (has_failed) {
    return Error{VisionCode(KeyCode::kDeviceError),
                 "Tesseract cannot load its model of the language '" + parameters.language +
                     "': install " + PackagesOf(parameters.language)};
  }
  engine->api.SetVariable("debug_file", "/dev/null");
  return std::unique_ptr<LetterReader>(new LetterReader(parameters, std::move(engine)));
}

LetterReader::LetterReader(QrParameters parameters, std::unique_ptr<Engine> engine)
    : parameters_(std::move(parameters)), engine_(std::move(engine)) {}

LetterReader::~LetterReader() = default;

std::vector<std::string> LetterReader::TextsOf(const cv::Mat& letters) const {
  std::vector<std::string> texts;
  for (const int page_mode : parameters_.page_modes) {
    texts.push_back(engine_->Text(letters, page_mode, parameters_.least_confidence));
  }
  return texts;
}

std::set<std::string> LetterReader::WordsOf(const cv::Mat& letters) const {
  std::set<std::string> words;
  for (const std::string& text : TextsOf(letters)) {
    for (const std::string& word : WordsOfLetters(text, parameters_.words)) words.insert(word);
  }
  return words;
}

LetterReader::LineRead LetterReader::ReadLine(const cv::Mat& grey, const cv::Rect& line) const {
  std::vector<std::string> texts;
  std::set<std::string> fitting;
  engine_->least_confidence_read = 100;
  for (const double letter_px : {30.0, 38.0}) {  // read best; one is read where the other is not
    const cv::Mat letters = LinePicture(grey, line, letter_px);
    for (const std::string& text : TextsOf(letters)) {
      texts.push_back(text);
      for (const std::string& word : WordsOfLetters(text, parameters_.words)) {
        if (GlyphsFit(letters, letter_px, word)) fitting.insert(word);
      }
    }
  }
  const std::set<std::string> all = WordsOfReadings(texts, parameters_.words);
  const bool has_word =
      std::any_of(all.begin(), all.end(), [](const auto& word) { return word != "?"; });
  const int confidence = engine_->least_confidence_read;
  if (all.size() > 1) return {all, true, confidence};
  return {fitting, has_word && fitting.empty(), confidence};
}

std::optional<LettersFound> LetterReader::Read(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  std::map<std::string, LettersFound> found;
  std::vector<cv::Rect> doubtful;  // a region does not know better what is there
  for (const TextLine& line : FindTextLines(grey)) {
    LineRead read;
    if (line.alone) read = ReadLine(grey, line.box);
    if (!line.alone || read.doubtful) doubtful.push_back(line.box);
    for (const std::string& word : read.words) {
      found.emplace(word, LettersFound{word, line.box, double(read.confidence)});
    }
    if (found.size() > 1) return std::nullopt;
  }
  for (const Region& region : parameters_.regions) {
    if (!found.empty()) break;
    const cv::Rect box = RectOf(region, grey.size());
    const bool is_doubtful =
        std::any_of(doubtful.begin(), doubtful.end(),
                    [&](const cv::Rect& line) { return !(line & box).empty(); });
    if (is_doubtful) continue;
    engine_->least_confidence_read = 100;
    const std::set<std::string> once = WordsOf(RegionPicture(grey, box, 2));
    if (once.size() == 1 && WordsOf(RegionPicture(grey, box, 1.6)) == once) {
      const double confidence = engine_->least_confidence_read;
      found.emplace(*once.begin(), LettersFound{*once.begin(), box, confidence});
    }
  }
  if (found.size() != 1) return std::nullopt;
  return found.begin()->second;
}

}  // namespace musher::vision
