#pragma once
// Records all inputs of a machine, a line each, so that replay.hpp can replay them; and its
// changes, so that the two runs can be compared.
//
//   musher-fsm-recording 2 show       the first line, with the name of the machine
//   start 0 IDLE                      times are seconds since the first start
//   changed 0 0 "" IDLE started       tick, machine time, from, to, cause and command
//   input target "0.5 0.4 1.2"        an input of the application: see Input()
//   tick 0.02
//   command photo count 3             with the names and values of its data
//   inside SHOW photo 3 0.06 ASK TAKE decided      a change of the machine photo, which SHOW holds
//   force PHOTO
//   pause, reset, stop
//   restored                          the machine went on from a snapshot, which is not recorded:
//                                     such a recording is for people; ReadRecording() refuses it
//
// Words are bare where they can be, else in quotation marks with \", \\, \n and \x7f in them.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

class Recorder : public Listener, public InputListener {
 public:
  // Takes a line with its end. An exception of it counts as a listener fault.
  using Sink = std::function<void(std::string_view line)>;

  // Listens to `machine`, which has not been started yet, until it is destroyed.
  Recorder(Machine& machine, Sink sink);
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Records an input that states will read: a message, a measurement. `text` is in a format of the
  // application. Call it for each such input, between ticks.
  void Input(std::string_view name, std::string_view text);

  void OnInput(const Machine& machine, const fsm::Input& input) override;
  void OnChange(const Machine& machine, const Change& change) override;
  void OnChangeInside(const Machine& machine, const Machine& inside, const Change& change) override;

 private:
  void Write();

  Machine& machine_;
  const Sink sink_;
  std::optional<Time> first_start_;  // or first tick, of a machine that was restored
  bool running_ = false;             // according to the recorded inputs
  std::string line_;
};

}  // namespace musher::fsm
