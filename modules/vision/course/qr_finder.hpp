#pragma once
// The word of a board: a QR code, or printed letters. The functions are pure; a LetterReader keeps
// its model.
//
// Codes are read by ZXing, in the picture and half as large again. Of codes of 0.4 m from 0.6 to
// 3 m in rendered pictures it reads three of four so. A thorough look takes six times as long: it
// lets OpenCV find the corners of the code, and reads it after a rectification or at twice and
// three times the size, which reads the others.
//
// Letters are read by Tesseract where dark signs stand in a line on a board: a light area without
// dents, of one brightness, mostly free of signs (the joints of a wall are a light area, too). Each
// line is cropped and scaled to the two sizes that are read best. Two words in one picture, or at
// the two sizes, are none; and none is read while the finder patterns of a code are seen, whose
// squares look like letters. Fixed regions are read where a config has them: they depend on the
// distance, and the edge of a board in them is read as a letter.
//
// Units: pixels, fractions of the picture. Threads: one call at a time for each LetterReader.
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
  int min_repeats = 1;             // pictures in a row whose codes have to agree
  int letter_repeats = 2;          // looks in a row whose letters have to agree
  int thorough_every = 5;          // pictures without a code: then a thorough look, and letters
  bool letters = true;             // read letters where no code is
  std::string language = "eng";    // Tesseract's; "chi_sim", or several: "eng+chi_sim"
  double least_confidence = 60;    // 0 to 100, Tesseract's
  std::vector<int> page_modes{7};  // Tesseract's: 6 a block, 7 a line, 8 a word, 13 a raw line
  std::vector<Region> regions;     // where letters are also read that stand on no board

  friend bool operator==(const QrParameters&, const QrParameters&) = default;
};

struct CodeFound {
  std::string content;  // UTF-8
  cv::Rect box;
};

std::optional<CodeFound> FindCode(const cv::Mat& bgr);            // 4 ms
std::optional<CodeFound> FindCodeThoroughly(const cv::Mat& bgr);  // 25 ms

// Whether the finder patterns of a code are seen, also where the code cannot be read. 10 ms.
bool ShowsCode(const cv::Mat& bgr);

// Lines of dark signs on a board, the largest first, at most eight.
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

  // The word that is read; nothing where there are two. Takes up to 0.2 s of CPU.
  std::optional<LettersFound> Read(const cv::Mat& bgr);

 private:
  struct Engine;
  LetterReader(QrParameters parameters, std::unique_ptr<Engine> engine);

  const QrParameters parameters_;
  const std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
