#pragma once
// The word of a board: a QR code, or printed letters. FindCode() and FindPlates() are pure; a
// LetterReader keeps its model.
//
// Codes are read by ZXing, letters by Tesseract. Letters are read on plates first: light areas with
// dark signs in them, anywhere in the picture, each cropped to one line of signs and scaled to the
// size that Tesseract reads best. Then in fixed regions, where no plate stands out. (Fixed regions
// alone depend on the distance: the edge of a board is read as a letter, and small letters are not
// read at all.)
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
  bool letters = true;             // read letters where no code is
  int letters_every = 5;           // only in each such picture without a code: reading is slow
  std::string language = "eng";    // Tesseract's; "chi_sim", or several: "eng+chi_sim"
  double least_confidence = 40;    // 0 to 100, Tesseract's
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

std::optional<CodeFound> FindCode(const cv::Mat& bgr);

// A light area with a line of dark signs.
struct Plate {
  cv::Rect line;    // the signs that the plate surrounds
  Contour outline;  // of the plate, convex: a sign may touch its edge
};

// Those with the largest signs first, at most six.
std::vector<Plate> FindPlates(const cv::Mat& grey);

struct LettersFound {
  std::string word;
  cv::Rect box;  // where it was read
};

class LetterReader {
 public:
  // Loads the model, which takes a tenth of a second and more.
  static Result<std::unique_ptr<LetterReader>> Make(const QrParameters& parameters);
  ~LetterReader();

  // The first word that is read; takes some tens of milliseconds.
  std::optional<LettersFound> Read(const cv::Mat& bgr);

 private:
  struct Engine;
  LetterReader(QrParameters parameters, std::unique_ptr<Engine> engine);

  const QrParameters parameters_;
  const std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
