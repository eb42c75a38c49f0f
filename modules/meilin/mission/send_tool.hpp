#pragma once
// A running match from the command line.
//
//   musher-meilin send plan FILE.toml    publishes a drawn plan (plan/plan_file.hpp), and waits
//                                        until the mission has accepted or refused it
//   musher-meilin send reset             the robot stands, and the match waits for its start
//   musher-meilin send state             state, reason, plan, and what can begin
//   musher-meilin start [REGION]         begins: full, meilin or final; without: it goes on

namespace musher::meilin {

// `argv[0]` is "send". Exit codes: 0 done; 1 refused, or no mission; 2 usage; 130 interrupted.
int Send(int argc, const char* const* argv);
// The same; `argv[0]` is "start".
int StartTool(int argc, const char* const* argv);

}  // namespace musher::meilin
