#pragma once
// The word of a board: a QR code, or printed letters. The functions are pure; a LetterReader keeps
// its model.
//
// Codes are read by ZXing, in the picture and half as large again. Of codes of 0.4 m from 0.6 to
// 3 m in rendered pictures it reads three of four so. A thorough look takes six times as long: it
// lets OpenCV find the corners of the code, and reads it after a rectification or at twice and
// three times the size, which reads the others.
//
// Letters are read by Tesseract, first where dark signs stand in a line on something light,
// cropped to that line and scaled to the size that is read best; then in fixed regions. (Fixed
// regions alone depend on the distance: the edge of a board in them is read as a letter, and small
// letters are not read at all.)
//
// Units: pixels, fractions of the picture. The regions are those of a course whose boards hang over
// the middle of the picture, or stand in it. Threads: one call at a time for each LetterReader.
// Errors: a model that is missing is an Error with the package to install.

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct QrParameters {
  std::vector<std::string> words{"A-1", "A-2", "B-1", "B-2"};  // see words.hpp
  int min_repeats = 1;             // pictures in a row that have to agree
  int thorough_every = 5;          // pictures without a code: then a thorough look, and letters
  bool letters = true;             // read letters where no code is
  std::string language = "eng";    // Tesseract's; "chi_sim", or several: "eng+chi_sim"
  double least_confidence = 60;    // 0 to 100, Tesseract's
  std::vector<int> page_modes{7};  // Tesseract's: 6 a block, 7 a line, 8 a word, 13 a raw line
  std::vector<Region> regions{{0.05, 0.30, 0.35, 0.65},
                              {0.08, 0.25, 0.40, 0.60},
                              {0.00, 0.35, 0.30, 0.70},
                              {0.35, 0.65, 0.35, 0.65}};

  friend bool operator==(const QrParameters&, const QrParameters&) = default;
};

struct CodeFound {
  std::string content;  // UTF-8
  cv::Rect box;
};

std::optional<CodeFound> FindCode(const cv::Mat& bgr);            // 4 ms
std::optional<CodeFound> FindCodeThoroughly(const cv::Mat& bgr);  // 25 ms

// Lines of dark signs on something light, the largest first, at most eight.
std::vector<cv::Rect> FindTextLines(const cv::Mat& grey);

struct LettersFound {
  std::string word;
  cv::Rect box;  // where it was read
};

class LetterReader {
 public:
  // Loads the model, which takes a tenth of a second and more.
  static Result<std::unique_ptr<LetterReader>> Make(const QrParameters& parameters);
  ~LetterReader();

  // The first word that is read; takes about 0.1 s of CPU where there is none.
  std::optional<LettersFound> Read(const cv::Mat& bgr);

 private:
  struct Engine;
  LetterReader(QrParameters parameters, std::unique_ptr<Engine> engine);

  const QrParameters parameters_;
  const std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
