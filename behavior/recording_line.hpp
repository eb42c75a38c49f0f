#pragma once
// The words, numbers and times in a line of a recording: of a state machine (fsm/recorder.hpp), and
// of a behaviour tree (tree/recorder.hpp).
//
// Words are bare where they can be, else in quotation marks with \", \\, \n and \x7f in them.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"

namespace musher {

// Puts a space before what it appends, but not at the beginning of a line.
void AppendWord(std::string& line, std::string_view word);
// Seconds, to the nanosecond, without needless zeros.
void AppendTime(std::string& line, Duration time);
void AppendNumber(std::string& line, std::uint64_t number);

// The words of one line. Throws Error ("file:line:column: error: ..."), which the reader of the
// file catches: a line is read in many steps.
class RecordingLine {
 public:
  RecordingLine(std::string_view line, const std::string& file, int number)
      : line_(line), file_(file), number_(number) {}

  bool AtEnd() const { return at_ == line_.size(); }
  std::string Word();
  Duration Seconds();  // as AppendTime() writes it
  std::uint64_t Number(std::uint64_t most);
  void End();

  // At the word that was read last.
  [[noreturn]] void Fail(const std::string& what) const;
  std::string_view rest() const { return line_.substr(at_); }

 private:
  [[noreturn]] void FailTime(const std::string& word) const;
  char Character();
  void Skip();

  std::string_view line_;
  const std::string& file_;
  const int number_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  // of what is being read
};

}  // namespace musher
