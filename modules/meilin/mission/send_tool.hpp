#pragma once
// musher-meilin send: a running match from the command line.
//
//   musher-meilin send plan FILE.toml    publishes a drawn plan (plan/plan_file.hpp), and waits
//   until
//                                        the mission has accepted or refused it
//   musher-meilin send reset             the match begins again, without a plan
//   musher-meilin send state             execution_state, last_error and plan_id

namespace musher::meilin {

// `argv[0]` is "send". Exit codes: 0 done; 1 refused, or no mission; 2 usage; 130 interrupted.
int Send(int argc, const char* const* argv);

}  // namespace musher::meilin
