#pragma once
// The word of a board: a QR code, or printed letters. Pure, but for the reader of letters, which
// keeps its model.
//
// Codes are read by ZXing, letters by Tesseract. A code has to contain exactly a word of the list.
// Letters are matched loosely, because they are misread easily: a text that contains the letters
// and digits of a word in their order, and at most `kMostExtra` other ones, is that word; the ones
// usually confused count as equal (1, I and l; 2 and Z; B and 8). A text that matches two words is
// none.
//
// Units: pixels, fractions of the picture. Threads: one call at a time for each TextReader.

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct QrParameters {
  std::vector<std::string> words{"A-1", "A-2", "B-1", "B-2"};
  int min_repeats = 1;             // pictures in a row that have to agree
  bool letters = true;             // read letters where no code is
  int letters_every = 5;           // only in each such picture without a code: reading is slow
  std::string language = "eng";    // a model of Tesseract, "chi_sim", or several: "eng+chi_sim"
  double least_confidence = 30;    // 0 to 100, of Tesseract
  std::vector<int> page_modes{7};  // Tesseract's: 6 a block, 7 a line, 8 a word, 13 a raw line
  std::vector<Region> regions{{0.05, 0.30, 0.35, 0.65},
                              {0.08, 0.25, 0.40, 0.60},
                              {0.00, 0.35, 0.30, 0.70},
                              {0.35, 0.65, 0.35, 0.65}};

  friend bool operator==(const QrParameters&, const QrParameters&) = default;
};

// The word that the code's content is, apart from spaces around it.
std::optional<std::string> WordOfCode(std::string_view content,
                                      const std::vector<std::string>& words);

// The word that the read letters are, see above.
std::optional<std::string> WordOfLetters(std::string_view text,
                                         const std::vector<std::string>& words);

// The first printable characters, at most 64, for a report; others are replaced by '?'.
std::string Excerpt(std::string_view text);

struct CodeFound {
  std::string content;  // UTF-8
  cv::Rect box;
};
std::optional<CodeFound> FindCode(const cv::Mat& bgr);

struct LettersFound {
  std::string word;
  cv::Rect box;  // where it was read
};

// Owns a Tesseract.
class TextReader {
 public:
  // Loads the model, which takes some tenths of a second. Fails with the name of the package to
  // install.
  static Result<std::unique_ptr<TextReader>> Make(const QrParameters& parameters);
  ~TextReader();

  // The first word that is read. Takes from 20 ms to some tenths of a second.
  std::optional<LettersFound> Read(const cv::Mat& bgr);

 private:
  struct Engine;
  TextReader(QrParameters parameters, std::unique_ptr<Engine> engine);

  QrParameters parameters_;
  std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
