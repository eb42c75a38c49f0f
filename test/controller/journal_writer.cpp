// controller_journal_writer <path>: appends entries for ever, says "ready" once some are on disk,
// and waits to be killed.

#include <cstdio>
#include <string>

#include "musher/controller/journal/journal.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  musher::Journal journal(argv[1], {});
  for (std::int64_t n = 1;; ++n) {
    musher::JournalEntry entry;
    entry.wall_ns = n;
    entry.kind = "switch";
    journal.Append(std::move(entry));
    if (n % 100 != 0) continue;
    if (!journal.Flush(musher::Milliseconds(20000))) return 1;
    if (n == 100 && std::puts("ready") >= 0) std::fflush(stdout);
  }
}
