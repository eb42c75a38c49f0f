#pragma once
// Writes down all that comes into a machine, one line each, so that replay.hpp can give it to
// another one again; and what followed, so that the two can be compared.
//
//   musher-fsm-recording 1 show       first of all, with the name of the machine
//   start 0 IDLE                      times are seconds since the first start
//   changed 0 0 "" IDLE started       tick, machine time, from, to, cause and command
//   input target "0.5 0.4 1.2"        what the application was given: see Input()
//   tick 0.02
//   command photo
//   force PHOTO
//   pause, reset, stop
//   restored                          the machine had gone on from a snapshot, which is not here:
//                                     such a recording is for people; ReadRecording() refuses it
//
// Words are bare where they can be, else in quotation marks with \", \\, \n and \x7f in them.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

class Recorder : public Listener {
 public:
  // Takes a line with its end. What it throws counts as a fault of a listener.
  using Sink = std::function<void(std::string_view line)>;

  // Listens to `machine`, which has not been started yet, as long as it lives.
  Recorder(Machine& machine, Sink sink);
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Something that states will look at is about to change: a message, a measurement. `text` is the
  // application's own. Call it wherever such a thing comes in, between ticks.
  void Input(std::string_view name, std::string_view text);

  void OnInput(const Machine& machine, const fsm::Input& input) override;
  void OnChange(const Machine& machine, const Change& change) override;

 private:
  void Write();

  Machine& machine_;
  const Sink sink_;
  std::optional<Time> first_start_;  // or first tick, of a machine that was restored
  bool running_ = false;             // by what was recorded
  std::string line_;
};

}  // namespace musher::fsm
