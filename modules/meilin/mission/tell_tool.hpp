#pragma once
// musher-meilin tell: a running match from the command line.
//
//   musher-meilin tell plan FILE.toml    publishes a drawn plan (plan/plan_file.hpp), and waits
//   until
//                                        the mission has accepted or refused it
//   musher-meilin tell reset             the match begins again, without a plan
//   musher-meilin tell state             execution_state, last_error and plan_id

namespace musher::meilin {

// `argv[0]` is "tell". Exit codes: 0 done; 1 refused, or no mission; 2 usage; 130 interrupted.
int Tell(int argc, const char* const* argv);

}  // namespace musher::meilin
