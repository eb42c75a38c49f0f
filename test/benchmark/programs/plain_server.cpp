// The command service without Musher:
//
//   benchmark_plain_server NAME DOMAIN ""            on one thread with a waitset
//   benchmark_plain_server NAME DOMAIN --hand-offs   with the hand-offs of an actuator: listener ->
//                                                    loop thread -> worker -> loop thread -> reply

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "musher/test/benchmark/common/plain_service.hpp"
#include "musher/test/benchmark/common/thread_queue.hpp"

namespace musher::benchmark {
namespace {

void Serve(const std::string& name, int domain) {
  const PlainParticipant participant(domain);
  const PlainEnd end(participant, name, PlainEnd::Role::kServer);
  PlainWaitset waitset(participant);
  waitset.Attach(end, 0);
  while (true) {
    for (std::int64_t sequence = end.Take(); sequence >= 0; sequence = end.Take()) {
      end.Answer(sequence);
    }
    waitset.Wait();
  }
}

void ServeWithHandOffs(const std::string& name, int domain) {
  const PlainParticipant participant(domain);
  ThreadQueue loop;
  ThreadQueue worker;
  PlainEnd* self = nullptr;
  const auto answer_all = [&] {
    for (std::int64_t sequence = self->Take(); sequence >= 0; sequence = self->Take()) {
      worker.Give([&, sequence] { loop.Give([&, sequence] { self->Answer(sequence); }); });
    }
  };
  // Not before the end is known on the loop.
  loop.Give([&] {
    self = new PlainEnd(participant, name, PlainEnd::Role::kServer, [&] { loop.Give(answer_all); });
  });
  while (true) pause();  // until killed
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc != 4) return EXIT_FAILURE;
  const bool hand_offs = std::string_view(argv[3]) == "--hand-offs";
  const auto serve = hand_offs ? musher::benchmark::ServeWithHandOffs : musher::benchmark::Serve;
  serve(argv[1], std::atoi(argv[2]));
}
