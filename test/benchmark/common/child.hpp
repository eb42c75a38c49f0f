#pragma once
// Processes of a benchmark. A child is killed when the thread that started it exits, for any
// reason.

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

namespace musher::benchmark {

class Child {
 public:
  using Environment = std::map<std::string, std::string>;

  enum class Output { kOurs, kNowhere, kPiped };  // kNowhere: errors too

  // Starts the program argv[0] with `env` added to this environment. Ends the benchmark with a
  // message when that fails.
  explicit Child(const std::vector<std::string>& argv, const Environment& env = {},
                 Output output = Output::kOurs);
  // SIGKILL, and waits for its end.
  ~Child();
  Child(Child&& other) noexcept;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  // Waits for its end and gives its exit code; 128 + the signal that killed it.
  int Wait();
  // Waits until a piped child prints something, or ends the benchmark when it exits without.
  void AwaitOutput() const;

 private:
  pid_t pid_ = 0;
  int pipe_ = -1;
};

// A program of the folder that the running program is in.
std::string Program(const std::string& name);

// Ends the benchmark with a message.
[[noreturn]] void Fail(const std::string& why);

// Makes a process that another process (a controller) starts for the benchmark exit with its
// starter.
void DieWithParent();

// A DDS domain that only this run is in, up to its end: processes of an earlier run, killed, are
// still known in theirs. `number` distinguishes up to 60 domains of a run; then they repeat.
int Domain(int number = 0);

// The next of these domains. This process and its children join it from now on.
int NextDomain();

}  // namespace musher::benchmark
