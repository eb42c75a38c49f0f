#pragma once
// The word of a board: a QR code, or printed letters. The functions are pure; a LetterReader keeps
// its model.
//
// Codes are read by ZXing, in the picture and half as large again; the largest counts. Of codes of
// 0.4 m from 0.6 to 3 m in rendered pictures it reads three of four so. A thorough look takes six
// times as long: it lets OpenCV find the corners of the code, and reads it after a rectification,
// by ZBar (zbar_codes.hpp), or at twice and three times the size, which reads the others; and it
// reads codes of light squares on dark ones.
//
// Letters are read by Tesseract where dark signs stand in a line on a board: a light area with four
// corners and without dents, of one brightness, mostly free of signs (the joints of a wall are a
// light area, too), and with one line of signs of that height. Each line is cropped and scaled to
// the two sizes that are read best. A word counts when what is read of them does not differ and the
// shapes of the signs fit it (glyphs.hpp). Two words in one picture, or of one line, are none; and
// none is read while the finder patterns of a code are seen, whose squares look like letters. Fixed
// regions are read where a config has them, and no line in them is in doubt: they depend on the
// distance, and the edge of a board in them is read as a letter.
//
// Units: pixels, fractions of the picture. Threads: one call at a time for each LetterReader.
// Errors: a model that is missing is an Error with the package to install.

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
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
  std::vector<CodeFound> smaller{};  // others that are read in the same picture
};

std::optional<CodeFound> FindCode(const cv::Mat& bgr);            // 4 ms
std::optional<CodeFound> FindCodeThoroughly(const cv::Mat& bgr);  // 30 ms

struct ThoroughLook {
  std::optional<CodeFound> code;
  bool shows_patterns = false;  // the finder patterns of a code, also where it cannot be read
};
ThoroughLook LookThoroughly(const cv::Mat& bgr);  // 30 ms

struct TextLine {
  cv::Rect box;
  bool alone = true;  // no other sign on its board is nearly as high: it has no second word
};

// Lines of dark signs on a board, the largest first, at most eight.
std::vector<TextLine> FindTextLines(const cv::Mat& grey);

struct LettersFound {
  std::string word;
  cv::Rect box;           // where it was read
  double confidence = 0;  // Tesseract's, 0 to 100: the least of the readings
};

class LetterReader {
 public:
  // Loads the model, which takes a tenth of a second and more.
  static Result<std::unique_ptr<LetterReader>> Make(const QrParameters& parameters);
  ~LetterReader();

  // The word that is read; nothing where there are two, and where it is not sure. Takes up to 0.2 s
  // of CPU.
  std::optional<LettersFound> Read(const cv::Mat& bgr);

 private:
  struct Engine;
  LetterReader(QrParameters parameters, std::unique_ptr<Engine> engine);

  struct LineRead {
    std::set<std::string> words;  // one whose signs fit it; all where the two sizes differ
    bool doubtful = false;        // a word was read that is not sure
    int confidence = 0;           // the least of the readings
  };

  // What Tesseract reads of prepared letters, one for each page mode; "" where it is not sure.
  std::vector<std::string> TextsOf(const cv::Mat& letters) const;
  std::set<std::string> WordsOf(const cv::Mat& letters) const;
  LineRead ReadLine(const cv::Mat& grey, const cv::Rect& line) const;

  const QrParameters parameters_;
  const std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
