#pragma once
// Which word of a list a code or a read text is. Pure.
//
// A code has to be exactly a word. Letters are misread easily, so that their match is loose: a text
// with the letters and digits of a word in their order, and at most two other ones, is that word.
// In a text with a dash, what is usually confused counts as equal: 1, I and L; 2 and Z
// (without the dash textures are read as words). A text that matches two words is none. An 8 is no
// B: a board 8-1 is not B-1.
//
// Threads: any.

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace musher::vision {

// Apart from white space around it.
std::optional<std::string> WordOfCode(std::string_view content,
                                      const std::vector<std::string>& words);

std::optional<std::string> WordOfLetters(std::string_view text,
                                         const std::vector<std::string>& words);

// All that the text matches: two of "A-1 A-2".
std::vector<std::string> WordsOfLetters(std::string_view text,
                                        const std::vector<std::string>& words);

// What several readings of one line match; a "?" is in it for a reading with letters or digits that
// is no word. Readings that contradict each other give two and more.
std::set<std::string> WordsOfReadings(const std::vector<std::string>& texts,
                                      const std::vector<std::string>& words);

// For a report: the first 64 characters, printable ASCII; each other byte is a '?'.
std::string Excerpt(std::string_view text);

// Which word is confirmed: one that several pictures in a row agree on.
class WordRepeats {
 public:
  explicit WordRepeats(int least) : least_(least) {}

  // The word of a picture, nothing for another picture that could be read. Returns the word while
  // it is confirmed.
  std::optional<std::string> OnPicture(const std::optional<std::string>& word);
  // A word that needs more pictures.
  bool is_pending() const { return word_ && in_row_ < least_; }

 private:
  const int least_;
  std::optional<std::string> word_;
  int in_row_ = 0;
};

}  // namespace musher::vision
