#pragma once
// The programs: files <name>.xml of a folder, and of a folder of examples that is only read, with
// the state of each. A program of the folder hides the example of its name.
//
//   ready ── Started ──→ running ── Ended ──→ succeeded | failed | stopped ── Started ──→ running
//   A file that is wrong is invalid, with all its errors, until it is replaced.
//
// The states of programs that have run are kept until the process ends. At most kMostPrograms.
// To add a program takes as long as its check and the disk, so it has three parts, of which a
// thread may do the middle one: BeginAdd(), the check and Store(), EndAdd(). Meanwhile a program of
// this name can not be added, run or removed.
//
// Threads: one at a time, but for Store().

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/result.hpp"

namespace musher::vp_engine {

inline constexpr std::size_t kMostPrograms = 200;
inline constexpr std::size_t kLargestProgram = std::size_t{1} << 20;  // bytes

enum class ProgramState { kReady, kRunning, kSucceeded, kFailed, kStopped, kInvalid };
std::string_view Name(ProgramState state);  // "ready"

struct Program {
  std::string name;
  ProgramState state = ProgramState::kReady;
  std::string message;  // why it failed, was stopped or is invalid
};

// Letters, digits, '_' and '-', of which '-' is not the first; at most 64.
bool IsProgramName(std::string_view name);

class Programs {
 public:
  // The errors of a program's text, a line each; empty: none.
  using Check = std::function<std::string(const std::string& name, const std::string& text)>;

  // `examples` empty: none.
  Programs(std::string folder, std::string examples, Check check)
      : folder_(std::move(folder)), examples_(std::move(examples)), check_(std::move(check)) {}

  // Makes the folder where it is missing.
  Result<> Open();

  std::vector<Program> List();  // by name
  Result<std::string> Text(const std::string& name) const;
  // The path for Store().
  Result<std::string> BeginAdd(const std::string& name, const std::string& text);
  // Replaces the program of this path, at once and as a whole; waits for the disk. Not where the
  // check has found errors.
  static Result<> Store(const std::string& path, const std::string& text) {
    return ReplaceFile(path, text);
  }
  // `errors`: of the check. The result for the person.
  Result<> EndAdd(const std::string& name, const std::string& text, const std::string& errors,
                  const Result<>& stored);
  Result<> Remove(const std::string& name);

  // The text of a program that may run now.
  Result<std::string> Runnable(const std::string& name);
  void Started(const std::string& name);
  void Ended(ProgramState state, const std::string& message);
  const std::string& running() const { return running_; }  // empty: none

 private:
  struct Known {
    ProgramState state = ProgramState::kReady;
    std::string message;
  };
  struct Checked {
    std::string text;
    std::string errors;
  };

  std::map<std::string, std::string> Paths() const;  // by name
  const std::string& Errors(const std::string& name, const std::string& text);
  Result<> WhileAdding(const std::string& name) const;  // an error: this one is being added
  Error Unknown(const std::string& name) const;
  std::string PathOf(const std::string& name) const { return folder_ + "/" + name + ".xml"; }

  const std::string folder_;
  const std::string examples_;
  const Check check_;
  std::map<std::string, Known> known_;      // those that have run
  std::map<std::string, Checked> checked_;  // by the text that was checked last
  std::set<std::string> adding_;
  std::string running_;
};

}  // namespace musher::vp_engine
