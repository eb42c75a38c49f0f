#include <signal.h>

#include "musher/test/benchmark/common/board.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

constexpr int kRecoveryActuators = 4;
constexpr int kRecoveryHz = 50;

// What comes back of an actuator whose process is killed or hangs, step by step.
class Comeback {
 public:
  Comeback(ObservedController& controller, ActuatorIndex actuator)
      : before_(controller.Snapshot().actuators[actuator].report.pid),
        backtrace_(controller.Next([=](const action::Record& record, const Machine&) {
          return record.actuator == actuator && !record.data.empty();
        })),
        ended_(controller.Next([=](const action::Record&, const Machine& machine) {
          return machine.actuators[actuator].process.dead != 0 &&
                 machine.actuators[actuator].process.dead ==
                     machine.actuators[actuator].report.incarnation;
        })),
        started_(
            controller.Next([=, before = before_](const action::Record&, const Machine& machine) {
              const KnownActuator& known = machine.actuators[actuator];
              return known.process.pid != 0 && known.process.pid != before;
            })),
        back_(controller.Next([=, before = before_](const action::Record&, const Machine& machine) {
          const KnownActuator& known = machine.actuators[actuator];
          return known.report.pid != before && known.state() == kActive;
        })) {}

  pid_t before() const { return before_; }
  Time backtrace() { return MomentOf(backtrace_, "a backtrace"); }
  Time ended() { return MomentOf(ended_, "the end of a process"); }
  Time started() { return MomentOf(started_, "its restart"); }
  Time back() { return MomentOf(back_, "its return"); }

 private:
  const pid_t before_;
  std::future<Time> backtrace_;
  std::future<Time> ended_;
  std::future<Time> started_;
  std::future<Time> back_;
};

struct Times {
  std::vector<double> known;     // fault → on record
  std::vector<double> trace;     // → backtrace
  std::vector<double> end;       // → its end on record
  std::vector<double> start;     // → exec
  std::vector<double> own;       // → Start() has come back: the module's own start
  std::vector<double> join;      // → Active
  std::vector<double> whole;     // fault → Active
  std::vector<double> overhead;  // the whole but for what is the module's own, or the checkpoint
};

double Ms(Duration duration) {
  return ToSeconds(duration) * 1000;
}

Times OfKills(ObservedController& controller, const PerActuator<Board*>& boards, int rounds) {
  Times times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kRecoveryActuators));
    controller.AwaitAllThere();
    Comeback comeback(controller, actuator);
    const Time killed = std::chrono::steady_clock::now();
    kill(comeback.before(), SIGKILL);
    const Time ended = comeback.ended();
    const Time started = comeback.started();
    const Time back = comeback.back();
    const Time set_up = FromBoard(boards[actuator]->set_up_at);
    times.end.push_back(Ms(ended - killed));
    times.start.push_back(Ms(started - ended));
    times.own.push_back(Ms(set_up - started));
    times.join.push_back(Ms(back - set_up));
    times.whole.push_back(Ms(back - killed));
    times.overhead.push_back(Ms((back - killed) - (set_up - started)));
  }
  return times;
}

Times OfHangs(ObservedController& controller, const PerActuator<Board*>& boards, int rounds) {
  Times times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kRecoveryActuators));
    Board& board = *boards[actuator];
    controller.AwaitAllThere();
    AwaitCheckpoint(board);
    Comeback comeback(controller, actuator);
    auto known_then = controller.Next(IsOnRecord(actuator, Health::kHung));
    board.silent = true;
    const Time known = MomentOf(known_then, "a hang");
    const Time silent = FromBoard(board.checkpoint_at);
    const Time traced = comeback.backtrace();
    const Time ended = comeback.ended();
    board.silent = false;  // not before: an actuator that recovers is not killed
    const Time started = comeback.started();
    const Time back = comeback.back();
    const Time set_up = FromBoard(board.set_up_at);
    times.known.push_back(Ms(known - silent));
    times.trace.push_back(Ms(traced - known));
    times.end.push_back(Ms(ended - traced));
    times.start.push_back(Ms(started - ended));
    times.own.push_back(Ms(set_up - started));
    times.join.push_back(Ms(back - set_up));
    times.whole.push_back(Ms(back - silent));
    times.overhead.push_back(Ms((back - known) - (set_up - started)));
  }
  return times;
}

void PrintEnd(const Table& table, const Times& times) {
  table.Row("… → the next one is started", times.start, "ms");
  table.Row("… → it is set up: the module's own start", times.own, "ms");
  table.Row("… → Active", times.join, "ms");
}

}  // namespace

void Recovery(int rounds) {
  const Fleet fleet(
      [](const Fleet& self, const std::string& name) {
        return CommandKey(self.Module(name, kRecoveryHz)) + kUnlimitedRestartKeys +
               "restart_delay_ms = 0\ncheckpoint_ms = 200\n";
      },
      kRecoveryActuators);
  PerActuator<Board*> boards;
  for (const std::string& name : fleet.names()) boards.push_back(&OpenBoard(fleet.BoardFile(name)));
  ObservedController controller(fleet.config_file());
  const Table table("Recovery, restart_delay_ms = 0");
  const Times kills = OfKills(controller, boards, rounds);
  table.Row("kill -9 → Active", kills.whole, "ms");
  table.Row("kill -9 → its end is on record", kills.end, "ms");
  PrintEnd(table, kills);
  table.Row("all but the module's own start", kills.overhead, "ms", 100);
  const Times hangs = OfHangs(controller, boards, rounds);
  table.Row("last checkpoint (checkpoint_ms = 200) → Active", hangs.whole, "ms");
  table.Row("last checkpoint → hung is on record", hangs.known, "ms");
  table.Row("… → its backtrace", hangs.trace, "ms");
  table.Row("… → its end, after SIGKILL", hangs.end, "ms");
  PrintEnd(table, hangs);
  table.Row("hung → Active, all but the module's own start", hangs.overhead, "ms");
  table.Row("… of which the backtrace", Ratios(hangs.trace, hangs.overhead), "×");
}

}  // namespace musher::benchmark
